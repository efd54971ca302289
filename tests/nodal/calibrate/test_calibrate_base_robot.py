"""The robot frame by the robot itself: a simulated robot in virtual time, photographed by simulated cameras."""

import os
import signal
import threading
from contextlib import nullcontext, redirect_stderr
from io import StringIO
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from calibration.base import BasesFound, apart_from
from calibration.camera_set import CameraSet
from controller.settings import JogSettings
from drivers.cameras import CameraFrame
from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.robot.settings import SimulatedRobotSettings
from messaging import topics
from messaging.control import Action, ControllerState, Reply, State
from nodal.__main__ import main
from nodal.calibrate.base import finding
from nodal.calibrate.base.moving import moving_robot
from nodal.calibrate.hand import BenchHand, Glimpse
from nodal.calibration.folder import save_json
from nodal.calibration_file import load_rig
from nodal.errors import CalibrationError, RobotStoppedError
from nodal.running import ENDING

TURN_S, TURN_MM = 0.1, 0.25
TENDONS = 4


class VirtualHand:
    """A controller that jogs and relaxes as the real one does, and the robot that it moves, in a time of their own."""

    def __init__(self, robot=None, stage_mm=0.0, wrong=()):
        """`wrong` are tendons that go the other way than they are told."""
        self.now_s = 1000.0
        self.state = State.IDLE
        self.asked = []
        self.command_mm = np.append(np.zeros(TENDONS), stage_mm)
        self.goal_mm = self.command_mm.copy()
        self.refuse_after = np.inf
        self.fault_after = self.silent_after = np.inf
        self.at_jog = {}
        self._robot = robot
        self._signs = np.where(np.isin(np.arange(TENDONS), wrong), -1.0, 1.0)
        self._step()

    def ask(self, action, axis="", distance_mm=0.0):
        self.asked.append((action, axis, distance_mm))
        self.at_jog.get(len(self.asked), lambda: None)()
        if len(self.asked) > self.refuse_after and action is Action.JOG:
            return Reply(accepted=False, state=self.state, reason="beyond its travel", advice="turn it back")
        if action is Action.JOG:
            self.state = State.UNHOMED
            number = TENDONS if axis == "stage" else int(axis) - 1
            self.goal_mm[number] = self.command_mm[number] + distance_mm
        else:
            self.state = State.IDLE
        return Reply(accepted=True, state=self.state, reason="")

    def watch(self):
        if len(self.asked) > self.silent_after:
            raise CalibrationError("the controller has been silent for 1 s")
        if len(self.asked) > self.fault_after and self.state is State.UNHOMED:
            self.state = State.FAULT
        self._step()
        told = self.state is State.UNHOMED
        return Glimpse(
            now_s=self.now_s,
            state=self.state,
            reason="no answer from servo 3" if self.state is State.FAULT else "",
            advice="look at the cable" if self.state is State.FAULT else "",
            fault="drive_lost" if self.state is State.FAULT else "",
            absence="",
            command_mm=self.command_mm.copy() if told else np.full(TENDONS + 1, np.nan),
            position_mm=self.command_mm.copy(),
            current_ma=np.zeros(TENDONS + 1),
            shape=None,
            captured_s=0.0,
        )

    def _step(self):
        self.now_s += TURN_S
        self.command_mm += np.clip(self.goal_mm - self.command_mm, -TURN_MM, TURN_MM)
        if self._robot is not None:
            step = self._robot.step(
                self._signs * self.command_mm[:TENDONS], float(self.command_mm[-1]), TURN_S
            )
            self.centreline_mm = step.shape.centreline_mm


class VirtualCamera:
    """A picture of the virtual robot each time that its time has gone on."""

    ended = False

    def __init__(self, hand, calibration, seed):
        self.name = calibration.camera
        self._hand, self._read_s, self._number = hand, 0.0, 0
        settings = SimulatedCamerasSettings()
        self._renderer = Renderer(calibration, np.array([40.0, 80.0]), settings, seed)

    def read(self):
        if self._hand.now_s <= self._read_s:
            return None
        self._read_s, self._number = self._hand.now_s, self._number + 1
        still = self._hand.centreline_mm
        return CameraFrame(
            name=self.name,
            jpeg=self._renderer.render(still, still),
            capture_monotonic_ns=int(self._read_s * 1e9),
            number=self._number,
        )

    def close(self):
        pass


