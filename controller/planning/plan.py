"""From the present shape to a target, clear of regions along the whole body: the way and the target, as one target. Pure.

The way is led through all nodal points that are known, so that the whole shape follows it. It is to be computed beside the
loop: it takes as long as it takes.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from controller.easing import EASING_S, Stretch
from controller.errors import NoWayError
from controller.path import along
from controller.planning.search import Search, Way
from controller.planning.solving import Wanted, bent_starts, shortfall, solve
from controller.planning.space import Space, interpolated
from controller.planning.timing import Timing
from controller.plant import Plant
from controller.reachability import Demands, check_target, demands, say_too_close
from controller.regions import Regions
from controller.settings import ControllerSettings
from messaging.control import Target

Array = NDArray[np.float64]

GUIDE_WEIGHT = 0.02
"""Of nodal points that only keep the body on its way, beside the heaviest of the target's own."""
_MARGIN_MM = 0.5
"""How much farther away from regions than it must the body is led, if both ends allow it."""
_PACE = 0.8
"""Share of the allowed speeds and rates that a way uses at most."""
_MOMENTS_PER_S = 20
_LEAST_MOMENTS, _MOST_MOMENTS = 12, 300
_MOST_SAMPLES = 4000
_CLOSE_MM = 0.05
_EASED_MOMENTS = 7
_LEAST_S = 1e-9


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """What was found."""

    target: Target
    """The way, and from `way_s` on the target itself."""
    way_s: float
    way: Way
    spare_mm: float
    """How much more than it must the body keeps away from regions on the way."""


def present_shape(space: Space, place_mm: Array, arc_mm: Array, insertion_mm: float) -> Array:
    """(C,) the configuration that fits points (m, 3) seen at arc lengths (m,) best, the stage near where it is known to be."""
    wanted = Wanted(place_mm=place_mm[None], arc_mm=arc_mm, weights=np.ones(len(arc_mm)))
    bare = Space(dataclasses.replace(space.plant, regions=Regions(())))
    fitting: Array = solve(bare, wanted, space.straight(insertion_mm)[None], near_enough_mm=_CLOSE_MM)[0]
    return fitting


def plan(
    target: Target,
    node_arc_mm: Mapping[str, float],
    present: Array,
    plant: Plant,
    settings: ControllerSettings,
    *,
    timing: Timing = Timing.MINIMUM_JERK,
    most_samples: int = _MOST_SAMPLES,
    seed: int = 0,
) -> Plan:
    """A way from the configuration `present` (C,) to the target's beginning, and the target after it.

    `node_arc_mm` names the nodal points that are known. Raises TargetError when the target itself cannot be followed,
    NoWayError when no way was found.
    """
    check_target(target, node_arc_mm, plant, settings)
    space = Space(plant)
    asked = demands(target, node_arc_mm, space, settings.reachable_within_mm)
    here = space.nearest(present[None])
    if here is not None and here.spare_mm < 0:
        raise NoWayError(
            f"target {target.name}: no way begins at the present shape: {say_too_close(here, plant)}"
        )
    goals = _goals(space, asked, settings.reachable_within_mm)
    ends = space.spare_mm(np.concatenate([present[None], goals]))
    spare_mm = max(min(_MARGIN_MM, float(ends[0]), float(ends[1:].max())), 0.0)
    goals = goals[ends[1:] >= spare_mm]
    way = Search(space, spare_mm, seed).way(present, goals, most_samples)
    if way is None:
        raise NoWayError(
            f"target {target.name}: no way to it was found in {most_samples} samples; regions "
            f"{', '.join(plant.regions.names)} and the travels leave none, or only a narrow one"
        )
    planned, way_s = _joined(target, asked, way.configurations, node_arc_mm, space, timing)
    check_target(planned, node_arc_mm, plant, settings)
    return Plan(
        target=planned, way_s=way_s, way=way, spare_mm=float(space.spare_mm(way.configurations).min())
    )


def _goals(space: Space, asked: Demands, within_mm: float) -> Array:
    """(g, C) configurations that the way may end in: of a path, where it was found to begin; of places, all that are known."""
    first = asked.configurations[:1]
    starts = first
    if len(asked.moment_s) == 1:
        starts = np.concatenate([first, bent_starts(space, asked.wanted)[:, 0]])
    wanted = asked.wanted.at(np.zeros(len(starts), dtype=np.intp))
    solved = solve(space, wanted, starts, near_enough_mm=_CLOSE_MM)
    well = solved[shortfall(space, wanted, solved, within_mm) == 0]
    return well if len(well) else first


