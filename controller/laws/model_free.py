"""The law `model_free`: no model of the robot at all. It feels how nodal points move with each axis, and goes on learning.

After Yip, Camarillo, "Model-less feedback control of continuum manipulators in constrained environments" (2014): a Jacobian
that is estimated while the robot moves, and used as if it were the robot. It begins with a small probing motion of each
axis. The estimate is a Kalman filter that all coordinates share, since they see the same axes; the Jacobian may change with
the motion made, not with time, so that what was felt is not forgotten while standing still.

Shapes are compared with where the servos were when their frames were taken. Limits and forbidden regions are kept by the
same programme as in every law, regions at the nodal points: of the body between them this law knows nothing.
"""

import dataclasses
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.allocation import PLAN_S, Allocation, Body, Wish, tightening_mm_s
from controller.following import Following
from controller.history import History
from controller.law import Beginning, LawInputs, Measurement, Points, same_points
from controller.plant import Plant

Array = NDArray[np.float64]
Positive = Annotated[float, msgspec.Meta(gt=0, le=100)]

_UNFORESEEN = 9.0
"""Squared innovation over its variance beyond which a shape is a surprise."""


class Tuning(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings of the law `model_free`."""

    feedback_per_s: Positive = 5.0
    """Speed per distance with which an error is made good."""
    servo_lag_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.045
    """Time constant with which servos follow their commands."""
    robot_lag_s: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.03
    """Time constant with which the robot follows its servos."""
    probing_mm: Positive = 0.8
    """How far each axis is moved, and back, to feel what it does."""
    probing_s: Annotated[float, msgspec.Meta(gt=0, le=60)] = 0.5
    """How long that takes."""
    damping_mm: Positive = 1.0
    """Motion of a nodal point per mm of tendon below which the law gives up rather than pull hard."""
    insertion_cost: Positive = 0.1
    """What a mm of the stage costs beside a mm of tendon, where either would do."""
    posture_per_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.5
    """How fast the tendons go back to zero in directions that move no nodal point."""
    jacobian_sigma: Positive = 10.0
    """How fast nodal points may move, in mm per mm of an axis, before anything was felt."""
    jacobian_change: Positive = 1.0
    """How much that changes with each mm that the axes move."""
    wander_mm: Positive = 0.2
    """How far the robot may wander in a second by itself."""
    measurement_noise_mm: Positive = 0.05


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Felt:
    """How nodal points move with the axes, as last corrected by the shape of `capture_s`."""

    capture_s: float
    arc_mm: Array
    """(k,)."""
    position_mm: Array
    """(A,) where the axes were."""
    node_mm: Array
    """(k, 3)."""
    jacobian: Array
    """(k, 3, A)."""
    covariance: Array
    """(1 + A, 1 + A) of a coordinate and its row of the Jacobian, the same for every coordinate."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ModelFreeState:
    """What the law remembers."""

    points: Points
    felt: Felt
    history: History
    """(A,) where the servos were."""
    following: Following
    probed_s: float
    """How much of the probing is done."""
    led: NDArray[np.intp]
    rate_mm_s: Array
    planned_s: float


class ModelFree:
    """The law for one plant, of which it knows the limits alone."""

    def __init__(self, tuning: Tuning, plant: Plant) -> None:
        """Nothing is felt yet."""
        self._tuning = tuning
        self._plant = plant
        self._allocation = Allocation(
            plant, damping_mm=tuning.damping_mm, insertion_cost=tuning.insertion_cost
        )
        self._posture_per_s = -tuning.posture_per_s * plant.kinematics.bending
        self.lead_s = tuning.servo_lag_s + tuning.robot_lag_s

    def start(self, beginning: Beginning[ModelFreeState]) -> ModelFreeState:
        """See `Law`. What was felt is kept while the same nodal points are seen; otherwise the axes are probed anew."""
        before, measured, command_mm = beginning.before, beginning.measured, beginning.command_mm
        if before is not None and same_points(before.felt.arc_mm, measured.arc_mm):
            felt, history, following = before.felt, before.history, before.following
            probed_s = before.probed_s
        else:
            felt, history = self._nothing(measured, command_mm), History.of(beginning.now_s, command_mm)
            following, probed_s = Following.at_rest(command_mm), 0.0
        return ModelFreeState(
            points=beginning.points,
            felt=felt,
            history=history,
            following=following,
            probed_s=probed_s,
            led=measured.led,
            rate_mm_s=np.zeros(len(command_mm)),
            planned_s=-np.inf,
        )

    def step(self, state: ModelFreeState, inputs: LawInputs) -> tuple[ModelFreeState, Array]:
        """See `Law`."""
        position_mm = state.history.values[-1] if inputs.drive is None else inputs.drive.position_mm
        state = dataclasses.replace(
            state,
            history=state.history.then(inputs.now_s, position_mm),
            following=state.following.then(
                inputs.command_mm, position_mm, inputs.dt_s, self._tuning.servo_lag_s
            ),
        )
        if inputs.measured is not None:
            state = self._seen(state, inputs.measured, inputs.command_mm)
        axes = np.flatnonzero(state.points.movable)
        if state.probed_s < len(axes) * self._tuning.probing_s:
            probed_s = state.probed_s + inputs.dt_s
            rate = (self._probe(axes, probed_s) - self._probe(axes, state.probed_s)) / inputs.dt_s
            rate = self._rates(state, Wish.none(len(rate)), rate, inputs)
            state = dataclasses.replace(state, probed_s=probed_s, rate_mm_s=rate)
        elif inputs.measured is not None or inputs.now_s - state.planned_s > PLAN_S:
            rate = self._plan(state, inputs)
            state = dataclasses.replace(state, rate_mm_s=rate, planned_s=inputs.now_s)
        return state, inputs.command_mm + state.rate_mm_s * inputs.dt_s

    def _seen(self, state: ModelFreeState, measured: Measurement, command_mm: Array) -> ModelFreeState:
        """Corrected by a shape; nodal points that were not seen before are felt for anew."""
        if not same_points(state.felt.arc_mm, measured.arc_mm):
            felt = self._nothing(measured, command_mm)
            return dataclasses.replace(state, felt=felt, led=measured.led, probed_s=0.0)
        felt = self._corrected(state.felt, measured, state.history.at(measured.capture_s))
        return dataclasses.replace(state, felt=felt, led=measured.led)

    def _nothing(self, measured: Measurement, command_mm: Array) -> Felt:
        tuning, axes = self._tuning, len(command_mm)
        sigma = np.append(tuning.measurement_noise_mm, np.full(axes, tuning.jacobian_sigma))
        return Felt(
            capture_s=measured.capture_s,
            arc_mm=measured.arc_mm,
            position_mm=command_mm,
            node_mm=measured.node_mm,
            jacobian=np.zeros((*measured.node_mm.shape, axes)),
            covariance=np.diag(sigma**2),
        )

    def _probe(self, movable: NDArray[np.intp], probed_s: float) -> Array:
        """(A,) where the probing has led by then: each axis out and back in turn."""
        turn, into_s = divmod(min(probed_s, len(movable) * self._tuning.probing_s), self._tuning.probing_s)
        way = np.zeros(self._plant.kinematics.axes)
        if turn < len(movable):
            way[movable[int(turn)]] = (1 - np.cos(2 * np.pi * into_s / self._tuning.probing_s)) / 2
        return way * self._tuning.probing_mm

    def _corrected(self, before: Felt, measured: Measurement, position_mm: Array) -> Felt:
        """One step of the filter."""
        tuning = self._tuning
        moved = position_mm - before.position_mm
        elapsed_s = max(measured.capture_s - before.capture_s, 0.0)
        transition = np.eye(len(moved) + 1)
        transition[0, 1:] = moved
        changed = np.full(len(moved), tuning.jacobian_change**2 * float(np.abs(moved).sum()))
        drift = np.append(tuning.wander_mm**2 * elapsed_s, changed)
        covariance = transition @ before.covariance @ transition.T + np.diag(drift)
        foreseen = before.node_mm + before.jacobian @ moved
        innovation = measured.node_mm - foreseen
        noise, surprise = tuning.measurement_noise_mm**2, float((innovation**2).mean())
        if surprise > _UNFORESEEN * (covariance[0, 0] + noise):
            covariance[0, 0] += surprise  # a blow or a slip moves the robot; it says nothing of its Jacobian
        kalman = covariance[0] / (covariance[0, 0] + noise)
        return Felt(
            capture_s=measured.capture_s,
            arc_mm=before.arc_mm,
            position_mm=position_mm,
            node_mm=foreseen + innovation * kalman[0],
            jacobian=before.jacobian + innovation[..., None] * kalman[1:],
            covariance=covariance - np.outer(kalman, covariance[0]),
        )

    def _ahead_mm(self, state: ModelFreeState, command_mm: Array) -> Array:
        """(k, 3) where nodal points will be once the command is followed."""
        felt = state.felt
        ahead: Array = felt.node_mm + felt.jacobian @ (command_mm - state.following.sag_mm - felt.position_mm)
        return ahead

    def _plan(self, state: ModelFreeState, inputs: LawInputs) -> Array:
        """Rates (A,) of the command that lead the nodal points."""
        wish = Wish.towards(
            inputs.desired,
            self._ahead_mm(state, inputs.command_mm)[state.led],
            state.felt.jacobian[state.led],
            state.points.weights,
            feedback_per_s=self._tuning.feedback_per_s,
            most_mm_s=self._plant.maximum_node_speed_mm_s,
        )
        current_ma = None if inputs.drive is None else inputs.drive.current_ma
        preferred = self._posture_per_s @ inputs.command_mm + tightening_mm_s(self._plant, current_ma)
        return self._rates(state, wish, preferred, inputs)

    def _rates(self, state: ModelFreeState, wish: Wish, preferred_mm_s: Array, inputs: LawInputs) -> Array:
        ones = np.ones(len(inputs.command_mm))
        return self._allocation.rates(
            wish,
            preferred_mm_s,
            state.points.movable,
            command_mm=inputs.command_mm,
            current_ma=None if inputs.drive is None else inputs.drive.current_ma,
            stretch=(ones, ones),
            body=Body(point_mm=self._ahead_mm(state, inputs.command_mm), jacobian=state.felt.jacobian),
        )


def make(tuning: Tuning, plant: Plant) -> ModelFree:
    """The law for this plant."""
    return ModelFree(tuning, plant)
