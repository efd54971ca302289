"""What is believed of the robot beyond its nominal model, and how each shape that is seen corrects it. Pure.

The bends that a command leads to are believed to be

    b = T (1 + G) q(e) + b0       q: Clarke coordinates;  T: nominal;  G: gains and coupling;  b0: bias
    e = a - h w / 2               a: where axes are;  h: where in their lost motion, -1 to 1;  w: lost motion

and a nodal point is where constant curvature puts it for these bends, plus an offset of its own; the stage moves by (1 + s)
of what it is told. Gains, biases and lost motion tell of the robot as a whole: what is learnt at one place holds at others,
and for other points. Offsets take what is left, at once, and forget it soon.

One extended Kalman filter estimates all of them from all nodal points of every shape, weighted by their covariances. Its
states are Ornstein-Uhlenbeck processes about the nominal model, so that what is not confirmed is forgotten and no variance
grows without bound; what they may reach is bounded besides. A shape far from what was foreseen (a slip, a blow) is put down
to the offsets: it must not turn the gains.
"""

import dataclasses
import math
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.kinematics import Kinematics
from controller.law import Measurement, same_points
from controller.lost_motion import felt_mm

Array = NDArray[np.float64]
Sigma = Annotated[float, msgspec.Meta(ge=0, le=100)]
Memory = Annotated[float, msgspec.Meta(gt=0, le=1e6)]

_UNFORESEEN = 25.0
"""Squared innovation over its variance, for each coordinate in the mean, beyond which a shape is a surprise."""


class BeliefSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How far a robot may be from its nominal model (standard deviations), and how long what was learnt is kept."""

    gain_sigma: Sigma = 0.25
    """Of each gain, as a share."""
    bias_rad: Sigma = 0.15
    """Of each section's bend at rest."""
    lost_motion_mm: Sigma = 0.3
    """What play and friction swallow when a tendon turns round, where homing did not find out."""
    lost_motion_sigma_mm: Sigma = 0.15
    stage_gain_sigma: Sigma = 0.1
    offset_mm: Sigma = 1.0
    """Of a nodal point from the model, at the tip; less towards the base."""
    measurement_noise_mm: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.03
    """Of a coordinate of a nodal point, on top of what sensing says of it."""
    memory_s: Memory = 60.0
    offset_memory_s: Memory = 4.0
    bound: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.7
    """What gains may reach at most."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Axes:
    """Where the axes were at one moment: positions (A,), and places in their lost motion (A,)."""

    position_mm: Array
    engaged: Array


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Belief:
    """Estimates at `capture_s`, with offsets for nodal points at `arc_mm` (k,)."""

    capture_s: float
    arc_mm: Array
    mean: Array
    """(n + 3 k,): G, b0, s, w, then the offsets."""
    covariance: Array
    nominal: Array
    """(n + 3 k,): what the mean goes back to while nothing is seen."""


class Learning:
    """The filter for one robot."""

    def __init__(
        self,
        settings: BeliefSettings,
        kinematics: Kinematics,
        identified: tuple[Array, Array] | None = None,
    ) -> None:
        """Nothing is known yet, or what was `identified`: G, b0, s and w (n,), and their standard deviations (n,).

        What was identified moves the start, not the trust: it tells how a robot is in the mean of all places, and by how much
        it is otherwise here and there is what the settings say.
        """
        self._settings = settings
        self._kinematics = kinematics
        bends, stage = 2 * len(kinematics.length_mm), int(kinematics.stage)
        sizes = (bends**2, bends, stage, kinematics.tendons)
        ends = np.cumsum(sizes).tolist()
        self._gain, self._bias, self._stage, self._lost = map(slice, (0, *ends[:-1]), ends)
        self._known = ends[-1]
        self._bends = bends
        self._clarke = kinematics.coordinates_of_command[:bends]
        lost_sigma = settings.lost_motion_sigma_mm
        self._sigma = np.repeat(
            [settings.gain_sigma, settings.bias_rad, settings.stage_gain_sigma, lost_sigma], sizes
        )
        self._reach = np.repeat(
            [settings.bound, 4 * settings.bias_rad, settings.bound, 4 * lost_sigma], sizes
        )
        drawn = np.repeat([0.0, 0.0, 0.0, settings.lost_motion_mm], sizes)
        begin, sigma = (drawn, self._sigma) if identified is None else identified
        self._begin: Array = begin
        self._begin_sigma: Array = np.maximum(sigma, self._sigma)

    def begin(self, measured: Measurement, axes: Axes, lost_motion_mm: Array) -> Belief:
        """What is believed of a robot that was just homed: its nominal model, or what was identified, with offsets as first seen.

        `lost_motion_mm` (A,) as homing found it, NaN where it did not look.
        """
        found = lost_motion_mm[: self._kinematics.tendons]
        nominal = self._begin.copy()
        nominal[self._lost] = np.where(np.isnan(found), nominal[self._lost], found)
        return self._seen_first(nominal, nominal, np.diag(self._begin_sigma**2), measured, axes)

    def at_points(self, belief: Belief, measured: Measurement, axes: Axes) -> Belief:
        """The same belief for the nodal points that are seen now: with offsets as first seen if they are others."""
        if same_points(belief.arc_mm, measured.arc_mm):
            return belief
        return self.seen_anew(belief, measured, axes)

    def seen_anew(self, belief: Belief, measured: Measurement, axes: Axes) -> Belief:
        """What is believed of the robot, with offsets as seen now: after a while in which nobody looked."""
        known = slice(0, self._known)
        covariance = belief.covariance[known, known]
        return self._seen_first(belief.nominal[known], belief.mean[known], covariance, measured, axes)

    def _seen_first(
        self, nominal: Array, mean: Array, covariance: Array, measured: Measurement, axes: Axes
    ) -> Belief:
        """What is believed of the robot (n,), with offsets that make it agree with what is seen."""
        unknown = np.zeros(measured.node_mm.size)
        both = np.diag(np.append(np.zeros(self._known), self._offset_sigma(measured.arc_mm) ** 2))
        both[: self._known, : self._known] = covariance
        belief = Belief(
            capture_s=measured.capture_s,
            arc_mm=measured.arc_mm,
            mean=np.append(mean, unknown),
            covariance=both,
            nominal=np.append(nominal, unknown),
        )
        missed = measured.node_mm - self.nodes(belief, self.felt_mm(belief, axes), measured.arc_mm)[0]
        return dataclasses.replace(belief, mean=np.append(mean, missed.ravel()))

    def lost_motion_mm(self, belief: Belief) -> Array:
        """(A,) as believed; 0 for the stage."""
        return np.append(belief.mean[self._lost], np.zeros(self._kinematics.axes - self._kinematics.tendons))

    def felt_mm(self, belief: Belief, axes: Axes) -> Array:
        """(A,) what the robot is believed to feel of the axes."""
        return felt_mm(axes.position_mm, axes.engaged, self.lost_motion_mm(belief))

    def nodes(self, belief: Belief, felt: Array, arc_mm: Array) -> tuple[Array, Array]:
        """Positions (m, 3) of the points at `arc_mm` (m,), and how they move (m, 3, A) with what is `felt` (A,) of the axes."""
        points, by_bend, turned = self._bent(belief, felt, arc_mm)
        jacobian = np.zeros((*points.shape, self._kinematics.axes))
        jacobian += by_bend @ (turned @ self._clarke)
        if self._kinematics.stage:
            jacobian[..., 2, -1] = 1.0 + belief.mean[self._stage]
        offset = belief.mean[self._known :].reshape(-1, 3)
        along = np.append(0.0, belief.arc_mm)
        points += np.stack(
            [np.interp(arc_mm, along, np.append(0.0, offset[:, axis])) for axis in range(3)], axis=-1
        )
        return points, jacobian

    def corrected(self, belief: Belief, measured: Measurement, axes: Axes) -> Belief:
        """The belief after this shape, whose frames were taken while the axes were there."""
        if not same_points(belief.arc_mm, measured.arc_mm):
            return self.at_points(belief, measured, axes)
        mean, covariance = self._aged(belief, measured.capture_s - belief.capture_s)
        belief = dataclasses.replace(belief, mean=mean, covariance=covariance)
        felt = self.felt_mm(belief, axes)
        points, _ = self.nodes(belief, felt, measured.arc_mm)
        innovation = (measured.node_mm - points).ravel()
        rows = self._rows(belief, felt, axes.engaged)
        noise = self._noise(measured)
        seen = rows @ covariance
        variance = seen @ rows.T + noise
        surprise = float(innovation @ np.linalg.solve(variance, innovation)) / len(innovation)
        if surprise > _UNFORESEEN:
            offsets = np.arange(self._known, len(mean))
            covariance[offsets, offsets] += innovation**2
            seen = rows @ covariance
            variance = seen @ rows.T + noise
        gain = np.linalg.solve(variance, seen).T
        mean = mean + gain @ innovation
        covariance = covariance - gain @ seen
        known = slice(0, self._known)
        low, high = belief.nominal[known] - self._reach, belief.nominal[known] + self._reach
        mean[known] = np.minimum(np.maximum(mean[known], low), high)
        mean[self._lost] = np.maximum(mean[self._lost], 0.0)
        return Belief(
            capture_s=measured.capture_s,
            arc_mm=measured.arc_mm,
            mean=mean,
            covariance=(covariance + covariance.T) / 2,
            nominal=belief.nominal,
        )

    def _aged(self, belief: Belief, elapsed_s: float) -> tuple[Array, Array]:
        """Mean and covariance after `elapsed_s` in which nothing was seen."""
        settings = self._settings
        robot = math.exp(-max(elapsed_s, 0.0) / settings.memory_s)
        offsets = math.exp(-max(elapsed_s, 0.0) / settings.offset_memory_s)
        keep = np.full(len(belief.mean), offsets)
        keep[: self._known] = robot
        sigma = np.append(self._sigma, self._offset_sigma(belief.arc_mm))
        covariance = keep[:, None] * belief.covariance * keep + np.diag((1 - keep**2) * sigma**2)
        return belief.nominal + keep * (belief.mean - belief.nominal), covariance

    def _bent(self, belief: Belief, felt: Array, arc_mm: Array) -> tuple[Array, Array, Array]:
        """Points (m, 3) without offsets, their derivatives by the bends (m, 3, 2 S), and the bends' by coordinates."""
        turned = self._kinematics.bend_of_coordinates @ (np.eye(self._bends) + self._gains(belief))
        bend = turned @ (self._clarke @ felt) + belief.mean[self._bias]
        points, by_bend = self._kinematics.bent(bend, arc_mm)
        if self._kinematics.stage:
            points[:, 2] += (1.0 + belief.mean[self._stage]) * felt[-1]
        return points, by_bend, turned

    def _gains(self, belief: Belief) -> Array:
        return belief.mean[self._gain].reshape(self._bends, self._bends)

    def _rows(self, belief: Belief, felt: Array, engaged: Array) -> Array:
        """(3 k, n + 3 k): how what is seen moves with what is believed."""
        points, by_bend, turned = self._bent(belief, felt, belief.arc_mm)
        by_bend = by_bend.reshape(points.size, self._bends)
        by_coordinates = by_bend @ self._kinematics.bend_of_coordinates
        rows = np.zeros((points.size, len(belief.mean)))
        rows[:, self._gain] = (by_coordinates[:, :, None] * (self._clarke @ felt)).reshape(points.size, -1)
        rows[:, self._bias] = by_bend
        rows[2::3, self._stage] = felt[self._kinematics.tendons :]
        tendons = slice(0, self._kinematics.tendons)
        rows[:, self._lost] = by_bend @ turned @ (self._clarke[:, tendons] * (-engaged[tendons] / 2))
        rows[:, self._known :] = np.eye(points.size)
        return rows

    def _noise(self, measured: Measurement) -> Array:
        noise = np.eye(measured.node_mm.size) * self._settings.measurement_noise_mm**2
        for node, covariance in enumerate(measured.covariance_mm2):
            own = slice(3 * node, 3 * node + 3)
            noise[own, own] += covariance
        return noise

    def _offset_sigma(self, arc_mm: Array) -> Array:
        """(3 k,): offsets grow towards the tip."""
        return np.repeat(self._settings.offset_mm * arc_mm / self._kinematics.length_mm.sum(), 3)
