"""The law `resolved_rate`: velocity feed-forward and feedback through the model, which is corrected by what cameras see.

The constant-curvature model says where nodal points p(a) are for a command a. What it misses is learnt while running:

    p(a) + o + E (a - a0)        o: offset where the robot was seen last (at command a0);  E: correction of the Jacobian

Offset and correction are estimated by one Kalman filter which all coordinates share, since they see the same commands.
Delay is no part of the feedback: a shape is compared with the command that had reached the robot when its frames were
taken (commands pass a first-order lag of `response_s`), and the law acts on the prediction for the command of now.
The correction is bounded to a share of the model's Jacobian, so that the direction of motion never turns round.

Where a tendon pair turns round, backlash and friction swallow motion: the command runs ahead of the effective one by
up to half the lost motion, in the direction of travel (the inverse of a play operator; Krejci, Kuhnen, "Inverse control
of systems with hysteresis and creep", 2001). Model, prediction and correction all speak of the effective command.

Rates are found by damped least squares (Wampler 1986; Nakamura, Hanafusa 1986), pulled in what freedom is left towards
the straight posture. They are found anew for each shape, and at the latest after `_PLAN_S`; in between they go on.
"""

import dataclasses
import math
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.history import History
from controller.law import Beginning, Desired, LawInputs, Measurement, Points
from controller.plant import Plant

Array = NDArray[np.float64]

_PLAN_S = 0.04


