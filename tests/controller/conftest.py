"""A bench in virtual time for the pure loop: a robot, servos that lag, and a camera that is late and noisy."""

import copy
import dataclasses
from collections import deque
from collections.abc import Callable

import numpy as np
import pytest

from controller.cycle import Inputs, LoopState, Outputs, Sighting
from controller.loop import Loop
from controller.settings import ControllerSettings
from drivers.actuators import ActuatorState
from messaging.control import Action, ActionRequest, Target
from messaging.settings import RobotSettings
from messaging.shape import ShapeEstimate

PERIOD_S = 0.005
ROBOT = RobotSettings(section_length_mm=(40.0, 40.0))


def shape_of(
    node_mm, node_arc_mm, *, sequence=0, names=("middle", "tip"), refusal="", flags=(), insertion_mm=0.0
):
    """A ShapeEstimate with these nodal points, otherwise as empty as a message may be."""
    empty = refusal != ""
    names = () if empty else tuple(names)
    return ShapeEstimate(
        sequence=sequence,
        capture_time_ns=1,
        capture_to_publish_ns=20_000_000,
        refusal=refusal,
        method="refined",
        flags=tuple(flags),
        arc_mm=[] if empty else node_arc_mm,
        centreline_mm=np.zeros((0, 3)) if empty else node_mm,
        epipolar_angle_rad=[] if empty else np.ones(len(node_arc_mm)),
        node_names=names,
        node_arc_mm=[] if empty else node_arc_mm,
        node_mm=np.zeros((0, 3)) if empty else node_mm,
        node_covariance_mm2=np.zeros((len(names), 3, 3)),
        length_mm=80.0,
        known_length_mm=80.0,
        insertion_mm=insertion_mm,
        ray_gap_mm=0.0,
        ray_bias_mm=0.0,
        residual_px=0.0,
        camera_names=(),
        camera_residual_px=[],
        visible_mm=[],
        stage_names=(),
        stage_s=[],
    )


def circle(*, radius_mm=15.0, z_mm=82.0, period_s=10.0, node="tip", name="circle"):
    """A repeating circle of one nodal point around the axis."""
    turn = np.linspace(0, 2 * np.pi, 101)
    path = np.stack([radius_mm * np.cos(turn), radius_mm * np.sin(turn), np.full_like(turn, z_mm)], axis=-1)
    path[-1] = path[0]
    return Target(
        name=name,
        node_names=(node,),
        weights=[1.0],
        time_s=turn / (2 * np.pi) * period_s,
        position_mm=path[:, None],
        repeat=True,
    )


def pose(position_mm, *, node="tip", name="pose"):
    """One nodal point at one place."""
    return Target(
        name=name,
        node_names=(node,),
        weights=[1.0],
        time_s=[0.0],
        position_mm=np.reshape(position_mm, (1, 1, 3)),
        repeat=False,
    )


def led(time_s, places_mm, *, repeat=False, node="tip", name="path"):
    """One nodal point along these places (k, 3)."""
    return Target(
        name=name,
        node_names=(node,),
        weights=[1.0],
        time_s=time_s,
        position_mm=np.reshape(places_mm, (-1, 1, 3)),
        repeat=repeat,
    )


class PaperRobot:
    """The constant-curvature model with play and errors that a test chooses: cheap, and wrong enough to need feedback."""

    def __init__(
        self, kinematics, node_arc_mm=(40.0, 80.0), gain=0.8, offset_mm=(0.5, -0.8, -0.1), play_mm=0.3
    ):
        self._kinematics, self._arc = kinematics, np.array(node_arc_mm)
        self._gain, self._offset, self._play_mm = gain, offset_mm, play_mm
        self._pulled_mm = np.zeros(kinematics.tendons)

    def move(self, command_mm, dt_s):
        pairs = command_mm[:-1]
        self._pulled_mm = np.clip(self._pulled_mm, pairs - self._play_mm / 2, pairs + self._play_mm / 2)
        command_mm = np.append(self._gain * self._pulled_mm, command_mm[-1])
        return self._kinematics.nodes_mm(command_mm, self._arc) + self._offset


