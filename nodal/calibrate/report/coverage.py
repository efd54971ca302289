"""Where in the pictures corners were seen, and by how much each was missed."""

from xml.etree.ElementTree import Element

import numpy as np

from calibration.camera_set import CalibratedCamera
from nodal.calibrate.report.material import HIGHEST_PX, Material
from nodal.report.page.markup import Content, element, figure
from nodal.report.page.overlaid import picture_svg

TITLE = "Coverage"
ARROW = 1 / 40
"""How long a line of the size of the RMS is drawn, at most, in heights of the picture."""
LEAST_PX = 1e-3
SEEN, MISSED = "#45b8ff", "#ff5470"


def content(known: Material) -> Content:
    """A picture of each camera with all corners of all views."""
    pictures = [
        picture for camera in known.cameras.cameras if (picture := _picture(known, camera)) is not None
    ]
    if not pictures:
        return None
    return [
        element(
            "p",
            "Every corner of every view, over the last one. Lines lead to where the solution has it, and are drawn too long by "
            "far: they should point every way. Where they agree over a part of the picture, the lens is not described there.",
        ),
        element("div", pictures, class_="moments"),
        element("h3", "Missing"),
        element("ul", [element("li", words) for words in known.cameras.missing])
        if known.cameras.missing
        else element("p", "The views show all that is wanted."),
    ]


def _picture(known: Material, camera: CalibratedCamera) -> Element | None:
    sightings = [
        one for one in known.kept.of_camera(camera.name) if camera.name in known.pictures.get(one.view, {})
    ]
    if not sightings:
        return None
    px = np.concatenate([one.px for one in sightings])
    residual_px = np.concatenate([one.residual_px for one in sightings])
    times = _exaggeration(float(np.sqrt(np.mean(residual_px**2))), camera.height_px)
    away_px = -times * residual_px
    stroke = camera.height_px / 400
    lines = "".join(
        f"M{x:.1f} {y:.1f}l{dx:.1f} {dy:.1f}" for (x, y), (dx, dy) in zip(px, away_px, strict=True)
    )
    dots = "".join(f"M{x:.1f} {y:.1f}h.1" for x, y in px)
    overlay = [
        element("path", d=lines, style=f"stroke:{MISSED};stroke-width:{stroke:.2f}"),
        element("path", d=dots, style=f"stroke:{SEEN};stroke-width:{4 * stroke:.2f};stroke-linecap:round"),
    ]
    words = f"camera {camera.name}: {len(px)} corners of {len(sightings)} views, residuals {times} times as long as they are"
    picture = known.picture(sightings[-1].view, camera.name)
    return figure(picture_svg(picture, words, overlay, highest_px=HIGHEST_PX), words)


def _exaggeration(rms_px: float, height_px: int) -> int:
    """A power of ten that makes the lines visible."""
    return int(10 ** np.floor(np.log10(max(ARROW * height_px / max(rms_px, LEAST_PX), 1.0))))
