"""The law `resolved_rate`: velocity feed-forward and feedback through a model that learns what it misses while it runs.

Where nodal points are and how they move is believed by controller/belief.py, which every shape corrects: it is compared
with where the axes had brought the robot when its frames were taken, by what the servos report, a robot's lag of
`robot_lag_s` earlier. So delay is no part of the feedback: the law acts on where the points will be once servos and robot
have followed the command of now, less by how much servos stay behind under load.

Rates come from a quadratic programme within all limits (controller/allocation.py), pulled towards the straight posture in
what freedom is left. They are found anew for each shape, and at the latest after `PLAN_S`; in between they go on. Where an
axis turns round it moves further by its lost motion (controller/lost_motion.py).
"""

import dataclasses
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.allocation import PLAN_S, Allocation, Body, Wish, tightening_mm_s
from controller.belief import Axes, Belief, BeliefSettings, Learning
from controller.following import Following, nearer
from controller.history import History
from controller.law import Beginning, LawInputs, Points
from controller.lost_motion import engaged_after, motion_for, stretch
from controller.plant import Plant

Array = NDArray[np.float64]

_LED_ON_S = 0.1
"""After a longer pause the robot is seen anew: something else may have moved it."""


class Tuning(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings of the law `resolved_rate`."""

    feedback_per_s: Annotated[float, msgspec.Meta(gt=0, le=100)] = 18.0
    """Speed per distance with which an error is made good."""
    servo_lag_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.045
    """Time constant with which servos follow their commands."""
    robot_lag_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.03
    """Time constant with which the robot follows its servos."""
    engaging_mm: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.1
    """Within how much motion after turning round play and friction are crossed."""
    damping_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.5
    """Motion of a nodal point per mm of tendon below which the law gives up rather than pull hard."""
    insertion_cost: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.1
    """What a mm of the stage costs beside a mm of tendon, where either would do."""
    posture_per_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.5
    """How fast the tendons go back to zero in directions that move no nodal point."""
    belief: BeliefSettings = BeliefSettings()
    """How far the robot may be from its model, and how long what was learnt is kept."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ResolvedRateState:
    """What the law remembers."""

    points: Points
    belief: Belief
    axes: Axes
    """As the servos report them."""
    history: History
    """(2 A,) of `axes`, as far as the robot has followed."""
    following: Following
    rate_mm_s: Array
    """(A,) as it is to be felt."""
    planned_s: float


class ResolvedRate:
    """The law for one plant."""

    def __init__(self, tuning: Tuning, plant: Plant) -> None:
        """The law never asks a nodal point to move faster than the plant allows, to catch up neither."""
        self._tuning = tuning
        self._plant = plant
        self._learning = Learning(tuning.belief, plant.kinematics, plant.identified)
        self._allocation = Allocation(
            plant, damping_mm=tuning.damping_mm, insertion_cost=tuning.insertion_cost
        )
        self._posture_per_s = -tuning.posture_per_s * plant.kinematics.bending
        self.lead_s = tuning.servo_lag_s + tuning.robot_lag_s

    def start(self, beginning: Beginning[ResolvedRateState]) -> ResolvedRateState:
        """See `Law`. What was learnt of the robot is kept, whichever points are led."""
        before, measured, command_mm = beginning.before, beginning.measured, beginning.command_mm
        if before is None:
            axes = Axes(position_mm=command_mm, engaged=np.zeros(len(command_mm)))
            history, following = History.of(beginning.now_s, _stacked(axes)), Following.at_rest(command_mm)
            belief = self._learning.begin(measured, axes, beginning.lost_motion_mm)
        elif beginning.now_s - before.history.times_s[-1] < _LED_ON_S:
            axes, history, following = before.axes, before.history, before.following
            belief = self._learning.at_points(before.belief, measured, axes)
        else:
            axes, following = self._told(before, command_mm), before.following.resting(command_mm)
            history = History.of(beginning.now_s, _stacked(axes))
            belief = self._learning.seen_anew(before.belief, measured, axes)
        return ResolvedRateState(
            points=beginning.points,
            belief=belief,
            axes=axes,
            history=history,
            following=following,
            rate_mm_s=np.zeros(len(command_mm)),
            planned_s=-np.inf,
        )

    def step(self, state: ResolvedRateState, inputs: LawInputs) -> tuple[ResolvedRateState, Array]:
        """See `Law`."""
        state = self._followed(state, inputs)
        if inputs.measured is not None:
            position_mm, engaged = np.split(state.history.at(inputs.measured.capture_s), 2)
            then = Axes(position_mm=position_mm, engaged=engaged)
            belief = self._learning.corrected(state.belief, inputs.measured, then)
            state = dataclasses.replace(state, belief=belief)
        told = self._told(state, inputs.command_mm)
        width_mm, engaging_mm = self._learning.lost_motion_mm(state.belief), self._tuning.engaging_mm
        if inputs.measured is not None or inputs.now_s - state.planned_s > PLAN_S:
            rate = self._plan(state, told, width_mm, inputs)
            state = dataclasses.replace(state, rate_mm_s=rate, planned_s=inputs.now_s)
        motion = motion_for(state.rate_mm_s * inputs.dt_s, told.engaged, width_mm, engaging_mm)
        return state, inputs.command_mm + motion

    def _told(self, state: ResolvedRateState, command_mm: Array) -> Axes:
        """Where the axes will be once the servos have followed this command."""
        position_mm = command_mm - state.following.sag_mm
        width_mm = self._learning.lost_motion_mm(state.belief)
        moving = position_mm - state.axes.position_mm
        engaged = engaged_after(state.axes.engaged, moving, width_mm, self._tuning.engaging_mm)
        return Axes(position_mm=position_mm, engaged=engaged)

    def _followed(self, state: ResolvedRateState, inputs: LawInputs) -> ResolvedRateState:
        """Where servos and robot have got to by now."""
        tuning, axes, following = self._tuning, state.axes, state.following
        if inputs.drive is not None:
            position_mm = inputs.drive.position_mm
            moved, width_mm = position_mm - axes.position_mm, self._learning.lost_motion_mm(state.belief)
            engaged = engaged_after(axes.engaged, moved, width_mm, tuning.engaging_mm)
            axes = Axes(position_mm=position_mm, engaged=engaged)
            following = following.then(inputs.command_mm, position_mm, inputs.dt_s, tuning.servo_lag_s)
        reached = nearer(state.history.values[-1], _stacked(axes), inputs.dt_s / tuning.robot_lag_s)
        return dataclasses.replace(
            state,
            axes=axes,
            history=state.history.then(inputs.now_s, reached),
            following=following,
        )

    def _plan(self, state: ResolvedRateState, told: Axes, width_mm: Array, inputs: LawInputs) -> Array:
        """Rates (A,), as they are to be felt."""
        points, plant = state.points, self._plant
        led = len(points.arc_mm)
        arc_mm = np.append(points.arc_mm, plant.body_arc_mm) if len(plant.regions) else points.arc_mm
        felt_mm = self._learning.felt_mm(state.belief, told)
        known, jacobian = self._learning.nodes(state.belief, felt_mm, arc_mm)
        current_ma = None if inputs.drive is None else inputs.drive.current_ma
        return self._allocation.rates(
            Wish.towards(
                inputs.desired,
                known[:led],
                jacobian[:led],
                points.weights,
                feedback_per_s=self._tuning.feedback_per_s,
                most_mm_s=plant.maximum_node_speed_mm_s,
            ),
            self._posture_per_s @ inputs.command_mm + tightening_mm_s(plant, current_ma),
            points.movable,
            command_mm=inputs.command_mm,
            current_ma=current_ma,
            stretch=stretch(told.engaged, width_mm, self._tuning.engaging_mm),
            body=Body(point_mm=known[led:], jacobian=jacobian[led:]),
        )


def make(tuning: Tuning, plant: Plant) -> ResolvedRate:
    """The law for this plant."""
    return ResolvedRate(tuning, plant)


def _stacked(axes: Axes) -> Array:
    return np.concatenate([axes.position_mm, axes.engaged])
