"""The real process: Dynamixel packets through a pty to emulated servos, shapes and orders through a Zenoh session."""

import json
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from controller.settings import ControllerSettings
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.settings import EmulatedServosSettings, MotorSettings
from messaging import topics
from messaging.control import Action, ActionRequest
from messaging.errors import UnansweredError
from messaging.session import open_rendezvous
from messaging.settings import ZenohSettings

SCRIPT = Path(__file__).with_name("controller_under_test.py")
ROOT = Path(__file__).parents[2]
SERVO_IDS = (11, 12, 13, 14, 30)
MM_PER_RAD = np.array([8.0, 8.0, 8.0, 8.0, 5.0])


def wait_for(condition, what, deadline_s=20.0):
    """The first true value of `condition()`, or a failed test."""
    deadline = time.monotonic() + deadline_s
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.005)
    pytest.fail(f"{what} did not happen within {deadline_s} s")
    return None


class RealBench:
    """Emulated servos, a paper robot that they move, and a camera that publishes shapes, in a thread."""

    def __init__(self, folder, stand_ins):
        self.port = str(folder / "servos")
        self._stand_ins = stand_ins
        settings = EmulatedServosSettings(
            link=self.port, ids=SERVO_IDS, motor=MotorSettings(inertia_kg_m2=0.002)
        )
        self.servos = EmulatedServos(settings)
        self.servos.open()
        self.plugged = True
        self._plug = threading.Lock()
        self.seeing = True
        self.robot = stand_ins["PaperRobot"](ControllerSettings().kinematics(stand_ins["ROBOT"]))
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.rendezvous = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._live)
        self.processes = []

    def __enter__(self):
        self._zenoh = open_rendezvous(ZenohSettings(rendezvous=self.rendezvous), "test")
        self.session = self._zenoh.__enter__()
        self.states = self.session.newest(topics.CONTROLLER_STATE)
        self.commands = self.session.every(topics.TENDON_COMMAND, 4096)
        self.targets = self.session.newest(topics.TARGET)
        self._shapes = self.session.publisher(topics.SHAPE)
        self._thread.start()
        return self

    def __exit__(self, *_):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()
        self._end.set()
        self._thread.join()
        self._zenoh.__exit__(None, None, None)
        self.unplug()

    def unplug(self):
        """Take the serial device away."""
        with self._plug:
            self.plugged = False
            self.servos.close()

    def plug(self):
        """Bring it back."""
        with self._plug:
            self.servos.open()
            self.plugged = True

    def start_controller(self):
        process = subprocess.Popen(
            [sys.executable, str(SCRIPT), self.rendezvous, self.port],
            cwd=ROOT,
            env={"PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.processes.append(process)
        return process

    def do(self, action):
        return self.session.ask(topics.CONTROLLER_DO, ActionRequest(action=Action(action)), 10.0)

    def state(self):
        """The newest ControllerState, waited for."""
        return wait_for(self.states.take, "a controller state")[0]

    def wait_for_state(self, state):
        return wait_for(lambda: (now := self.state()).state == state and now, f"state {state}")

    def home(self):
        wait_for(lambda: self.do("home").accepted, "homing")
        return self.wait_for_state("ready")

    def _live(self):
        last_s = next_shape_s = time.monotonic()
        sequence = 0
        while not self._end.wait(0.005):
            now_s = time.monotonic()
            with self._plug:
                if self.plugged:
                    angles = self.servos.step(now_s - last_s, np.zeros(len(SERVO_IDS)))
            last_s = now_s
            if self.seeing and now_s >= next_shape_s:
                next_shape_s += 1 / 30
                node_mm = self.robot.move(np.asarray(angles) * MM_PER_RAD, 0.0)
                self._shapes.put(self._stand_ins["shape_of"](node_mm, (40.0, 80.0), sequence=sequence))
                sequence += 1


@pytest.fixture
def bench(tmp_path, stand_ins):
    with RealBench(tmp_path, stand_ins) as bench:
        yield bench


def test_homes_arms_tracks_and_leaves_tendons_safe(bench, stand_ins):
    process = bench.start_controller()
    assert bench.home().reason == "homed"
    target = stand_ins["circle"](radius_mm=8.0)
    assert bench.session.ask(topics.CONTROLLER_TARGET, target, 10.0).accepted
    assert wait_for(bench.targets.take, "the accepted target")[0] == target
    assert bench.do("arm").accepted
    wait_for(
        lambda: (now := bench.state()).target_name == "circle" and 0 < now.tracking_error_mm < 0.3,
        "tracking within 0.3 mm",
    )
    assert all(bench.servos.torque_enabled)
    while bench.commands.take() is not None:
        pass
    payloads = [wait_for(bench.commands.take, "a command").payload for _ in range(100)]
    commands = [topics.TENDON_COMMAND.type.from_bytes(payload) for payload in payloads]
    first_ones = [command for command in commands if command.capture_to_command_ns >= 0]
    # the first command after each shape tells the age of its frames, which were 20 ms old when published
    assert len({command.shape_sequence for command in first_ones}) == len(first_ones) >= 5
    assert min(command.capture_to_command_ns for command in first_ones) >= 20_000_000
    assert_a_stall_makes_no_jump(bench, process)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=10)
    assert process.returncode == 0, err
    assert json.loads(out)["healthy"] > 100
    assert not any(bench.servos.torque_enabled)


def assert_a_stall_makes_no_jump(bench, process):
    """The process stands still for ten of its cycles, while the target moves on."""
    settings, cycles = ControllerSettings(), bench.session.every(topics.CONTROLLER_STATE, 4096)
    before = decoded(wait_for(cycles.take, "a cycle"))
    while bench.commands.take() is not None:
        pass
    process.send_signal(signal.SIGSTOP)
    time.sleep(0.05)
    process.send_signal(signal.SIGCONT)
    counted = wait_for(
        lambda: (now := bench.state()).overruns >= before.overruns + 5 and now,
        "missed cycles that are counted",
    )
    commands = [decoded(wait_for(bench.commands.take, "a command")).displacement_mm for _ in range(20)]
    longest_s = max(decoded(cycle).dt_s for cycle in iter(cycles.take, None))
    assert counted.state == "tracking"
    assert longest_s == pytest.approx(4 / settings.rate_hz), "never more than four periods are made up for"
    assert np.abs(np.diff(commands, axis=0)).max() <= settings.limits.displacement_mm_s * longest_s


def decoded(received):
    """The message that was received."""
    return next(topic for topic in topics.TOPICS if topic.key == received.key).type.from_bytes(
        received.payload
    )


def test_stop_holds_and_faults_reach_the_servos(bench):
    bench.start_controller()
    bench.home()
    assert bench.do("arm").accepted
    asked = bench.session.every(topics.ASKED, 16)
    bench.session.gives(topics.STOP).give()
    wait_for(lambda: not any(bench.servos.torque_enabled), "torque off")
    heard = topics.ASKED.type.from_bytes(wait_for(asked.take, "the log of the stop signal").payload)
    assert (heard.service, heard.accepted, heard.state) == ("stop", True, "idle")
    refused = bench.do("arm")
    assert (refused.accepted, refused.state) == (False, "idle")
    bench.session.gives(topics.HEARTBEAT).give()
    wait_for(lambda: bench.state().heartbeat, "the heartbeat in a controller state")
    bench.home()
    assert bench.do("stop").accepted
    wait_for(lambda: not any(bench.servos.torque_enabled), "torque off")
    bench.home()
    bench.do("arm")
    bench.seeing = False
    bench.wait_for_state("hold")
    fault = bench.wait_for_state("fault")
    assert "no trusted shape" in fault.reason
    assert (fault.fault, fault.fault_limit, fault.fault_unit) == ("sensing_lost", 1.0, "s")
    assert bench.do("status").advice == fault.advice != ""
    wait_for(lambda: not any(bench.servos.torque_enabled), "torque off")
    assert bench.do("relax").state == "idle"


def test_unplugged_port_is_a_fault_that_names_it_and_the_process_lives_on(bench):
    process = bench.start_controller()
    bench.home()
    bench.unplug()
    fault = bench.wait_for_state("fault")
    assert bench.port in fault.reason
    assert fault.fault == "drive_lost"
    refused = bench.do("home")
    assert not refused.accepted
    assert bench.port in refused.reason
    assert bench.do("relax").state == "idle"
    bench.plug()
    bench.home()
    assert process.poll() is None


def test_a_restart_never_re_arms(bench):
    process = bench.start_controller()
    bench.home()
    assert bench.do("arm").accepted
    process.kill()
    process.wait()
    # nobody speaks to the servos any more: their own watchdog stops them
    bench.start_controller()
    wait_for(lambda: _asked(bench, "status").state == "idle", "a restarted controller in idle")
    wait_for(lambda: not any(bench.servos.torque_enabled), "torque off")
    assert not bench.do("arm").accepted


def _asked(bench, action):
    try:
        return bench.do(action)
    except UnansweredError as error:
        pytest.fail(str(error))
