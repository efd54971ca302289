"""What `nodal calibrate background` found, as people read it."""

from collections.abc import Iterator, Sequence

from nodal.calibrate.background.judging import CameraBackground
from nodal.calibrate.background.robot import RobotSeen
from nodal.calibrate.background.warnings import warnings

UNHEARD = " (no controller runs that says where the stage stands; that is no fault here)"


def words(cameras: Sequence[CameraBackground], robot: RobotSeen | None) -> Iterator[str]:
    """One line after the other."""
    for one in cameras:
        yield f"camera {one.camera}: mean of {one.pictures} pictures"
        yield f"  level {_levels(one.level, '.0f')}, noise {_levels(one.noise, '.2f')} (red, green, blue)"
        yield f"  light uneven by {one.unevenness:.0%} within reach, flicker {one.flicker:.2%}, too bright {one.clipped_share:.2%}, spots {len(one.spots)}"
        if one.work_area is not None:
            yield f"  work area with {len(one.work_area)} corners, from what the robot can reach"
        for warning in warnings(one):
            yield f"  mind: {warning}"
    if robot is not None:
        yield from _robot(robot)


def _robot(robot: RobotSeen) -> Iterator[str]:
    for contrast in robot.contrasts:
        if contrast.threshold is None:
            yield f"the robot before it, {contrast.refusal}"
        else:
            yield (
                f"the robot before it, camera {contrast.camera}: colour distance {contrast.robot:.0f} at its base, backdrop "
                f"{contrast.backdrop:.1f}; sensing takes the threshold {contrast.threshold:.0f}"
            )
    if robot.refusal:
        yield f"sensing sees no shape: {robot.refusal}"
    else:
        flags = ", ".join(robot.flags) or "none"
        yield f"sensing sees a robot of {robot.length_mm:.2f} mm; flags: {flags}{UNHEARD if 'base_unknown' in robot.flags else ''}"


def _levels(colour: tuple[float, float, float], form: str) -> str:
    return " ".join(format(level, form) for level in colour)
