"""Whether the robot could follow a target, said before it moves: by the model, for the whole body. Pure.

Runs within the controller's cycle, so a path is looked at in a limited number of moments.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from controller.errors import TooCloseError, TooFastError, UnknownNodeError, UnreachableError
from controller.limits import axis_name
from controller.path import along
from controller.planning.rates import rate_shares
from controller.planning.solving import Wanted, missed_mm, solve_path
from controller.planning.space import Encroachment, Space
from controller.plant import Plant
from controller.settings import ControllerSettings
from messaging.control import Target

Array = NDArray[np.float64]

_SEAM_MM = 0.1
"""How far a repeating path's end may lie from where it goes on."""
_CHECKED_MOMENTS = 32
_APPROACH_MOMENTS = 9


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Demands:
    """What a target asks of the robot, at the moments (k,) that were looked at. Only nodal points that are driven count."""

    names: tuple[str, ...]
    moment_s: Array
    wanted: Wanted
    speed_mm_s: Array
    """(k, n)."""
    configurations: Array
    """(k, C) that come nearest to what is asked."""
    missed_mm: Array
    """(k, n)."""
    rate_share: Array
    """(k, A) of what each axis may move, signed."""
    nearest: Encroachment | None
    """Where the body comes nearest to a region."""


def demands(target: Target, node_arc_mm: Mapping[str, float], space: Space, within_mm: float) -> Demands:
    """See there; raises UnknownNodeError."""
    if unknown := [name for name in target.node_names if name not in node_arc_mm]:
        raise UnknownNodeError(
            f"target {target.name}: no nodal point {', '.join(unknown)}; sensing reports {', '.join(node_arc_mm) or 'none'}"
        )
    driven = np.flatnonzero(target.weights > 0)
    names = tuple(target.node_names[index] for index in driven)
    moments, speed = _moments(target, driven)
    path = along(target, moments)
    wanted = Wanted(
        place_mm=path.node_mm[:, driven],
        arc_mm=np.array([node_arc_mm[name] for name in names]),
        weights=target.weights[driven],
    )
    solved = solve_path(space, wanted, near_enough_mm=within_mm / 2)
    return Demands(
        names=names,
        moment_s=moments,
        wanted=wanted,
        speed_mm_s=speed,
        configurations=solved,
        missed_mm=missed_mm(space, wanted, solved),
        rate_share=rate_shares(space, solved, wanted.arc_mm, wanted.root, path.velocity_mm_s[:, driven]),
        nearest=space.nearest(solved),
    )


def check_target(
    target: Target,
    node_arc_mm: Mapping[str, float],
    plant: Plant,
    settings: ControllerSettings,
    *,
    start_mm: Array | None = None,
) -> None:
    """Refuse what the robot cannot follow. Nodal points of weight 0 are only watched, and may be anywhere.

    From `start_mm` (m, 3), where the target's nodal points are now, the way to its beginning is looked at too. Raises
    UnknownNodeError, TooFastError, UnreachableError or TooCloseError.
    """
    space, within_mm = Space(plant), settings.reachable_within_mm
    _check_seam(target)
    asked = demands(target, node_arc_mm, space, within_mm)
    moment, node = np.unravel_index(asked.speed_mm_s.argmax(), asked.speed_mm_s.shape)
    if asked.speed_mm_s[moment, node] > settings.maximum_node_speed_mm_s * (1 + 1e-6):
        raise TooFastError(
            f"target {target.name}: {asked.names[node]} moves at {asked.speed_mm_s[moment, node]:.1f} mm/s "
            f"at {asked.moment_s[moment]:g} s; at most {settings.maximum_node_speed_mm_s:g} mm/s are allowed"
        )
    _check_reach(target, asked, plant, within_mm)
    if asked.nearest is not None and asked.nearest.spare_mm < 0:
        raise TooCloseError(
            f"target {target.name}: at {asked.moment_s[asked.nearest.index]:g} s {say_too_close(asked.nearest, plant)}"
        )
    moment, axis = np.unravel_index(np.abs(asked.rate_share).argmax(), asked.rate_share.shape)
    share = abs(asked.rate_share[moment, axis])
    if share > 1:
        allowed_mm_s = plant.limits.rate_mm_s[axis]
        raise TooFastError(
            f"target {target.name}: {axis_name(int(axis), plant.kinematics.tendons)} would have to move at "
            f"{share * allowed_mm_s:.1f} mm/s at {asked.moment_s[moment]:g} s; at most {allowed_mm_s:g} mm/s are allowed, "
            f"so it must take {share:.2f} times as long"
        )
    if start_mm is not None and len(plant.regions):
        _check_approach(target, asked, start_mm, space, within_mm)


