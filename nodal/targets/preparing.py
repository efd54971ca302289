"""From what was asked to the target that is sent: slowed down where its timing is ours, led around regions, and checked."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from controller.errors import TooCloseError
from controller.limits import axis_name
from controller.planning.plan import plan
from controller.planning.space import Space
from controller.planning.timing import Timing
from controller.plant import Plant
from controller.reachability import check_target, demands
from controller.settings import ControllerSettings
from messaging.control import Target
from nodal.errors import CommandError
from nodal.targets.curves import line
from nodal.targets.pace import Pace
from nodal.targets.present import Present

Array = NDArray[np.float64]

_BUSY = 0.95
"""Share of speeds and rates that a target asks for when its timing is ours."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Asked:
    """What the operator wants. `timing_is_ours` when nothing was said of how fast."""

    make: Callable[[Present], Target]
    timing_is_ours: bool
    timing: Timing = Timing.MINIMUM_JERK
    acceleration_mm_s2: float | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Prepared:
    """A target that may be sent, and in words what was done to it."""

    target: Target
    notes: tuple[str, ...]


def prepared(
    asked: Asked,
    present: Present,
    plant: Plant,
    settings: ControllerSettings,
    *,
    planned: bool | None,
) -> Prepared:
    """`planned`: always, never, or (None) when the straight way leads too near to a region; never is to be refused then.

    Raises TargetError, CommandError.
    """
    target, arcs = asked.make(present), present.node_arc_mm
    notes: list[str] = []
    if asked.timing_is_ours and len(target.time_s) > 1:
        busy = _busy(target, present, plant, settings)
        if busy > _BUSY:
            target = dataclasses.replace(
                target, time_s=target.time_s * busy / _BUSY, repeat_from_s=target.repeat_from_s * busy / _BUSY
            )
            notes.append(
                f"slowed down {busy / _BUSY:.2f} times, to {target.time_s[-1]:.1f} s: that is as fast as it goes"
            )
    if not planned:
        straight_on = None
        if all(name in present.node_mm for name in target.node_names):
            straight_on = np.array([present.node_mm[name] for name in target.node_names])
        try:
            check_target(target, arcs, plant, settings, start_mm=straight_on)
            return Prepared(target=target, notes=tuple(notes))
        except TooCloseError:
            if planned is False:
                raise
    if asked.acceleration_mm_s2 is not None:
        raise CommandError(
            f"target {target.name}: a way to its beginning must be planned, and a planned way does not keep to an acceleration "
            f"of {asked.acceleration_mm_s2:g} mm/s²; go to its beginning first (`nodal target point`), or leave the acceleration out"
        )
    found = plan(target, arcs, present.configuration, plant, settings, timing=asked.timing)
    around = f"around regions, {found.spare_mm:.1f} mm to spare" if len(plant.regions) else "straight on"
    notes.append(
        f"a way of {found.way_s:.1f} s from {present.words} leads to its beginning, {around} ({found.way.samples} samples)"
    )
    return Prepared(target=found.target, notes=tuple(notes))


def _busy(target: Target, present: Present, plant: Plant, settings: ControllerSettings) -> float:
    asked = demands(target, present.node_arc_mm, Space(plant), settings.reachable_within_mm)
    speed = asked.looks.speed_mm_s.max() / settings.maximum_node_speed_mm_s
    return float(max(np.abs(asked.rate_share).max(), speed))


def summary(target: Target, present: Present, plant: Plant, settings: ControllerSettings) -> str:
    """What a target that was found possible asks of the robot, one thing a line; raises TargetError."""
    asked = demands(target, present.node_arc_mm, Space(plant), settings.reachable_within_mm)
    lines = [f"by the model, nodal points come within {asked.missed_mm.max():.2f} mm of where they should be"]
    if len(target.time_s) > 1:
        axis = int(np.abs(asked.rate_share).max(axis=0).argmax())
        rounds = f", of which the last {target.time_s[-1] - target.repeat_from_s:.1f} s repeat"
        lines.append(f"it takes {target.time_s[-1]:.1f} s{rounds if target.repeat else ''}")
        lines.append(
            f"the fastest nodal point moves at {asked.looks.speed_mm_s.max():.1f} of "
            f"{settings.maximum_node_speed_mm_s:g} mm/s, and {axis_name(axis, plant.kinematics.tendons)} "
            f"at {100 * np.abs(asked.rate_share).max():.0f} % of its rate"
        )
    if asked.nearest is not None:
        lines.append(
            f"the body keeps {asked.nearest.spare_mm:.1f} mm more than it must away from region {asked.nearest.region}, "
            f"nearest {asked.nearest.arc_mm:g} mm along it"
        )
    return "\n".join(lines)


def jogged(name: str, by_mm: Sequence[float], present: Present, pace: Pace) -> Target:
    """One nodal point moved by so much from where it is; raises CommandError."""
    start_mm = _place_of(name, present)
    return dataclasses.replace(line(name, start_mm, start_mm + np.array(by_mm), pace), name="jog")


def moved(target: Target, present: Present, pace: Pace) -> Target:
    """Nodal points brought from where they are to the places of this target, all at once; raises CommandError."""
    start_mm = np.array([_place_of(name, present) for name in target.node_names])
    way_mm = target.position_mm[0] - start_mm
    longest_mm = np.linalg.norm(way_mm[target.weights > 0], axis=-1).max()
    time_s, share = pace.spent(float(longest_mm))
    return dataclasses.replace(target, time_s=time_s, position_mm=start_mm + share[:, None, None] * way_mm)


def _place_of(name: str, present: Present) -> Array:
    if name not in present.node_mm:
        raise CommandError(f"no nodal point {name}; known are {', '.join(present.node_mm)}")
    return present.node_mm[name]