def _joined(
    target: Target,
    asked: Demands,
    way: Array,
    node_arc_mm: Mapping[str, float],
    space: Space,
    timing: Timing,
) -> tuple[Target, float]:
    way_time_s, way_configurations = _timed(way, space, timing)
    way_s = float(way_time_s[-1])
    eased_s, path_s, seam = _path_moments(target)
    guides = [name for name in node_arc_mm if name not in target.node_names]
    names = (*target.node_names, *guides)
    led = np.array([node_arc_mm[name] for name in names])
    known_s = path_s % target.time_s[-1] if target.repeat else path_s
    configurations = interpolated(known_s, asked.moment_s, asked.configurations)
    configurations[path_s == 0] = way_configurations[-1]
    on_way, _ = space.nodes_and_jacobian(way_configurations, led)
    on_path, _ = space.nodes_and_jacobian(configurations, led)
    on_path[:, : len(target.node_names)] = along(target, path_s).node_mm
    # by the model the way ends very near to where the target begins; what is left is made up on the way
    on_way += (way_time_s / max(way_s, _LEAST_S))[:, None, None] * (on_path[0] - on_way[-1])
    guide_weight = GUIDE_WEIGHT * float(target.weights.max())
    return Target(
        name=target.name,
        node_names=names,
        weights=np.append(target.weights, np.full(len(guides), guide_weight)),
        time_s=np.concatenate([way_time_s[:-1], way_s + eased_s]),
        position_mm=np.concatenate([on_way[:-1], on_path]),
        repeat=target.repeat,
        repeat_from_s=way_s + float(eased_s[seam]) if target.repeat else 0.0,
    ), way_s


def _path_moments(target: Target) -> tuple[Array, Array, int]:
    """Moments (k,) counted from where the path sets off from a stand, the path's own (k,), and where it is at full pace.

    A path that repeats has to come round to there, since it is only left once from a stand.
    """
    end_s = float(target.time_s[-1])
    if not end_s:
        return np.zeros(1), np.zeros(1), 0
    stretch = Stretch(length_s=np.inf if target.repeat or end_s > EASING_S else end_s)
    setting_off_s = np.linspace(0, min(EASING_S, stretch.duration_s), _EASED_MOMENTS)
    set_off_s = np.array([stretch.at(each)[0] for each in setting_off_s])
    delay_s = setting_off_s[-1] - set_off_s[-1]
    path_s = target.time_s[target.time_s > set_off_s[-1] + 1e-9]
    if target.repeat:
        again = target.time_s[(target.time_s > 0) & (target.time_s < set_off_s[-1] - 1e-9)]
        path_s = np.concatenate([path_s, end_s + again, [end_s + set_off_s[-1]]])
    return (
        np.concatenate([setting_off_s, path_s + delay_s]),
        np.concatenate([set_off_s, path_s]),
        _EASED_MOMENTS - 1,
    )


def _timed(way: Array, space: Space, timing: Timing) -> tuple[Array, Array]:
    """Moments (k,) and configurations (k, C) of a way (w, C) from a stand to a stand.

    Where the robot has farther to go it takes longer: everywhere the axis or point of the body that needs most time for its
    share of the way sets the pace.
    """
    plant = space.plant
    axes = np.abs(np.diff(space.commands(way), axis=0)) / plant.limits.rate_mm_s
    body = np.linalg.norm(np.diff(space.body_mm(way), axis=0), axis=-1) / plant.maximum_node_speed_mm_s
    needed_s = np.append(0.0, np.cumsum(np.maximum(axes.max(axis=-1), body.max(axis=-1))))
    if not needed_s[-1]:
        return np.zeros(1), way[-1:]
    duration_s = timing.peak() * needed_s[-1] / _PACE
    moments = int(np.clip(np.ceil(duration_s * _MOMENTS_PER_S), _LEAST_MOMENTS, _MOST_MOMENTS)) + 1
    u = np.linspace(0, 1, moments)
    reached = timing.share(u) * needed_s[-1]
    reached[-1] = needed_s[-1]
    return u * duration_s, interpolated(reached, needed_s, way)
