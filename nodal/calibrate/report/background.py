"""The scene without the robot."""

from nodal.calibrate.background.keeping import FILE, BackgroundFound
from nodal.calibrate.report.material import Material
from nodal.report.page.markup import Content, element, table

TITLE = "Background"


def content(known: Material) -> Content:
    """What each camera's picture without the robot tells."""
    found = known.found(FILE, BackgroundFound)
    if found is None:
        return None
    return [
        element("p", f"Taken {found.made_at}, with the stage {_stage(found)}."),
        table(
            "Backgrounds",
            ["", "pictures", "red, green, blue", "noise", "flicker", "uneven", "clipped", "spots"],
            (
                (
                    one.camera,
                    str(one.pictures),
                    ", ".join(f"{level:.0f}" for level in one.level),
                    f"{one.tile_noise:.1f} levels",
                    f"{100 * one.flicker:.2f} %",
                    f"{100 * one.unevenness:.0f} %",
                    f"{100 * one.clipped_share:.1f} %",
                    str(len(one.spots)),
                )
                for one in found.cameras
            ),
            class_="figures",
        ),
        element("div", known.drawn("background-{}-judged.jpg"), class_="moments"),
    ]


def _stage(found: BackgroundFound) -> str:
    if not found.insertion_known:
        return "where nobody said, as no controller ran"
    return f"at {found.insertion_mm:.1f} mm"