def _moments(target: Target, driven: NDArray[np.intp]) -> tuple[Array, Array]:
    """Moments (k,) of the path spread evenly, and the fastest; and how fast nodal points move then (k, n)."""
    times = target.time_s
    if len(times) == 1:
        return times, np.zeros((1, len(driven)))
    each = np.sort(np.concatenate([times, (times[1:] + times[:-1]) / 2]))
    # at its very end a path stands; just before, it does not
    each[-1] = np.nextafter(each[-1], 0)
    speed = np.linalg.norm(along(target, each).velocity_mm_s[:, driven], axis=-1)
    spread = np.linspace(0, len(each) - 1, min(len(each), _CHECKED_MOMENTS)).round().astype(int)
    chosen = np.union1d(spread, speed.max(axis=-1).argmax())
    return each[chosen], speed[chosen]


def _check_seam(target: Target) -> None:
    if not target.repeat:
        return
    first = target.position_mm[np.searchsorted(target.time_s, target.repeat_from_s)]
    gap = np.where(target.weights > 0, np.linalg.norm(target.position_mm[-1] - first, axis=-1), 0.0)
    if gap.max() > _SEAM_MM:
        raise TooFastError(
            f"target {target.name}: {target.node_names[gap.argmax()]} jumps by {gap.max():.1f} mm where the path repeats; "
            f"its positions there may differ by {_SEAM_MM:g} mm"
        )


def _check_reach(target: Target, asked: Demands, plant: Plant, within_mm: float) -> None:
    path, arc = asked.wanted.place_mm, asked.wanted.arc_mm
    low_mm, high_mm = plant.limits.stage_mm
    base = np.zeros_like(path)
    base[..., 2] = np.clip(path[..., 2], low_mm, high_mm)
    distance = np.linalg.norm(path - base, axis=-1)
    excess = distance - arc
    moment, node = np.unravel_index(excess.argmax(), excess.shape)
    if excess[moment, node] > within_mm:
        raise UnreachableError(
            f"target {target.name}: {asked.names[node]} at {asked.moment_s[moment]:g} s should be at "
            f"{_say(path[moment, node])} mm, {distance[moment, node]:.1f} mm from the nearest place of the base; it lies "
            f"{arc[node]:.1f} mm along the robot, and the stage travels {low_mm:g} to {high_mm:g} mm"
        )
    moment, node = np.unravel_index(asked.missed_mm.argmax(), asked.missed_mm.shape)
    if asked.missed_mm[moment, node] > within_mm:
        nodes = plant.kinematics.nodes_mm(
            asked.configurations[moment] @ plant.kinematics.command_of_coordinates.T, arc
        )
        raise UnreachableError(
            f"target {target.name}: {asked.names[node]} at {asked.moment_s[moment]:g} s should be at "
            f"{_say(path[moment, node])} mm; the nearest that the model reaches is {_say(nodes[node])} mm, "
            f"{asked.missed_mm[moment, node]:.1f} mm away (allowed {within_mm:g} mm)"
        )


def _check_approach(target: Target, asked: Demands, start_mm: Array, space: Space, within_mm: float) -> None:
    """Straight on from where nodal points are, as a Reference leads them."""
    start = start_mm[target.weights > 0]
    share = np.linspace(0, 1, _APPROACH_MOMENTS)[:, None, None]
    way = dataclasses.replace(asked.wanted, place_mm=start + share * (asked.wanted.place_mm[0] - start))
    solved = solve_path(space, way, near_enough_mm=within_mm / 2, start=asked.configurations[0])
    nearest = space.nearest(solved)
    if nearest is not None and nearest.spare_mm < 0:
        raise TooCloseError(
            f"target {target.name}: on the straight way to its beginning {say_too_close(nearest, space.plant)}; "
            "a way around is found by `nodal target KIND ... --plan`"
        )


def say_too_close(nearest: Encroachment, plant: Plant) -> str:
    """Where that is and how near, as the end of a sentence."""
    distance_mm = nearest.spare_mm + plant.clearance_mm
    where = f"{distance_mm:.1f} mm from" if distance_mm >= 0 else f"{-distance_mm:.1f} mm inside"
    return (
        f"the robot would be {where} region {nearest.region} {nearest.arc_mm:g} mm along its body, at "
        f"{_say(nearest.point_mm)} mm; it keeps {plant.clearance_mm:g} mm away"
    )


def _say(point_mm: Array) -> str:
    return "(" + ", ".join(f"{value:.1f}" for value in point_mm.round(1) + 0.0) + ")"
