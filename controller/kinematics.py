"""The constant-curvature model: where nodal points are for given tendon displacements and insertion, and how they move.

Section i bends by the vector b_i = (angle) * (direction), in rad, in the frame of its base; frames are carried along the
backbone without twist, so directions of all sections are measured against the same marks. In these coordinates,
the two Clarke coordinates of the section up to the pitch radius, nothing is singular in the straight pose (Della
Santina, Bicchi, Rus, "On an improved state parametrization for soft robots with piecewise constant curvature", 2020).

A command is the vector (displacement_mm of every pair, section by section; insertion_mm).
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from controller.errors import ControllerSetupError

Array = NDArray[np.float64]

_ORDERS = np.arange(24)
_SINC = np.array([(-1.0) ** k / math.factorial(2 * k + 1) for k in _ORDERS])
_VERSINE = np.array([(-1.0) ** k / math.factorial(2 * k + 2) for k in _ORDERS])


def _twice_derivative(series: Array) -> Array:
    return np.append(2 * _ORDERS[1:] * series[1:], 0.0)


_SERIES = np.stack([_SINC, _VERSINE, _twice_derivative(_SINC), _twice_derivative(_VERSINE)], axis=1)
"""In powers of the squared angle: sin(t)/t, (1 - cos(t))/t^2, and their derivatives by the angle, over the angle.
Exact to 1e-12 up to bends of 3 pi, and smooth at zero."""

_TURN = np.zeros((2, 3, 3))
"""Skew matrices whose exponential bends the tangent towards +X and towards +Y."""
_TURN[0, 0, 2] = _TURN[1, 1, 2] = 1.0
_TURN[0, 2, 0] = _TURN[1, 2, 1] = -1.0
_UNITS = np.eye(2, 3)


class Kinematics:
    """S sections with two tendon pairs each, on a linear stage along +Z; A = 2 S + 1 axes."""

    def __init__(
        self, section_length_mm: ArrayLike, pair_angle_rad: ArrayLike, pitch_radius_mm: ArrayLike
    ) -> None:
        """Lengths (S,), angles (S, 2) of each pair's first tendon from +X towards +Y, pitch radii (S,).

        Raises ControllerSetupError when shapes do not agree or a section's two pairs pull in the same direction.
        """
        self.length_mm = np.asarray(section_length_mm, dtype=np.float64)
        angle, radius = (
            np.asarray(pair_angle_rad, dtype=np.float64),
            np.asarray(pitch_radius_mm, dtype=np.float64),
        )
        sections = len(self.length_mm)
        if angle.shape != (sections, 2) or radius.shape != (sections,):
            raise ControllerSetupError(
                f"the controller's tendons are set for {len(angle)} sections, the robot has {sections}"
            )
        own = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        if (abs(np.linalg.det(own)) < 0.1 * radius**2).any():
            raise ControllerSetupError(
                f"tendon pairs at {np.degrees(angle).tolist()} degrees: a section's two pairs must not pull the same way"
            )
        self._start_mm = np.cumsum(self.length_mm) - self.length_mm
        self.displacement_per_bend = np.zeros((2 * sections, 2 * sections))
        """(2 S, 2 S): distal tendons also shorten by the bend of every section that they cross."""
        for section in range(sections):
            rows = slice(2 * section, 2 * section + 2)
            self.displacement_per_bend[rows, : 2 * section + 2] = np.tile(own[section], section + 1)
        self.bend_per_displacement = np.linalg.inv(self.displacement_per_bend)
        self.pairs = 2 * sections
        self.axes = self.pairs + 1

    def nodes_mm(self, command_mm: Array, arc_mm: Array) -> Array:
        """Positions (..., m, 3) of the points at arc lengths (m,) for commands (..., A)."""
        return self._chain(command_mm, arc_mm)[0]

    def nodes_and_jacobian(self, command_mm: Array, arc_mm: Array) -> tuple[Array, Array]:
        """Positions (..., m, 3), and their derivatives (..., m, 3, A) by the command."""
        points, by_bend = self._chain(command_mm, arc_mm)
        jacobian = np.empty((*points.shape, self.axes))
        jacobian[..., :-1] = by_bend @ self.bend_per_displacement
        jacobian[..., -1] = [0.0, 0.0, 1.0]
        return points, jacobian

    def _chain(self, command_mm: Array, arc_mm: Array) -> tuple[Array, Array]:
        """From the tip to the base: the node as seen from each section's base, and its derivative by the bends."""
        bend = (command_mm[..., :-1] @ self.bend_per_displacement.T)[..., None, :]
        into_mm = np.maximum(arc_mm[:, None] - self._start_mm, 0.0)
        into_mm[:, :-1] = np.minimum(into_mm[:, :-1], self.length_mm[:-1])
        share = into_mm / self.length_mm
        node = np.zeros((*bend.shape[:-2], len(arc_mm), 3))
        by_bend = np.zeros((*node.shape, self.pairs))
        for section in reversed(range(len(self.length_mm))):
            own = slice(2 * section, 2 * section + 2)
            part = share[:, section, None]
            turn, turn_by_bend, end, end_by_bend = _arc(part * bend[..., own], into_mm[:, section, None])
            by_bend[..., own.stop :] = turn @ by_bend[..., own.stop :]
            seen = turn_by_bend @ node[..., None, :, None]
            by_bend[..., own] = part[..., None] * (end_by_bend + seen[..., 0]).swapaxes(-1, -2)
            node = end + (turn @ node[..., None])[..., 0]
        node[..., 2] += command_mm[..., -1:]
        return node, by_bend


def _arc(bend: Array, length_mm: Array) -> tuple[Array, Array, Array, Array]:
    """A circular arc bent by (..., 2) rad: its end's rotation (..., 3, 3) and place (..., 3), each by the bend too.

    Derivatives carry the bend's component ahead of their own axes: (..., 2, 3, 3) and (..., 2, 3).
    """
    squared = (bend * bend).sum(axis=-1)
    terms = (squared[..., None] ** _ORDERS) @ _SERIES
    sinc, versine, sinc_slope, versine_slope = np.moveaxis(terms, -1, 0)[..., None, None]
    skew = np.tensordot(bend, _TURN, axes=1)
    skew_squared = skew @ skew
    turn = np.eye(3) + sinc * skew + versine * skew_squared
    each, skew_each = bend[..., None, None], skew[..., None, :, :]
    turn_by_bend = (
        each * (sinc_slope * skew + versine_slope * skew_squared)[..., None, :, :]
        + sinc[..., None] * _TURN
        + versine[..., None] * (_TURN @ skew_each + skew_each @ _TURN)
    )
    end = np.empty((*squared.shape, 3))
    end[..., :2] = length_mm * versine[..., 0] * bend
    end[..., 2] = (length_mm * sinc[..., 0])[..., 0]
    end_by_bend = versine * _UNITS
    end_by_bend[..., :2] += versine_slope * bend[..., :, None] * bend[..., None, :]
    end_by_bend[..., 2] = sinc_slope[..., 0] * bend
    return turn, turn_by_bend, end, length_mm[..., None] * end_by_bend
