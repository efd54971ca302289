"""Whether the robot could follow a target, said before it moves: by the model, for the whole body. Pure.

Nodal points are looked at so often that neither they nor any point of the body moves farther than a few mm between two
looks. It runs within the controller's cycle, so there is a limit to the length of a path.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from controller.errors import TooCloseError, TooFastError, TooLongError, UnreachableError
from controller.limits import axis_name
from controller.planning.leading import lead_body
from controller.planning.looks import Looks, look_along
from controller.planning.rates import rate_shares
from controller.planning.solving import Wanted, missed_mm
from controller.planning.space import Encroachment, Space
from controller.plant import Plant
from controller.settings import ControllerSettings
from messaging.control import Target

Array = NDArray[np.float64]

_SEAM_MM = 0.1
"""How far a repeating path's end may lie from where it goes on."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Demands:
    """What a target asks of the robot, at the moments (k,) for which the whole body was looked at.

    Only nodal points that are driven count.
    """

    looks: Looks
    moment_s: Array
    wanted: Wanted
    configurations: Array
    """(k, C) that come nearest to what is asked."""
    missed_mm: Array
    """(k, n)."""
    rate_share: Array
    """(k, A) of what each axis may move, signed."""
    nearest: Encroachment | None
    """Where the body comes nearest to a region, at these moments and between; its index counts them."""


def demands(target: Target, node_arc_mm: Mapping[str, float], space: Space, within_mm: float) -> Demands:
    """See there; raises UnknownNodeError."""
    return _demands(look_along(target, node_arc_mm, space.look_mm), space, within_mm)


def _demands(looks: Looks, space: Space, within_mm: float) -> Demands:
    wanted = looks.wanted.at(looks.body)
    solved, nearest = lead_body(space, wanted, near_enough_mm=within_mm / 2)
    return Demands(
        looks=looks,
        moment_s=looks.time_s[looks.body],
        wanted=wanted,
        configurations=solved,
        missed_mm=missed_mm(space, wanted, solved),
        rate_share=rate_shares(space, solved, wanted.arc_mm, wanted.root, looks.velocity_mm_s[looks.body]),
        nearest=nearest,
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
    UnknownNodeError, TooFastError, UnreachableError, TooLongError or TooCloseError.
    """
    space, within_mm = Space(plant), settings.reachable_within_mm
    _check_seam(target)
    looks = look_along(target, node_arc_mm, space.look_mm)
    _check_speed(target, looks, settings.maximum_node_speed_mm_s)
    _check_distance(target, looks, plant, within_mm)
    _check_length(target, looks, space)
    _check_clear(target, space.nearest_of(looks.place_mm, looks.wanted.arc_mm), looks.time_s, plant)
    asked = _demands(looks, space, within_mm)
    _check_missed(target, asked, plant, within_mm)
    _check_clear(target, asked.nearest, asked.moment_s, plant)
    _check_rates(target, asked, plant)
    if start_mm is not None and len(plant.regions):
        _check_approach(target, asked, start_mm, space, within_mm)


def _check_speed(target: Target, looks: Looks, most_mm_s: float) -> None:
    speed_mm_s = looks.speed_mm_s
    moment, node = np.unravel_index(speed_mm_s.argmax(), speed_mm_s.shape)
    if speed_mm_s[moment, node] > most_mm_s * (1 + 1e-6):
        raise TooFastError(
            f"target {target.name}: {looks.names[node]} moves at {speed_mm_s[moment, node]:.1f} mm/s "
            f"at {looks.time_s[moment]:g} s; at most {most_mm_s:g} mm/s are allowed"
        )


def _check_length(target: Target, looks: Looks, space: Space) -> None:
    if looks.apart_mm > space.look_mm:
        raise TooLongError(
            f"target {target.name}: a way of {looks.length_mm:.0f} mm, all its coordinates added up; at most "
            f"{looks.length_mm * space.look_mm / looks.apart_mm:.0f} mm can be checked, so send it in parts"
        )


def _check_clear(target: Target, nearest: Encroachment | None, moment_s: Array, plant: Plant) -> None:
    if nearest is not None and nearest.spare_mm < 0:
        raise TooCloseError(
            f"target {target.name}: at {moment_s[nearest.index]:g} s {say_too_close(nearest, plant)}"
        )


def _check_rates(target: Target, asked: Demands, plant: Plant) -> None:
    moment, axis = np.unravel_index(np.abs(asked.rate_share).argmax(), asked.rate_share.shape)
    share = abs(asked.rate_share[moment, axis])
    if share > 1:
        allowed_mm_s = plant.limits.rate_mm_s[axis]
        raise TooFastError(
            f"target {target.name}: {axis_name(int(axis), plant.kinematics.tendons)} would have to move at "
            f"{share * allowed_mm_s:.1f} mm/s at {asked.moment_s[moment]:g} s; at most {allowed_mm_s:g} mm/s are allowed, "
            f"so it must take {share:.2f} times as long"
        )


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


def _check_distance(target: Target, looks: Looks, plant: Plant, within_mm: float) -> None:
    path, arc = looks.place_mm, looks.wanted.arc_mm
    low_mm, high_mm = plant.limits.stage_mm
    base = np.zeros_like(path)
    base[..., 2] = np.clip(path[..., 2], low_mm, high_mm)
    distance = np.linalg.norm(path - base, axis=-1)
    excess = distance - arc
    moment, node = np.unravel_index(excess.argmax(), excess.shape)
    if excess[moment, node] > within_mm:
        raise UnreachableError(
            f"target {target.name}: {looks.names[node]} at {looks.time_s[moment]:g} s should be at "
            f"{_say(path[moment, node])} mm, {distance[moment, node]:.1f} mm from the nearest place of the base; it lies "
            f"{arc[node]:.1f} mm along the robot, and the stage travels {low_mm:g} to {high_mm:g} mm"
        )


def _check_missed(target: Target, asked: Demands, plant: Plant, within_mm: float) -> None:
    moment, node = np.unravel_index(asked.missed_mm.argmax(), asked.missed_mm.shape)
    if asked.missed_mm[moment, node] > within_mm:
        nodes = plant.kinematics.nodes_mm(
            asked.configurations[moment] @ plant.kinematics.command_of_coordinates.T, asked.wanted.arc_mm
        )
        raise UnreachableError(
            f"target {target.name}: {asked.looks.names[node]} at {asked.moment_s[moment]:g} s should be at "
            f"{_say(asked.wanted.place_mm[moment, node])} mm; the nearest that the model reaches is {_say(nodes[node])} mm, "
            f"{asked.missed_mm[moment, node]:.1f} mm away (allowed {within_mm:g} mm)"
        )


def _check_approach(target: Target, asked: Demands, start_mm: Array, space: Space, within_mm: float) -> None:
    """Straight on from where nodal points are, as a Reference leads them."""
    looks = asked.looks.straight_to(start_mm[target.weights > 0], space.look_mm)
    _check_length(target, looks, space)
    nearest = space.nearest_of(looks.place_mm, looks.wanted.arc_mm)
    # where nodal points are now was not asked for: they are taken to be as near to it as they may miss a place
    if nearest is None or nearest.spare_mm >= -within_mm:
        wanted, start = looks.wanted.at(looks.body), asked.configurations[0]
        _, nearest = lead_body(space, wanted, near_enough_mm=within_mm / 2, start=start)
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
