"""How each mode moves: what is set up when a mode is entered, and the next command. Pure."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from controller import task as tasks
from controller.cycle import Inputs, LoopState
from controller.laws import make_law
from controller.plant import Plant
from controller.reference import Reference
from controller.settings import ControllerSettings
from controller.supervisor import Mode
from controller.task import Seen, Task
from drivers.actuators import ActuatorState

Array = NDArray[np.float64]


class Motion:
    """The tendons and the stage of one robot."""

    def __init__(self, settings: ControllerSettings, plant: Plant) -> None:
        """Raises ControllerSetupError when the settings name no law."""
        self._settings = settings
        self._kinematics = plant.kinematics
        self._limits = plant.limits
        self._law = make_law(settings, plant)
        self._all_axes = np.ones(self._kinematics.axes, dtype=bool)
        self._tendons_only = np.arange(self._kinematics.axes) < self._kinematics.tendons
        self._lost_motion_mm = np.full(self._kinematics.axes, np.nan)

    def prepare(
        self, state: LoopState, before: Mode, now_s: float, drive: ActuatorState | None, *, retargeted: bool
    ) -> LoopState:
        """Set up what the mode needs when it was entered just now, or when its target changed."""
        entered = state.mode is not before
        if entered and before is Mode.TRACKING and state.task is not None and not retargeted:
            state = dataclasses.replace(state, joined_s=state.task.reference.path_s(now_s))
        if state.mode is Mode.HOMING and entered:
            if not before.torque and drive is not None:
                state = dataclasses.replace(state, command_mm=self._taken_up(drive.insertion_mm))
            return dataclasses.replace(state, task=self._homing(state, now_s), straight_since_s=np.inf)
        if state.mode is Mode.READY and entered:
            return dataclasses.replace(state, command_mm=self._taken_up(state.command_mm[-1]), task=None)
        if state.mode is Mode.TRACKING and (entered or retargeted):
            return dataclasses.replace(state, task=self._tracking(state, now_s, led=not entered))
        if (entered and state.mode is not Mode.WAITING) or (retargeted and state.mode is Mode.WAITING):
            return dataclasses.replace(state, task=None)
        return state

    def _taken_up(self, insertion_mm: float) -> Array:
        """The command that calls the present displacements zero."""
        low_mm, high_mm = self._limits.stage_mm
        insertion_mm = min(max(insertion_mm, low_mm), high_mm)
        return np.append(np.zeros(self._kinematics.tendons), insertion_mm)[: self._kinematics.axes]

    def _homing(self, state: LoopState, now_s: float) -> Task | None:
        if state.seen is None:
            return None
        target = tasks.straight_target(state.seen.shape)
        reference = Reference.towards(
            target, state.seen.shape.node_mm, now_s, self._settings.homing.node_speed_mm_s
        )
        return tasks.begin(
            self._law,
            reference,
            state.seen,
            self._tendons_only,
            before=None,
            command_mm=state.command_mm,
            lost_motion_mm=self._lost_motion_mm,
            now_s=now_s,
        )

    def _tracking(self, state: LoopState, now_s: float, *, led: bool) -> Task | None:
        """`led`: nodal points follow a target already, and go on from where they are led."""
        if state.seen is None or state.target is None:
            return None
        reference = Reference.towards(
            state.target,
            tasks.starting_points(state.target, state.seen, state.task if led else None, now_s),
            now_s,
            self._settings.maximum_node_speed_mm_s,
            state.joined_s,
        )
        return tasks.begin(
            self._law,
            reference,
            state.seen,
            self._all_axes,
            before=state.task,
            command_mm=state.command_mm,
            lost_motion_mm=self._lost_motion_mm,
            now_s=now_s,
        )

    def move(
        self, state: LoopState, before: Mode, fresh: Seen | None, inputs: Inputs
    ) -> tuple[LoopState, str]:
        """The next command, and in words how it was cut short; raises CommandNotFiniteError."""
        wanted, task = state.command_mm, state.task
        if state.mode is Mode.RELAXING:
            most = self._settings.relax_mm_s * inputs.dt_s
            wanted = np.append(wanted[:-1] - np.clip(wanted[:-1], -most, most), wanted[-1])
        elif task is not None and state.mode is before and self._may_follow(state, inputs.now_s):
            task, wanted = tasks.advance(
                self._law,
                task,
                fresh,
                command_mm=wanted,
                drive=inputs.drive,
                now_s=inputs.now_s,
                dt_s=inputs.dt_s,
            )
            if state.mode is Mode.HOMING and fresh is not None:
                straight = task.settled(self._settings.homing.within_mm, inputs.now_s)
                since_s = min(state.straight_since_s, inputs.now_s) if straight else np.inf
                state = dataclasses.replace(state, straight_since_s=since_s)
        if not state.mode.torque:
            return state, ""
        limited = self._limits.apply(wanted, state.command_mm, inputs.dt_s)
        trouble = state.trouble.pushing("; ".join(limited.at_travel), inputs.now_s)
        state = dataclasses.replace(state, command_mm=limited.command_mm, task=task, trouble=trouble)
        return state, "; ".join((*limited.at_travel, *limited.at_rate))

    def _may_follow(self, state: LoopState, now_s: float) -> bool:
        """Homing has no mode of its own for waiting, so it stands still here while no shape is trusted."""
        return state.mode is Mode.TRACKING or (
            state.mode is Mode.HOMING and not state.blind(now_s, self._settings.sensing.timeout_s)
        )