@dataclasses.dataclass
class Servos:
    """Servos that follow their goal with a lag, and hold still without torque."""

    position_mm: np.ndarray
    """As the servos report it."""
    zero_mm: np.ndarray | float = 0.0
    """Where the robot really is when they report zero."""
    lag_s: float = 0.03
    torque: bool = False
    goal_mm: np.ndarray | None = None
    hardware_error: int = 0
    current_ma: float | np.ndarray = 100.0
    temperature_c: float = 30.0
    voltage_v: float = 12.0
    pull_ma: Callable[[np.ndarray], np.ndarray] | None = None
    """The currents (A,) of positions (A,), where they are more than `current_ma`."""
    jammed: bool = False

    def obey(self, outputs):
        if outputs.release:
            self.torque, self.goal_mm = False, None
        if outputs.engage:
            self.torque = True
        if outputs.zero_mm is not None:
            self.zero_mm = self.zero_mm + self.position_mm - outputs.zero_mm
            self.position_mm = outputs.zero_mm.copy()
        if outputs.command_mm is not None:
            self.goal_mm = outputs.command_mm
        if self.torque and self.goal_mm is not None and not self.jammed:
            self.position_mm = self.position_mm + (1 - np.exp(-PERIOD_S / self.lag_s)) * (
                self.goal_mm - self.position_mm
            )

    @property
    def pulled_mm(self):
        return self.position_mm + self.zero_mm

    def state(self):
        return ActuatorState(
            displacement_mm=self.position_mm[:-1],
            displacement_mm_s=np.zeros(len(self.position_mm) - 1),
            insertion_mm=float(self.position_mm[-1]),
            insertion_mm_s=0.0,
            current_ma=self.current_ma + np.zeros(len(self.position_mm))
            if self.pull_ma is None
            else self.pull_ma(self.pulled_mm),
            temperature_c=np.full(len(self.position_mm), self.temperature_c),
            voltage_v=np.full(len(self.position_mm), self.voltage_v),
            hardware_error=(self.hardware_error,) + (0,) * (len(self.position_mm) - 1),
            torque=self.torque,
            alarm="pair 1: overload" if self.hardware_error else "",
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Moment:
    """One cycle of a virtual run."""

    now_s: float
    state: LoopState
    outputs: Outputs
    node_mm: np.ndarray


class VirtualBench:
    """Runs the loop against a robot. Tests reach in: `drive_absent`, `camera`, `extra_delay_s` and `servos` may be changed between runs."""

    def __init__(
        self, robot, settings=None, *, noise_mm=0.03, seed=0, node_arc_mm=(40.0, 80.0), section_settings=ROBOT
    ):
        settings = settings or ControllerSettings()
        self.loop = Loop(settings, section_settings)
        self.state = self.loop.start()
        self.now_s = 100.0
        self.robot, self.noise_mm, self.arc = robot, noise_mm, np.array(node_arc_mm)
        self.servos = Servos(position_mm=np.zeros(len(self.state.command_mm)))
        self.drive_absent = self.drive_fault = ""
        self.heartbeat = False
        self.extra_delay_s = 0.0
        self.camera: Callable[[ShapeEstimate], ShapeEstimate | None] = lambda shape: shape
        self._random = np.random.default_rng(seed)
        self._coming: deque[tuple[float, float, ShapeEstimate]] = deque()
        self._next_capture_s = self.now_s
        self._sequence = 0
        self.node_mm = robot.move(self.servos.pulled_mm, PERIOD_S)
        self._cycle = 0
        self._slow_s = 0.0

    def run(self, duration_s, *requests):
        """Cycles for this long; the requests come in the first. Returns the moments and the replies."""
        moments, replies = [], ()
        for cycle in range(round(duration_s / PERIOD_S)):
            moment = self.cycle(requests if cycle == 0 else ())
            replies = replies or moment.outputs.replies
            moments.append(moment)
        return moments, replies

    def do(self, action, duration_s=PERIOD_S):
        """One action; returns its reply."""
        return self.run(duration_s, ActionRequest(action=Action(action)))[1][0]

    def jog(self, axis, distance_mm, duration_s=PERIOD_S):
        """Jog one axis; returns the reply."""
        request = ActionRequest(action=Action.JOG, axis=axis, distance_mm=distance_mm)
        return self.run(duration_s, request)[1][0]

    def home(self):
        """Home to ready, or fail the test."""
        self.run(0.2)
        assert self.do("home").accepted
        for _ in range(4000):
            if self.cycle(()).state.mode != "homing":
                break
        assert self.state.mode == "ready", self.state.supervision

    def cycle(self, requests):
        self._capture()
        sighting = None
        while self._coming and self._coming[0][0] <= self.now_s:
            _, capture_s, shape = self._coming.popleft()
            sighting = Sighting(shape=shape, age_s=self.now_s - capture_s)
        inputs = Inputs(
            now_s=self.now_s,
            dt_s=PERIOD_S,
            sighting=sighting,
            drive=None if self.drive_absent else self.servos.state(),
            absence=self.drive_absent,
            absence_fault=self.drive_fault,
            requests=tuple(requests),
            heartbeat=self.heartbeat,
        )
        self.state, outputs = self.loop.step(self.state, inputs)
        if not self.drive_absent:
            self.servos.obey(outputs)
        self.node_mm = self.robot.move(self.servos.pulled_mm, PERIOD_S)
        self.now_s += PERIOD_S
        return Moment(now_s=inputs.now_s, state=self.state, outputs=outputs, node_mm=self.node_mm)

    def _capture(self):
        if self.now_s < self._next_capture_s:
            return
        self._next_capture_s += 1 / 30
        truth = self.node_mm
        seen = truth + self.noise_mm * self._random.normal(size=truth.shape)
        shape = self.camera(
            shape_of(seen, self.arc, sequence=self._sequence, insertion_mm=self.servos.position_mm[-1])
        )
        self._sequence += 1
        if shape is not None:
            arrives_s = self.now_s + self._random.uniform(0.02, 0.06) + self.extra_delay_s
            self._coming.append((arrives_s, self.now_s, shape))


@pytest.fixture
def paper_bench():
    """A VirtualBench around a PaperRobot, just started."""
    settings = ControllerSettings()
    return VirtualBench(PaperRobot(settings.kinematics(ROBOT)), settings)


@pytest.fixture(scope="session")
def homed_once():
    settings = ControllerSettings()
    bench = VirtualBench(PaperRobot(settings.kinematics(ROBOT)), settings)
    bench.home()
    return bench


@pytest.fixture(scope="session")
def tracking_once(homed_once):
    bench = copy.deepcopy(homed_once)
    _, (reply,) = bench.run(PERIOD_S, circle())
    assert reply.accepted, reply
    assert bench.do("arm", 3.0).accepted
    assert bench.state.mode == "tracking"
    return bench


@pytest.fixture
def homed(homed_once):
    """A homed VirtualBench around a PaperRobot."""
    return copy.deepcopy(homed_once)


@pytest.fixture
def tracking(tracking_once):
    """A homed VirtualBench that has followed a circle for three seconds."""
    return copy.deepcopy(tracking_once)


@pytest.fixture(scope="session")
def stand_ins():
    """What the tests of this room build benches from."""
    return {
        "VirtualBench": VirtualBench,
        "PaperRobot": PaperRobot,
        "shape_of": shape_of,
        "circle": circle,
        "pose": pose,
        "led": led,
        "ROBOT": ROBOT,
    }
