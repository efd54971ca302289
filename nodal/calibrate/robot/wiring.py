"""Finding out which way each tendon bends the robot, before anything is homed: pulled until it is seen, and let back."""

import dataclasses
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from calibration.robot_wiring import Wired, turned_rad, wired
from controller.kinematics import Kinematics
from controller.settings import ControllerSettings
from drivers.dynamixel.settings import AxisSettings
from nodal.calibrate.robot.leading import Leader
from nodal.errors import RobotStoppedError

Array = NDArray[np.float64]

STEP_MM = 0.5
SURE = 8.0
"""A nodal point must have moved by so many standard deviations to have moved."""
CLEAR = 2.0
"""A pull goes on until the robot has moved so many times as far as homing waits for: then its direction is sure."""
WORTH_SAYING_RAD = np.radians(15.0)
SAME_TURN = 0.9


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Wiring:
    """How all axes are wired; `turned_rad` is by how much the whole robot bends beside the drawing's directions."""

    axes: tuple[Wired, ...]
    turned_rad: float

    @property
    def reversed(self) -> tuple[int, ...]:
        """Axes whose sign is wrong."""
        return tuple(axis.axis for axis in self.axes if axis.reversed)


def find_wiring(
    leader: Leader, settings: ControllerSettings, kinematics: Kinematics, axes: Sequence[AxisSettings]
) -> Wiring:
    """Pull each tendon of a robot that is not homed; raises RobotStoppedError naming an axis that nothing follows, or that is
    another's.
    """
    seen, arc_mm = [], np.zeros(0)
    for axis, of_axis in enumerate(axes):
        motion, arc_mm = leader.patiently(
            partial(_pulled, leader, settings, axis, of_axis), anew=leader.let_go
        )
        seen.append(motion)
    straight = kinematics.nodes_and_jacobian(np.zeros(kinematics.axes), arc_mm)[1]
    drawn = np.moveaxis(straight, -1, 0)[: kinematics.tendons]
    found = wired(np.array(seen), drawn)
    turned, left = turned_rad(np.array(seen), drawn)
    _check(found, turned, left, axes)
    return Wiring(axes=found, turned_rad=turned)


def _pulled(
    leader: Leader, settings: ControllerSettings, axis: int, of_axis: AxisSettings
) -> tuple[Array, Array]:
    """(k, 3) how nodal points moved with a pull, and where along the robot they are; the axis is where it was afterwards."""
    homing = settings.homing
    rest = leader.stand()
    begin_mm = float(leader.command_mm()[axis])
    surely_mm = SURE * rest.sigma_mm
    for way in (1.0, -1.0):
        pulled_mm, motion = 0.0, np.zeros_like(rest.node_mm)
        far_mm = np.zeros(len(rest.node_mm))
        while (
            pulled_mm < homing.search_mm
            and not (far_mm > np.maximum(CLEAR * homing.seen_mm, surely_mm)).any()
        ):
            pulled_mm = min(pulled_mm + STEP_MM, homing.search_mm)
            leader.move(axis, begin_mm + way * pulled_mm)
            motion = leader.stand().node_mm - rest.node_mm
            far_mm = np.linalg.norm(motion, axis=1)
        leader.move(axis, begin_mm)
        if (far_mm > np.maximum(homing.seen_mm, surely_mm)).any():
            return way * motion, rest.arc_mm
    raise RobotStoppedError(
        f"{leader.name(axis)} ({of_axis.name}) was moved by {homing.search_mm:g} mm either way, and the robot did not follow",
        f"its tendon is slack or snapped, or servo {of_axis.id} is not the one that pulls it: see it turn "
        f"(nodal do jog {axis + 1} 1), tighten the tendon, correct its id in [servos]",
    )


def _check(found: Sequence[Wired], turned: float, left: float, axes: Sequence[AxisSettings]) -> None:
    """Raises RobotStoppedError where a sign alone does not put it right."""
    if all(axis.reversed for axis in found):
        raise RobotStoppedError(
            "all tendons bend the robot the other way",
            "either the robot frame is turned by 180 degrees (nodal calibrate base), or mm_per_rad of every tendon in [servos] has "
            "the wrong sign: cameras cannot tell the two apart. Jog one (nodal do jog 1 1), see which of its tendons is pulled, and "
            "correct that one cause",
        )
    misplaced = [axis for axis in found if axis.misplaced]
    strange = [axis for axis in found if not axis.alike]
    whole = ""
    if left > SAME_TURN and abs(turned) > WORTH_SAYING_RAD:
        whole = (
            f"the whole robot bends {np.degrees(turned):.0f} deg from where it is drawn, counted from +X to +Y: "
            "the robot frame is turned (nodal calibrate base), or all angles in controller.sections are"
        )
    if misplaced:
        words = "; ".join(
            f"tendon {axis.axis + 1} ({axes[axis.axis].name}) bends the robot as tendon {axis.pulls + 1} "
            f"({axes[axis.pulls].name}) should{', the other way round' if axis.backwards else ''}"
            for axis in misplaced
        )
        raise RobotStoppedError(
            words, "exchange their id in [servos], or their cables" + (f"; or else {whole}" if whole else "")
        )
    if strange:
        words = "; ".join(
            f"tendon {axis.axis + 1} ({axes[axis.axis].name}) bends the robot as no tendon of the drawing does "
            f"(nearest is tendon {axis.pulls + 1}, cosine {axis.cosine:.2f})"
            for axis in strange
        )
        raise RobotStoppedError(
            words,
            whole or "check the angles in controller.sections and the robot frame (nodal calibrate base)",
        )
