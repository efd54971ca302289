"""Whether the robot could follow a target, said before it moves. Pure."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from controller.errors import TooFastError, UnknownNodeError, UnreachableError
from controller.plant import Plant
from controller.settings import ControllerSettings
from messaging.control import Target

Array = NDArray[np.float64]

_SEAM_MM = 0.1
"""How far a repeating path's end may lie from where it goes on."""
_CHECKED_MOMENTS = 64
_SOLVER_STEPS = 40
_SOLVER_DAMPING_MM = 0.3
_SOLVER_STEP_MM = 1.0


def check_target(
    target: Target,
    node_arc_mm: Mapping[str, float],
    plant: Plant,
    settings: ControllerSettings,
) -> None:
    """Refuse what the robot cannot follow. Nodal points of weight 0 are only watched, and may be anywhere.

    Raises UnknownNodeError, TooFastError, or UnreachableError: first by the length of the robot and the travel of its
    stage alone, then by solving the constant-curvature model within all travels.
    """
    if unknown := [name for name in target.node_names if name not in node_arc_mm]:
        raise UnknownNodeError(
            f"target {target.name}: no nodal point {', '.join(unknown)}; sensing reports {', '.join(node_arc_mm) or 'none'}"
        )
    speed_mm_s, within_mm = settings.maximum_node_speed_mm_s, settings.reachable_within_mm
    driven = np.flatnonzero(target.weights > 0)
    names = [target.node_names[index] for index in driven]
    arc = np.array([node_arc_mm[name] for name in names])
    path = target.position_mm[:, driven]
    _check_speed(target, names, path, speed_mm_s)
    _check_sphere(target, names, path, arc, plant=plant, within_mm=within_mm)
    moments = np.unique(np.linspace(0, len(path) - 1, min(len(path), _CHECKED_MOMENTS)).round().astype(int))
    reached = _reach(path[moments], arc, target.weights[driven], plant, near_enough_mm=within_mm / 2)
    missed = np.linalg.norm(path[moments] - reached, axis=-1)
    moment, node = np.unravel_index(missed.argmax(), missed.shape)
    if missed[moment, node] > within_mm:
        raise UnreachableError(
            f"target {target.name}: {names[node]} at {target.time_s[moments[moment]]:g} s should be at "
            f"{_say(path[moments[moment], node])} mm; the nearest that the model reaches is {_say(reached[moment, node])} mm, "
            f"{missed[moment, node]:.1f} mm away (allowed {within_mm:g} mm)"
        )


def _check_speed(target: Target, names: list[str], path: Array, speed_mm_s: float) -> None:
    if len(path) == 1:
        return
    speed = np.linalg.norm(np.diff(path, axis=0), axis=-1) / np.diff(target.time_s)[:, None]
    moment, node = np.unravel_index(speed.argmax(), speed.shape)
    if speed[moment, node] > speed_mm_s:
        raise TooFastError(
            f"target {target.name}: {names[node]} moves at {speed[moment, node]:.1f} mm/s "
            f"at {target.time_s[moment]:g} s; at most {speed_mm_s:g} mm/s are allowed"
        )
    seam = np.linalg.norm(path[-1] - path[0], axis=-1)
    if target.repeat and seam.max() > _SEAM_MM:
        raise TooFastError(
            f"target {target.name}: {names[seam.argmax()]} jumps by {seam.max():.1f} mm where the path repeats; "
            f"first and last position may differ by {_SEAM_MM:g} mm"
        )


def _check_sphere(
    target: Target, names: list[str], path: Array, arc: Array, *, plant: Plant, within_mm: float
) -> None:
    low_mm, high_mm = plant.limits.stage_mm
    base = np.zeros_like(path)
    base[..., 2] = np.clip(path[..., 2], low_mm, high_mm)
    distance = np.linalg.norm(path - base, axis=-1)
    excess = distance - arc
    moment, node = np.unravel_index(excess.argmax(), excess.shape)
    if excess[moment, node] > within_mm:
        raise UnreachableError(
            f"target {target.name}: {names[node]} at {target.time_s[moment]:g} s should be at "
            f"{_say(path[moment, node])} mm, {distance[moment, node]:.1f} mm from the nearest place of the base; it lies "
            f"{arc[node]:.1f} mm along the robot, and the stage travels {low_mm:g} to {high_mm:g} mm"
        )


def _reach(path: Array, arc: Array, weights: Array, plant: Plant, *, near_enough_mm: float) -> Array:
    """(k, n, 3) where the model brings the nodal points, all k moments at once: damped Gauss-Newton within the travels."""
    kinematics, limits, tendons = plant.kinematics, plant.limits, plant.kinematics.tendons
    command = np.zeros((len(path), kinematics.axes))
    # the stage starts where a straight robot would be highest: bending only lowers it
    command[:, tendons:] = (path[..., 2] - arc).max(axis=1)[:, None]
    command = np.clip(command, limits.low_mm, limits.high_mm)
    root = np.sqrt(weights / weights.max())[:, None]
    damping = np.diag(np.where(np.arange(kinematics.axes) < tendons, _SOLVER_DAMPING_MM**2, 1e-6))
    for _ in range(_SOLVER_STEPS):
        nodes, jacobian = kinematics.nodes_and_jacobian(command, arc)
        missing = path - nodes
        if np.linalg.norm(missing, axis=-1).max() < near_enough_mm:
            break
        rows = (root[..., None] * jacobian).reshape(len(path), -1, kinematics.axes)
        pull = rows.swapaxes(-1, -2) @ (root * missing).reshape(len(path), -1, 1)
        step = np.linalg.solve(rows.swapaxes(-1, -2) @ rows + damping, pull)[..., 0]
        step[:, :tendons] = np.clip(step[:, :tendons], -_SOLVER_STEP_MM, _SOLVER_STEP_MM)
        command = np.clip(command + step, limits.low_mm, limits.high_mm)
    return kinematics.nodes_mm(command, arc)


def _say(point_mm: Array) -> str:
    return "(" + ", ".join(f"{value:.1f}" for value in point_mm) + ")"
