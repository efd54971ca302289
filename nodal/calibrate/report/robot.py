"""What was identified of the robot's drive, and how well its moves are foreseen without feedback."""

from nodal.calibrate.report.material import Material
from nodal.calibrate.robot.calibrating import ROBOT
from nodal.calibrate.robot.results import RobotFound
from nodal.report.page.markup import Content, element, table
from nodal.report.page.numbers import with_unit

TITLE = "Robot"


def content(known: Material) -> Content:
    """A row for each axis, and one for each nodal point."""
    found = known.found(ROBOT, RobotFound)
    if found is None:
        return None
    held_out = found.held_out
    doubt = [element("p", f"Not written into the bench file: {found.doubt}.")] if found.doubt else []
    return [
        *doubt,
        element(
            "p",
            f"Identified {found.date} from {found.poses} poses, fitted to {with_unit(found.fit_rms_mm, 'mm')} RMS. Values with ± "
            f"are standard deviations. Signs that were corrected: {', '.join(found.reversed) or 'none'}.",
        ),
        table(
            "Axes",
            ["", "bends, drawn = 1", "lost motion", "current at rest", "current between both ways"],
            (
                (
                    axis.name,
                    f"{axis.gain:.3f} ± {axis.gain_sigma:.3f}",
                    f"{axis.lost_motion_mm:.2f} ± {with_unit(axis.lost_motion_sigma_mm, 'mm')}",
                    with_unit(axis.current_at_rest_ma, "mA"),
                    with_unit(axis.current_between_ways_ma, "mA"),
                )
                for axis in found.axes
            ),
            class_="figures",
        ),
        element("h3", f"Foreseen without feedback, {held_out.poses} moves that nothing was fitted to, RMS"),
        table(
            "Foreseen",
            ["", "as drawn", "as identified"],
            (
                *(
                    (node.name, with_unit(node.before_mm, "mm"), with_unit(node.after_mm, "mm"))
                    for node in held_out.nodes
                ),
                ("all", with_unit(held_out.before_mm, "mm"), with_unit(held_out.after_mm, "mm")),
            ),
            class_="figures",
        ),
    ]
