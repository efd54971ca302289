"""The virtual bench: a controller's loop against servos, robot and shapes, as fast as they can be computed."""

import copy
import math
from collections.abc import Sequence
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from controller.cycle import Inputs, LoopState, Outputs, Request
from controller.drive import Drive
from controller.loop import Loop
from controller.settings import ControllerSettings
from controller.supervisor import Mode
from messaging.control import Action, ActionRequest, Reply, Target
from messaging.settings import RobotSettings
from nodal.virtual.actuators import VirtualActuators
from nodal.virtual.errors import VirtualBenchError
from nodal.virtual.plant import Plant
from nodal.virtual.samples import Samples
from nodal.virtual.seeing import Seeing
from nodal.virtual.settings import VirtualBenchSettings

Array = NDArray[np.float64]

_START_S = 100.0
_MOST_PERIODS = 4
"""How many missed cycles a command may make up for at once, as on a real bench."""


class Controller(Protocol):
    """What runs on the bench: `controller.loop.Loop`, or anything that steps like it."""

    def start(self) -> LoopState: ...

    def step(self, state: LoopState, inputs: Inputs) -> tuple[LoopState, Outputs]: ...


class VirtualBench:
    """One bench. `plant`, `actuators` and `seeing` may be changed between runs: that is how things go wrong."""

    def __init__(
        self,
        settings: VirtualBenchSettings,
        controller: ControllerSettings,
        robot: RobotSettings,
        loop: Controller | None = None,
    ) -> None:
        """`loop` is the controller's own unless given. Raises RobotBuildError, ControllerSetupError."""
        self.settings = settings
        self.plant = Plant(settings)
        self.actuators = VirtualActuators(settings.servos, self.plant.servos, self.plant.nominal_mm_per_rad)
        self.seeing = Seeing(
            settings.shape,
            sum(section.length_mm for section in settings.robot.sections),
            settings.robot.centreline_points,
            robot.length_mm,
            settings.seed,
        )
        self.state = (loop := loop or Loop(controller, robot)).start()
        self._loop = loop
        self._drive = Drive(self.actuators)
        self._period_s = 1 / controller.rate_hz
        self._cycles_per_step = max(1, round(settings.robot_step_s / self._period_s))
        self._cycle = 0
        self._missed = 0
        self._centreline_mm = self.plant.state.shape.centreline_mm

    @property
    def now_s(self) -> float:
        """Virtual time at which the next cycle begins."""
        return _START_S + self._cycle * self._period_s

    def copy(self) -> Self:
        """Another bench in the same state."""
        return copy.deepcopy(self)

    def hand_over(self, loop: Controller) -> None:
        """From now on `loop` controls the bench, with the memory of the one before."""
        self._loop = loop

    def run(self, duration_s: float, *requests: Request) -> tuple[Samples, tuple[Reply, ...]]:
        """Go on for `duration_s`, rounded up to whole steps of the robot; `requests` come in the first cycle."""
        steps = max(1, math.ceil(duration_s / (self._cycles_per_step * self._period_s) - 1e-9))
        parts: list[Samples] = []
        replies: list[Reply] = []
        for _ in range(steps):
            part, answers = self._step(requests)
            requests = ()
            parts.append(part)
            replies += answers
        return Samples.joined(parts), tuple(replies)

    def do(self, action: str) -> Reply:
        """Ask for one action; time goes on by one step of the robot."""
        return self.run(0.0, ActionRequest(action=Action(action)))[1][0]

    def target(self, target: Target) -> Reply:
        """Give a target; time goes on by one step of the robot."""
        return self.run(0.0, target)[1][0]

    def home(self, within_s: float = 30.0) -> None:
        """Home to ready; raises VirtualBenchError when that fails."""
        self.run(0.5)
        reply = self.do("home")
        end_s = self.now_s + within_s
        while reply.accepted and self.state.mode == "homing" and self.now_s < end_s:
            self.run(0.1)
        if self.state.mode != "ready":
            raise VirtualBenchError(
                f"homing ended in {self.state.mode}: {self.state.supervision.reason if reply.accepted else reply.reason}"
            )

    def _step(self, requests: Sequence[Request]) -> tuple[Samples, tuple[Reply, ...]]:
        start_s, before = self.now_s, self._centreline_mm
        rows: list[tuple[LoopState, Outputs | None, Array, bool]] = []
        replies: tuple[Reply, ...] = ()
        for _ in range(self._cycles_per_step):
            outputs = self._controlled(tuple(requests)) if self.actuators.waited_s <= 0 else None
            if outputs is None:
                self.actuators.waited_s = max(self.actuators.waited_s - self._period_s, 0.0)
                self._missed += 1
            else:
                requests, replies = (), replies + outputs.replies
            currents = np.array([servo.motor.current_A * 1e3 for servo in self.plant.servos])
            torque = any(servo.torque_enabled for servo in self.plant.servos)
            rows.append((self.state, outputs, currents, torque))
            self.plant.turn(self._period_s, self.now_s)
            self._cycle += 1
        state = self.plant.follow(self._cycles_per_step * self._period_s)
        self._centreline_mm = state.shape.centreline_mm
        self.seeing.look((start_s, before), (self.now_s, self._centreline_mm))
        return self._samples(start_s, before, rows), replies

    def _controlled(self, requests: tuple[Request, ...]) -> Outputs:
        self.actuators.now_s = now_s = self.now_s
        drive = self._drive.read(now_s)
        inputs = Inputs(
            now_s=now_s,
            dt_s=min(self._missed + 1, _MOST_PERIODS) * self._period_s,
            sighting=self.seeing.arrived(now_s),
            drive=drive,
            absence=self._drive.absence,
            requests=requests,
        )
        self._missed = 0
        self.state, outputs = self._loop.step(self.state, inputs)
        self._drive.act(outputs, now_s)
        return outputs

    def _samples(
        self,
        start_s: float,
        before_mm: Array,
        rows: Sequence[tuple[LoopState, Outputs | None, Array, bool]],
    ) -> Samples:
        states, outputs, currents, torque = zip(*rows, strict=True)
        old, new = self.seeing.nodes(before_mm), self.seeing.nodes(self._centreline_mm)
        share = np.arange(len(rows)) / len(rows)
        times = start_s + self._period_s * np.arange(len(rows))
        names = self.seeing.settings.node_names
        nothing = np.full(self.plant.axes, np.nan)
        return Samples(
            now_s=times,
            desired_mm=np.array([_desired(s, t, names) for s, t in zip(states, times.tolist(), strict=True)]),
            node_mm=old + share[:, None, None] * (new - old),
            command_mm=np.array(
                [nothing if o is None or o.command_mm is None else o.command_mm for o in outputs]
            ),
            current_ma=np.array(currents),
            tension_N=np.tile(self.plant.state.tendon_tension_N, (len(rows), 1)),
            torque=np.array(torque),
            mode=tuple(str(state.mode) for state in states),
            reason=tuple("" if o is None else o.reason for o in outputs),
            node_names=names,
        )


def _desired(state: LoopState, now_s: float, names: tuple[str, ...]) -> Array:
    """(m, 3) where the controller leads the nodal points at this moment."""
    desired = np.full((len(names), 3), np.nan)
    if state.task is not None and state.mode in (Mode.TRACKING, Mode.HOMING):
        reference = state.task.reference
        for name, place in zip(reference.target.node_names, reference.at(now_s).node_mm, strict=True):
            desired[names.index(name)] = place
    return desired