def calibrate_base(bench, hand, *words):
    """The command's status on a bench whose cameras are calibrated, with this hand in place of its processes."""
    rig = default_cameras()
    (bench.parent / "calibration").mkdir()
    save_json(bench.parent / "calibration" / "cameras.json", CameraSet.of_rig(rig))
    cameras = [VirtualCamera(hand, camera, seed) for seed, camera in enumerate(rig)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(finding, "with_processes", lambda *_: nullcontext())
        patch.setattr(finding, "open_cameras", lambda *_, **__: nullcontext(cameras))
        patch.setattr(finding, "person_at", lambda *_: SimpleNamespace(please=lambda scene: None))
        patch.setattr(finding, "BenchHand", lambda _: hand)
        return main(["calibrate", "base", "--config", str(bench), "--robot", *words])


@pytest.fixture(scope="module")
def found(tmp_path_factory, make_bench):
    """The bench that was calibrated by its robot, the hand that led it, the base, and what was said; the first tendon has the wrong
    sign.
    """
    bench = make_bench(tmp_path_factory.mktemp("base"))
    hand = VirtualHand(SimulatedRobot(SimulatedRobotSettings()), wrong=(0,))
    with pytest.MonkeyPatch.context() as patch, redirect_stderr(StringIO()) as said:
        patch.setattr(finding, "stop_on_signals", threading.Event)
        assert calibrate_base(bench, hand) == 0
    kept = msgspec.json.decode((bench.parent / "calibration/base.json").read_bytes(), type=BasesFound)
    return bench, hand, kept.robot, said.getvalue()


def test_the_frame_is_found_as_exactly_as_is_said_of_it(found):
    _, _, base, _ = found
    rig = default_cameras()
    apart = apart_from(rig[0].camera_from_robot, base.matrix)
    assert apart.origin_mm < min(0.2, 3 * base.origin_sigma_mm)
    assert apart.axis_rad < min(np.radians(0.1), 3 * base.axis_sigma_rad)
    assert abs(apart.roll_rad) < min(np.radians(0.5), 3 * base.roll_sigma_rad)
    assert max(base.residual_px.values()) < 0.1
    assert base.robot.travel_mm == pytest.approx(15.0, abs=0.1)
    assert base.robot.stage_scale == pytest.approx(1.0, abs=0.005)


def test_the_robot_is_led_back_and_let_go(found):
    _, hand, _, _ = found
    assert hand.asked[-1][0] is Action.RELAX
    assert hand.command_mm == pytest.approx(np.zeros(TENDONS + 1), abs=1e-6)
    assert max(abs(distance) for _, _, distance in hand.asked) <= JogSettings().at_most_mm


def test_the_rig_is_written_in_the_frame_that_was_found(found):
    bench, _, base, _ = found
    for true, written in zip(default_cameras(), load_rig(bench.parent / "calibration/rig.json"), strict=True):
        camera_from_rig = true.camera_from_robot @ np.linalg.inv(default_cameras()[0].camera_from_robot)
        np.testing.assert_allclose(written.camera_from_robot, camera_from_rig @ base.matrix, atol=1e-9)


def test_a_wrong_sign_is_no_hindrance_and_told_of(found):
    _, _, base, said = found
    assert [pull.reversed for pull in base.robot.pulls] == [True, False, False, False]
    assert "by proximal y, distal x, distal y, the sign of mm_per_rad is wrong for proximal x: " in said


@pytest.fixture
def own_signals():
    """Signals are handled as before afterwards."""
    before = {number: signal.getsignal(number) for number in ENDING}
    yield
    signal.set_wakeup_fd(-1)
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", ENDING)
@pytest.mark.usefixtures("own_signals")
def test_a_signal_lets_the_tendons_go_and_nothing_is_written(bench, number, capsys):
    hand = VirtualHand(SimulatedRobot(SimulatedRobotSettings()))
    hand.at_jog = {3: lambda: os.kill(os.getpid(), number)}
    assert calibrate_base(bench, hand) == 130
    assert hand.asked[-1][0] is Action.RELAX
    assert "the tendons are let go" in capsys.readouterr().err
    assert not (bench.parent / "calibration/rig.json").exists()


def lead(hand, *jogs, at_most_mm=5.0, error=None):
    """Jog axes by distances, then meet with an error if there is one."""
    with moving_robot(hand, JogSettings(at_most_mm=at_most_mm), TENDONS, lambda: None) as mover:
        for axis, distance_mm in jogs:
            mover.jog(axis, distance_mm)
        if error is not None:
            raise error
        return mover.stage_mm


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ValueError()])
def test_the_tendons_are_let_go_whatever_happens(error):
    hand = VirtualHand()
    with pytest.raises(type(error)):
        lead(hand, (0, 1.0), error=error)
    assert hand.asked == [(Action.JOG, "1", 1.0), (Action.RELAX, "", 0.0)]


