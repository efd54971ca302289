"""What accuracy these cameras allow at the robot."""

from nodal.calibrate.report.material import Material
from nodal.calibration.show.figures import MEASURED_PX
from nodal.report.page.markup import Content, element, table
from nodal.report.page.numbers import with_unit

TITLE = "Accuracy to expect"


def content(known: Material) -> Content:
    """Of each camera what a pixel is, of every two what a tenth of a pixel is."""
    figures = known.figures
    return [
        element(
            "p",
            f"All of it {figures.place}. A midline is found to about {MEASURED_PX:g} px in a clean picture.",
        ),
        table(
            "Cameras",
            ["", "distance", "one pixel", "sees across", "sees down"],
            (
                (
                    camera.name,
                    with_unit(camera.distance_mm, "mm"),
                    with_unit(camera.mm_per_px, "mm"),
                    with_unit(camera.field_of_view_deg[0], "°"),
                    with_unit(camera.field_of_view_deg[1], "°"),
                )
                for camera in figures.cameras
            ),
            class_="figures",
        ),
        table(
            "Pairs",
            ["", "baseline", "angle", f"{MEASURED_PX:g} px across", f"{MEASURED_PX:g} px in depth"],
            (
                (
                    " and ".join(pair.names),
                    with_unit(pair.baseline_mm, "mm"),
                    with_unit(pair.angle_deg, "°"),
                    with_unit(pair.across_mm, "mm"),
                    with_unit(pair.depth_mm, "mm"),
                )
                for pair in figures.pairs
            ),
            class_="figures",
        ),
    ]
