"""The virtual bench: a controller's loop against servos, robot and shapes, as fast as they can be computed."""

import copy
import dataclasses
import math
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from controller.cycle import Inputs, LoopState, Outputs, Request, Sighting
from controller.drive import Drive
from controller.loop import Loop
from controller.pace import MOST_PERIODS
from controller.settings import ControllerSettings
from controller.supervisor import Mode
from drivers.actuators import ActuatorState
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
        self.actuators = VirtualActuators(
            settings.servos, self.plant.servos, self.plant.nominal_mm_per_rad, self.plant.tendon_axes
        )
        self.seeing = Seeing(
            settings.shape,
            sum(section.length_mm for section in settings.robot.sections),
            settings.robot.centreline_points,
            robot.length_mm,
            _START_S,
            settings.seed,
        )
        self.state = (loop := loop or Loop(controller, robot)).start()
        self._loop = loop
        self._drive = Drive(self.actuators)
        self._period_s = 1 / controller.rate_hz
        self._cycles_per_step = max(1, round(settings.robot_step_s / self._period_s))
        self._cycle = 0
        self._missed = 0
        self._reason = ""
        self.sighted: Sighting | None = None
        """The shape that arrived last, whether it was trusted or not."""
        self.heard: ActuatorState | None = None
        """What the servos said last."""
        self._asked: tuple[Request, ...] = ()
        self._replies: tuple[Reply, ...] = ()

    @property
    def now_s(self) -> float:
        """Virtual time at which the next cycle begins."""
        return _START_S + self._cycle * self._period_s

    @property
    def absence(self) -> str:
        """Why the controller does not hear its servos; empty while it does."""
        return self._drive.absence

    def copy(self) -> Self:
        """Another bench in the same state."""
        return copy.deepcopy(self)

    def hand_over(self, loop: Controller) -> None:
        """From now on `loop` controls the bench, with the memory of the one before."""
        self._loop = loop

    def ask(self, *requests: Request) -> None:
        """What the next cycle is to be asked; the answer is among the replies of the next run."""
        self._asked += requests

    def run(self, duration_s: float, *requests: Request) -> tuple[Samples, tuple[Reply, ...]]:
        """Go on for `duration_s`, rounded up to whole steps of the robot; `requests` come in the first cycle."""
        self.ask(*requests)
        self._replies = ()
        steps = max(1, math.ceil(duration_s / (self._cycles_per_step * self._period_s) - 1e-9))
        return Samples.joined([self._step() for _ in range(steps)]), self._replies

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
        if not reply.accepted:
            raise VirtualBenchError(f"homing was refused: {reply.reason}")
        end_s = self.now_s + within_s
        while self.state.mode == "homing" and self.now_s < end_s:
            self.run(0.1)
        if self.state.mode != "ready":
            raise VirtualBenchError(f"homing ended in {self.state.mode}: {self.state.supervision.reason}")

    def _step(self) -> Samples:
        """The cycles up to the robot's next step, and that step; the sample is of the moment at which they begin."""
        start_s, before = self.now_s, self.plant.state
        commands_mm = np.full((1, self._cycles_per_step, self.plant.axes), np.nan)
        for cycle in range(self._cycles_per_step):
            command_mm = self._act()
            if command_mm is not None:
                commands_mm[0, cycle] = command_mm
            if cycle == 0:
                sample = self._sample()
            self.plant.turn(self._period_s, self.now_s)
            self._cycle += 1
        after = self.plant.follow(self._cycles_per_step * self._period_s)
        self.seeing.look((start_s, before.shape.centreline_mm), (self.now_s, after.shape.centreline_mm))
        return dataclasses.replace(sample, command_mm=commands_mm)

    def _act(self) -> Array | None:
        """One cycle of the controller, or none while it waits for its drive; the command (A,) that it gave."""
        now_s = self.now_s
        if not self.actuators.pass_time(now_s):
            self._missed += 1
            return None
        drive = self._drive.read(now_s)
        self.heard = drive or self.heard
        inputs = Inputs(
            now_s=now_s,
            dt_s=min(self._missed + 1, MOST_PERIODS) * self._period_s,
            sighting=self._looked(now_s),
            drive=drive,
            absence=self._drive.absence,
            absence_fault=self._drive.absence_fault,
            requests=self._asked,
        )
        self.state, outputs = self._loop.step(self.state, inputs)
        self._drive.act(outputs, now_s)
        self._missed, self._asked = 0, ()
        self._replies += outputs.replies
        self._reason = outputs.reason
        return outputs.command_mm

    def _looked(self, now_s: float) -> Sighting | None:
        sighting = self.seeing.arrived(now_s)
        self.sighted = sighting or self.sighted
        return sighting

    def _sample(self) -> Samples:
        servos, names = self.plant.servos, self.seeing.settings.node_names
        return Samples(
            now_s=np.array([self.now_s]),
            desired_mm=_desired(self.state, self.now_s, names)[None],
            node_mm=self.seeing.nodes(self.plant.state.shape.centreline_mm)[None],
            command_mm=np.full((1, 0, self.plant.axes), np.nan),
            current_ma=np.array([[servo.motor.current_A * 1e3 for servo in servos]]),
            tension_N=self.plant.state.tendon_tension_N[None],
            torque=np.array([any(servo.torque_enabled for servo in servos)]),
            mode=(str(self.state.mode),),
            reason=(self._reason,),
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