@pytest.mark.parametrize("state", [State.TRACKING, State.HOMING, State.FAULT])
def test_a_robot_that_somebody_else_leads_is_left_alone(state):
    hand = VirtualHand()
    hand.state = state
    with pytest.raises(RobotStoppedError, match=f"its controller is in {state}"):
        lead(hand, (0, 1.0))
    assert hand.asked == []


def test_long_ways_are_jogged_in_parts_and_waited_for():
    hand = VirtualHand(stage_mm=3.0)
    assert lead(hand, (TENDONS, -5.0), at_most_mm=2.0) == pytest.approx(-2.0, abs=0.03)
    assert [axis for action, axis, _ in hand.asked if action is Action.JOG] == ["stage"] * 3


def test_a_refused_jog_ends_it_with_the_controllers_reason():
    hand = VirtualHand()
    hand.refuse_after = 1
    with pytest.raises(RobotStoppedError, match="jog of stage by 1 mm was refused: beyond its") as stopped:
        lead(hand, (0, 1.0), (TENDONS, 1.0))
    assert stopped.value.advice == "turn it back"
    assert hand.asked[-1][0] is Action.RELAX


def test_a_fault_ends_it_with_its_advice():
    hand = VirtualHand()
    hand.fault_after = 1
    with pytest.raises(RobotStoppedError, match="tendon 2 by 1 mm ended in fault: no answer") as stopped:
        lead(hand, (0, 1.0), (1, 1.0))
    assert stopped.value.advice == "look at the cable"


def test_what_went_wrong_is_not_hidden_by_a_controller_that_is_silent_afterwards(capsys):
    hand = VirtualHand()
    hand.silent_after = 1
    with pytest.raises(ValueError, match="first"):
        lead(hand, (0, 1.0), error=ValueError("first"))
    assert "warning: the controller has been silent" in capsys.readouterr().err


class BusWithoutServos:
    """The bus of a bench whose controller runs and has found no servos."""

    def newest(self, topic):
        state = ControllerState(
            time_ns=1,
            state=State.IDLE,
            reason="started",
            target_name="",
            node_names=(),
            desired_mm=np.empty((0, 3)),
            measured_mm=np.empty((0, 3)),
            tracking_error_mm=0.0,
            shape_sequence=0,
            shape_age_s=0.0,
            lateness_s=0.0,
            busy_s=0.0,
            overruns=0,
            now_s=0.0,
            dt_s=0.005,
            sighted_capture_ns=0,
            sighted_age_s=0.0,
            drive_absence="/dev/ttyUSB0 is not there",
            commanded=False,
        )
        return SimpleNamespace(take=lambda: (state, None) if topic is topics.CONTROLLER_STATE else None)

    def gives(self, signal):
        return SimpleNamespace(give=lambda: None)


def test_a_bench_without_servos_is_told_of_and_not_waited_for_without_end(monkeypatch):
    monkeypatch.setattr("nodal.calibrate.hand.DRIVE_SOUGHT_S", 0.1)
    with pytest.raises(CalibrationError, match="servos are not heard: /dev/ttyUSB0 is not there"):
        BenchHand(BusWithoutServos()).watch()
