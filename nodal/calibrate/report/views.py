"""The views themselves: some with the corners that were found, and every rejected one with the reason."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from nodal.calibrate.report.material import Material
from nodal.report.page.markup import Content, element, figure, table
from nodal.report.page.overlaid import picture_svg

TITLE = "Views"
MOST_SHOWN = 8
HIGHEST_PX = 200
STROKE = 1 / 200


def content(known: Material) -> Content:
    """Evenly chosen views, then the rejected ones."""
    used = [view for view in known.pictures if view in known.kept.rig_from_board]
    rejected = known.cameras.views_rejected
    if not used and not rejected:
        return None
    chosen = used[:: max(1, -(-len(used) // MOST_SHOWN))]
    return [
        element("div", [_thumbnails(known, view, f"view {view}") for view in chosen], class_="moments"),
        [
            element("h3", "Rejected"),
            table("Rejected views", ["view", "why"], list(rejected.items())),
            element(
                "div",
                [
                    _thumbnails(known, view, f"view {view}")
                    for view in list(rejected)[:MOST_SHOWN]
                    if view in known.pictures
                ],
                class_="moments",
            ),
        ]
        if rejected
        else element("p", "No view that was taken was rejected."),
    ]


def _thumbnails(known: Material, view: str, words: str) -> Element:
    """One view in all cameras."""
    return figure(
        element("div", [_thumbnail(known, view, camera) for camera in known.pictures[view]], class_="views"),
        words,
    )


def _thumbnail(known: Material, view: str, camera: str) -> Element:
    picture = known.picture(view, camera)
    found: Sequence[tuple[float, float]] = next(
        (one.px for one in known.kept.of_camera(camera) if one.view == view), ()
    )
    stroke = picture.shape[0] * STROKE
    corners = "".join(
        f"M{x - 2 * stroke:.0f} {y:.0f}h{4 * stroke:.0f}M{x:.0f} {y - 2 * stroke:.0f}v{4 * stroke:.0f}"
        for x, y in found
    )
    overlay = [element("path", d=corners, style=f"stroke-width:{stroke:.1f}")]
    return picture_svg(
        picture, f"view {view}, camera {camera}, {len(found)} corners", overlay, highest_px=HIGHEST_PX
    )