class Tuning(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings of the law `resolved_rate`."""

    feedback_per_s: Annotated[float, msgspec.Meta(gt=0, le=100)] = 8.0
    """Speed per distance with which an error is made good."""
    response_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.04
    """Time constant with which servos and robot follow a command."""
    lost_motion_mm: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.4
    """What backlash and friction swallow when a tendon pair turns round; too little is safe, twice too much is not."""
    engaging_mm: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.05
    """Within how much motion after turning round the lost motion is made up for."""
    damping_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.5
    """Motion of a nodal point per mm of tendon below which the law gives up rather than pull hard."""
    insertion_cost: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.1
    """What a mm of the stage costs beside a mm of tendon, where either would do."""
    posture_per_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.5
    """How fast the tendons go back to zero in directions that move no nodal point."""
    measurement_noise_mm: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.05
    """Standard deviation of one coordinate of a nodal point."""
    offset_drift_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.5
    """How far the robot may wander from its model in a second, by itself."""
    gain_drift: Annotated[float, msgspec.Meta(ge=0, le=100)] = 0.3
    """How much the Jacobian may change in a second, in mm per mm."""
    maximum_gain_correction: Annotated[float, msgspec.Meta(ge=0, lt=1)] = 0.5
    """Bound of the Jacobian's correction, as a share of the model's."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Correction:
    """What the model misses, as last seen at `capture_s` with `command_mm` (A,) at work."""

    capture_s: float
    command_mm: Array
    offset_mm: Array
    """(m, 3)."""
    gain: Array
    """(m, 3, A)."""
    covariance: Array
    """(1 + A, 1 + A) of offset and gain, the same for every coordinate."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ResolvedRateState:
    """What the law remembers."""

    points: Points
    correction: Correction
    engaged: Array
    """(A,) where each axis stands in its lost motion, -1 to 1."""
    reached_mm: Array
    """(A,) the effective command as far as it has reached the robot."""
    history: History
    rate_mm_s: Array
    """(A,)."""
    planned_s: float


class ResolvedRate:
    """The law; travels and rates of the axes are not its business."""

    def __init__(self, settings: Tuning, plant: Plant) -> None:
        """The law never asks a nodal point to move faster than the plant allows, to catch up neither."""
        self._maximum_speed_mm_s = plant.maximum_node_speed_mm_s
        self._settings = settings
        kinematics = self._kinematics = plant.kinematics
        self._cost = np.append(np.ones(kinematics.tendons), settings.insertion_cost)
        self._half_lost_mm = np.append(np.full(kinematics.tendons, settings.lost_motion_mm / 2), 0.0)
        self.lead_s = settings.response_s

    def start(self, beginning: Beginning[ResolvedRateState]) -> ResolvedRateState:
        """Offset from the first measurement, no correction of the Jacobian yet."""
        points, measured, command_mm = beginning.points, beginning.measured, beginning.command_mm
        if beginning.before is not None and beginning.before.points.same_as(points):
            return beginning.before
        nodes = self._kinematics.nodes_mm(command_mm, points.arc_mm)
        axes = self._kinematics.axes
        uncertainty = np.append(self._settings.measurement_noise_mm, np.full(axes, self._settings.gain_drift))
        return ResolvedRateState(
            points=points,
            correction=Correction(
                capture_s=measured.capture_s,
                command_mm=command_mm,
                offset_mm=measured.led_mm - nodes,
                gain=np.zeros((*nodes.shape, axes)),
                covariance=np.diag(uncertainty**2),
            ),
            engaged=np.zeros(axes),
            reached_mm=command_mm,
            history=History.of(beginning.now_s, command_mm),
            rate_mm_s=np.zeros(axes),
            planned_s=-np.inf,
        )

    def step(self, state: ResolvedRateState, inputs: LawInputs) -> tuple[ResolvedRateState, Array]:
        """See `Law`."""
        effective = inputs.command_mm - self._half_lost_mm * state.engaged
        share = 1 - math.exp(-inputs.dt_s / self._settings.response_s)
        reached = state.reached_mm + share * (effective - state.reached_mm)
        history = state.history.then(inputs.now_s, reached)
        correction, rate, planned_s = state.correction, state.rate_mm_s, state.planned_s
        if inputs.measured is not None or inputs.now_s - planned_s > _PLAN_S:
            capture_s = inputs.now_s if inputs.measured is None else inputs.measured.capture_s
            commands = np.stack([history.at(capture_s), effective])
            nodes, jacobian = self._kinematics.nodes_and_jacobian(commands, state.points.arc_mm)
            if inputs.measured is not None:
                correction = self._corrected(correction, inputs.measured, commands[0], nodes[0], jacobian[0])
            known = nodes[1] + correction.offset_mm + correction.gain @ (effective - correction.command_mm)
            rate = self._plan(state.points, inputs.desired, effective, known, jacobian[1] + correction.gain)
            planned_s = inputs.now_s
        step = rate * inputs.dt_s
        engaged = np.minimum(np.maximum(state.engaged + step / self._settings.engaging_mm, -1.0), 1.0)
        following = ResolvedRateState(
            points=state.points,
            correction=correction,
            engaged=engaged,
            reached_mm=reached,
            history=history,
            rate_mm_s=rate,
            planned_s=planned_s,
        )
        return following, effective + step + self._half_lost_mm * engaged

    def _corrected(
        self, before: Correction, measured: Measurement, command_mm: Array, nodes: Array, jacobian: Array
    ) -> Correction:
        """One step of the filter; `nodes` (m, 3) and `jacobian` (m, 3, A) are the model's for the command at capture."""
        settings = self._settings
        moved = command_mm - before.command_mm
        elapsed_s = max(measured.capture_s - before.capture_s, 0.0)
        predicted = before.offset_mm + before.gain @ moved
        transition = np.eye(len(moved) + 1)
        transition[0, 1:] = moved
        drift = np.append(settings.offset_drift_mm, np.full(len(moved), settings.gain_drift))
        covariance = transition @ before.covariance @ transition.T + np.diag(drift**2 * elapsed_s)
        kalman = covariance[0] / (covariance[0, 0] + settings.measurement_noise_mm**2)
        innovation = measured.led_mm - nodes - predicted
        gain = before.gain + innovation[..., None] * kalman[1:]
        return Correction(
            capture_s=measured.capture_s,
            command_mm=command_mm,
            offset_mm=predicted + innovation * kalman[0],
            gain=_bounded(
                gain, settings.maximum_gain_correction * np.linalg.norm(jacobian, axis=-2, keepdims=True)
            ),
            covariance=covariance - np.outer(kalman, covariance[0]),
        )

    def _plan(
        self, points: Points, desired: Desired, command_mm: Array, predicted_mm: Array, jacobian: Array
    ) -> Array:
        """Rates (A,) of the axes by damped least squares, for nodal points predicted at (m, 3) and moving by (m, 3, A)."""
        settings = self._settings
        wanted = desired.velocity_mm_s + settings.feedback_per_s * (desired.node_mm - predicted_mm)
        speed = np.linalg.norm(wanted, axis=1, keepdims=True)
        wanted *= np.minimum(1.0, self._maximum_speed_mm_s / np.maximum(speed, 1e-9))
        root = np.sqrt(points.weights / points.weights.max())[:, None]
        rows = (jacobian * root[..., None] * points.movable).reshape(-1, len(self._cost))
        posture = -settings.posture_per_s * command_mm * points.movable
        posture[-1] = 0.0
        missing = (wanted * root).ravel() - rows @ posture
        normal = rows.T @ rows + np.diag((settings.damping_mm * self._cost) ** 2)
        rate: Array = posture + np.linalg.solve(normal, rows.T @ missing)
        return rate


def make(tuning: Tuning, plant: Plant) -> ResolvedRate:
    """The law for this plant."""
    return ResolvedRate(tuning, plant)


def _bounded(gain: Array, bound: Array) -> Array:
    """`gain` (m, 3, A) with every column (3,) of every point shortened to `bound` (m, 1, A)."""
    size = np.linalg.norm(gain, axis=-2, keepdims=True)
    bounded: Array = gain * np.minimum(1.0, bound / np.maximum(size, 1e-12))
    return bounded
