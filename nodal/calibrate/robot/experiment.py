"""The whole experiment on a homed robot: each axis alone, all together, and moves that nobody fits anything to."""

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibration.robot_plan import Plan, Reach, planned
from controller.kinematics import Kinematics
from controller.plant import Plant
from controller.settings import ControllerSettings
from messaging.settings import RobotSettings
from nodal.calibrate.robot.leading import SETTLED_S, Leader
from nodal.calibrate.robot.standing import Stand
from nodal.calibrate.robot.walking import Run, Walk

Array = NDArray[np.float64]

TOGETHER, HELD_OUT = 16, 8
STAGE_SHARE = 0.2
"""How far the stage moves, of its travel."""
HOMING_S, LOOK_S = 12.0, SETTLED_S + 0.3
PULL_S = 5.0
"""Roughly: homing, one look, and what it takes to find the direction of one axis."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """What was seen in the runs after each homing."""

    runs: tuple[Run, ...]
    alone: tuple[Stand, ...]
    """Where the robot stood while each axis was moved alone, with its currents."""
    refused: tuple[str, ...]
    """Why poses were not reached, each in the controller's words."""


def reach(settings: ControllerSettings, share: float, stage_mm: float | None) -> Reach:
    """How far axes may go: this share of the tendons' travel, and a little of the stage's, from where it stands."""
    tendon_mm = share * settings.limits.displacement_mm
    if stage_mm is None:
        return Reach(tendon_mm=tendon_mm, stage_mm=())
    low_mm, high_mm = settings.limits.insertion_mm
    step_mm = min(STAGE_SHARE * (high_mm - low_mm), settings.jog.at_most_mm)
    there_mm = stage_mm + step_mm if stage_mm + step_mm <= high_mm else stage_mm - step_mm
    return Reach(tendon_mm=tendon_mm, stage_mm=(stage_mm, there_mm))


def plan_for(settings: ControllerSettings, robot: RobotSettings, within: Reach) -> Plan:
    """Where this robot is led; raises ControllerSetupError."""
    kinematics = settings.kinematics(robot)
    tendons, bends = kinematics.tendons, 2 * len(kinematics.length_mm)
    paired = Plant.of(settings, robot).antagonistic[:tendons]
    return planned(kinematics.command_of_coordinates[:tendons, :bends], paired, within, TOGETHER, HELD_OUT)


def seconds(plan: Plan, settings: ControllerSettings) -> float:
    """How long it takes, about, without what it takes to start processes."""
    poses = np.concatenate([plan.alone_mm, plan.together_mm, plan.held_out_mm])
    travel_mm = np.abs(np.diff(poses, axis=0)).sum()
    tendons = sum(len(section.angle_deg) for section in settings.sections)
    return float(travel_mm / settings.jog.mm_s + LOOK_S * len(poses) + 2 * HOMING_S + PULL_S * tendons)


def experiment(leader: Leader, plan: Plan, tell: Callable[[str], None]) -> Seen:
    """Home, each axis alone, home again, all together, and the moves that are held out; raises RobotStoppedError.

    `tell` is told what is done.
    """
    walk = Walk(leader, tell)
    tell("homing")
    walk.home()
    alone = walk.through(plan.alone_mm, "each axis alone")
    walk.back(plan.alone_mm[-1])
    tell("homing again: how far one homing is from another")
    walk.home()
    walk.through(plan.together_mm, "all together")
    walk.through(plan.held_out_mm, "moves to be foreseen", held_out=True)
    walk.back(plan.alone_mm[-1])
    return Seen(runs=walk.runs, alone=tuple(alone), refused=tuple(walk.refused))


def current_ma(seen: Seen, kinematics: Kinematics) -> tuple[Array, Array]:
    """(D,) of each tendon axis: the current at rest near its zero, and by how much it differs between coming to it from either
    side, both from the poses in which each axis was moved alone; NaN where it came from one side only.
    """
    positions = np.array([stand.position_mm for stand in seen.alone])
    currents = np.array([stand.current_ma for stand in seen.alone])
    rest, between = np.full(kinematics.tendons, np.nan), np.full(kinematics.tendons, np.nan)
    furthest = np.abs(positions).max(axis=0)
    for axis in range(kinematics.tendons):
        moved = np.flatnonzero(np.abs(np.diff(positions[:, axis])) > 0.1 * furthest[axis])
        home = [row + 1 for row in moved if abs(positions[row + 1, axis]) < 0.1 * furthest[axis]]
        if not home:
            continue
        rest[axis] = currents[home, axis].mean()
        down = [currents[row, axis] for row in home if positions[row - 1, axis] > 0]
        up = [currents[row, axis] for row in home if positions[row - 1, axis] < 0]
        if down and up:
            between[axis] = abs(np.mean(up) - np.mean(down))
    return rest, between
