"""The constant-curvature model: where nodal points are for given tendon displacements and insertion, and how they move.

Section i bends by the vector b_i = (angle) * (direction), in rad, in the frame of its base; frames are carried along the
backbone without twist, so directions of all sections are measured against the same marks. In these coordinates nothing is
singular in the straight pose (Della Santina, Bicchi, Rus, "On an improved state parametrization for soft robots with
piecewise constant curvature", 2020).

A command is the vector (displacement_mm of every tendon or antagonistic pair, section by section; insertion_mm where there
is a stage). However many tendons a section has, they share its two Clarke coordinates q_i in mm: a tendon at angle t is
displaced by (cos t, sin t) . q_i (Grassmann, Senyk, Burgner-Kahrs, "Clarke transform", 2024). Displacements that no bend
explains only tighten or slacken a section's tendons.
"""

import math
from collections.abc import Sequence

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
_LEAST_SPREAD = 0.1
"""Smallest over largest pull of a section's tendons, over all directions, below which they all pull the same way."""


class Kinematics:
    """S sections with any number of tendons, with or without a linear stage along +Z.

    D tendons or antagonistic pairs, A = D + 1 axes with a stage, or D without; C = 2 S coordinates and the stage's.
    """

    def __init__(
        self,
        section_length_mm: ArrayLike,
        tendon_angle_rad: Sequence[ArrayLike],
        pitch_radius_mm: ArrayLike,
        *,
        coupling: float = 1.0,
        stage: bool = True,
    ) -> None:
        """Lengths (S,), for each section the angles of its tendons (of pairs: of their first) from +X towards +Y, radii (S,).

        `coupling` is the share of the pitch radius at which distal tendons cross the sections before their own. Raises
        ControllerSetupError when numbers of sections do not agree or all tendons of a section pull the same way.
        """
        self.length_mm = np.asarray(section_length_mm, dtype=np.float64)
        radius = np.asarray(pitch_radius_mm, dtype=np.float64)
        angles = [np.asarray(angle, dtype=np.float64) for angle in tendon_angle_rad]
        sections = len(self.length_mm)
        if len(angles) != sections or radius.shape != (sections,):
            raise ControllerSetupError(
                f"the controller's tendons are set for {len(angles)} sections, the robot has {sections}"
            )
        self._start_mm = np.cumsum(self.length_mm) - self.length_mm
        self.tendons = sum(len(angle) for angle in angles)
        self.axes = self.tendons + stage
        self.stage = stage
        self.coupling = coupling
        self.command_of_coordinates = np.zeros((self.axes, 2 * sections + stage))
        """(A, C): the command that bends all sections so."""
        self.command_of_coordinates[self.tendons :, 2 * sections :] = 1.0
        row = 0
        for section, angle in enumerate(angles):
            own = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            _check_spread(section, angle, own)
            self.command_of_coordinates[row : row + len(angle), 2 * section : 2 * section + 2] = own
            row += len(angle)
        self.coordinates_of_command = np.linalg.pinv(self.command_of_coordinates)
        """(C, A): Clarke coordinates in mm, and the stage's place; what no bend explains is left out."""
        crossing = np.eye(sections) + coupling * np.tri(sections, k=-1)
        self.bend_of_coordinates = np.linalg.inv(np.kron(radius[:, None] * crossing, np.eye(2)))
        """(2 S, 2 S): bends in rad of Clarke coordinates in mm."""
        self._bend_of_displacement = (
            self.bend_of_coordinates @ self.coordinates_of_command[: 2 * sections, : self.tendons]
        )
        moving = self.command_of_coordinates @ self.coordinates_of_command
        self.bending = moving * (np.arange(self.axes) < self.tendons)
        """(A, A): the part of a command that bends the robot; neither its stage nor what only tightens tendons."""
        tightening = np.eye(self.axes) - moving
        self.tightening = tightening if self.axes > 2 * sections + stage else np.zeros((0, self.axes))
        """(A, A) or (0, A): the part of a command that bends nothing and only tightens or slackens tendons."""

    def nodes_mm(self, command_mm: Array, arc_mm: Array) -> Array:
        """Positions (..., m, 3) of the points at arc lengths (m,) for commands (..., A)."""
        return self.nodes_and_jacobian(command_mm, arc_mm)[0]

    def nodes_and_jacobian(self, command_mm: Array, arc_mm: Array) -> tuple[Array, Array]:
        """Positions (..., m, 3), and their derivatives (..., m, 3, A) by the command."""
        bend = command_mm[..., : self.tendons] @ self._bend_of_displacement.T
        points, by_bend = self.bent(bend, arc_mm)
        if self.stage:
            points[..., 2] += command_mm[..., -1:]
        jacobian = np.empty((*points.shape, self.axes))
        jacobian[..., : self.tendons] = by_bend @ self._bend_of_displacement
        jacobian[..., self.tendons :] = [[0.0], [0.0], [1.0]]
        return points, jacobian

    def bent(self, bend_rad: Array, arc_mm: Array) -> tuple[Array, Array]:
        """Points (..., m, 3) of a robot on its base whose sections bend by (..., 2 S), and their derivatives (..., m, 3, 2 S).

        From the tip to the base: the point as seen from each section's base.
        """
        bend = bend_rad[..., None, :]
        into_mm = np.maximum(arc_mm[:, None] - self._start_mm, 0.0)
        into_mm[:, :-1] = np.minimum(into_mm[:, :-1], self.length_mm[:-1])
        share = into_mm / self.length_mm
        node = np.zeros((*bend.shape[:-2], len(arc_mm), 3))
        by_bend = np.zeros((*node.shape, bend.shape[-1]))
        for section in reversed(range(len(self.length_mm))):
            own = slice(2 * section, 2 * section + 2)
            part = share[:, section, None]
            turn, turn_by_bend, end, end_by_bend = _arc(part * bend[..., own], into_mm[:, section, None])
            by_bend[..., own.stop :] = turn @ by_bend[..., own.stop :]
            seen = turn_by_bend @ node[..., None, :, None]
            by_bend[..., own] = part[..., None] * (end_by_bend + seen[..., 0]).swapaxes(-1, -2)
            node = end + (turn @ node[..., None])[..., 0]
        return node, by_bend


def _check_spread(section: int, angle_rad: Array, pull: Array) -> None:
    strength = np.linalg.svd(pull, compute_uv=False) if len(angle_rad) > 1 else np.zeros(2)
    if strength[1] < _LEAST_SPREAD * max(strength[0], 1.0):
        raise ControllerSetupError(
            f"section {section + 1}: tendons at {np.degrees(angle_rad).round(6).tolist()} degrees must not all pull the same way"
        )


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
