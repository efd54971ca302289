"""The actuators of docs/actuators.md, with a made-up device behind them: the document's own list of promises."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from controller import Action, ActionRequest, ControllerSettings, Inputs, Loop, RobotSettings, sighting_of
from controller.drive import Drive
from drivers.actuators import ActuatorError, Actuators, CommandRefusedError, WatchdogExpiredError

PERIOD_S = 0.005
ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "own_actuators.py"


class Device:
    """A motion controller whose motors are at once where they are told to be."""

    def __init__(self):
        self.place_mm, self.goal_mm = np.array([10.0, -3.0, 0.0, 2.5]), np.full(4, 99.0)
        self.holding, self.stopped, self.taken, self.moved = True, False, False, 0
        self.alarms, self.answers = [0, 0, 0, 0], []

    def connect(self):
        if self.taken:
            raise PermissionError("in use")
        self.taken = True
        return self.ask, self.let_go

    def expire(self):
        """Its watchdog stops the motors."""
        self.holding, self.stopped = False, True

    def let_go(self):
        self.taken = False

    def ask(self, line):
        if self.answers:
            answer = self.answers.pop(0)
            if isinstance(answer, Exception):
                raise answer
            return answer
        word, *rest = line.split()
        self.holding = word == "hold" or (self.holding and word != "free")
        self.stopped = self.stopped and word != "free"
        if word == "go":
            self.goal_mm = np.array([float(goal) for goal in rest])
        if self.holding:
            self.moved += bool(abs(self.place_mm - self.goal_mm).max() > 1e-3)
            self.place_mm = self.goal_mm
        motors = 2 if self.stopped else int(self.holding)
        numbers = {"position": self.place_mm.tolist(), "alarms": self.alarms, "motors": [motors]}
        return " ".join(["ok", *map(str, numbers.get(word, []))])


@pytest.fixture
def device():
    return Device()


@pytest.fixture
def actuators(device):
    spec = importlib.util.spec_from_file_location("own_actuators", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    drive: Actuators = module.StepperActuators(device.connect)
    return drive


def test_opening_relaxes_and_counts_from_where_it_is(device, actuators):
    device.alarms = [0, 0, 4, 0]
    with actuators:
        assert not device.holding
        state = actuators.read()
        assert state.position_mm.tolist() == [0.0] * 4
        assert state.hardware_error == (0, 0, 4, 0)
        assert not state.torque
    assert not device.taken


def test_enabling_moves_nothing_and_goals_count_from_zero(device, actuators):
    with actuators:
        actuators.enable()
        assert device.moved == 0
        actuators.write(np.array([1.0, 2.0, -1.0, 0.5]), 0.0)
        assert device.goal_mm.tolist() == [11.0, -1.0, -1.0, 3.0]
        actuators.set_zero(np.zeros(4), 0.0)
        assert np.allclose(actuators.read().displacement_mm, 0)


@pytest.mark.parametrize(
    ("goal_mm", "insertion_mm"), [([7, 0, 0, 0], 0), ([np.nan, 0, 0, 0], 0), ([0, 0, 0], 0), ([0] * 4, 1)]
)
def test_what_must_not_be_is_refused_before_it_is_sent(device, actuators, goal_mm, insertion_mm):
    with actuators:
        before = device.goal_mm
        with pytest.raises(CommandRefusedError):
            actuators.write(np.array(goal_mm, float), insertion_mm)
        assert device.goal_mm is before


@pytest.mark.parametrize("trouble", [TimeoutError("too late"), "", "ok nan", "ok 1 x", "ok 1", "error 7"])
def test_one_bad_answer_is_made_up_for_and_two_are_an_error(device, actuators, trouble):
    with actuators:
        device.answers = [trouble]
        actuators.set_zero(np.zeros(4), 0.0)
        device.answers = [trouble] * 2
        with pytest.raises(ActuatorError, match="no answer to 'position' after 2 attempts"):
            actuators.set_zero(np.zeros(4), 0.0)


def test_a_watchdog_that_has_expired_is_told_until_the_motors_are_let_go(device, actuators):
    with actuators:
        actuators.enable()
        assert actuators.read().torque
        device.expire()
        with pytest.raises(WatchdogExpiredError, match="heard nothing for 200 ms"):
            actuators.read()
        actuators.disable()
        assert not actuators.read().torque


def test_the_device_is_let_go_even_when_it_does_not_answer(device, actuators):
    actuators.open()
    device.answers = [TimeoutError("gone")] * 2
    with pytest.raises(ActuatorError, match="gone"):
        actuators.close()
    assert not device.taken


def test_the_controllers_edge_loses_it_and_finds_it_again(device, actuators):
    drive = Drive(actuators)
    assert drive.read(0.0) is not None
    device.answers = [TimeoutError("gone")] * 4
    assert drive.read(1.0) is None
    assert "gone" in drive.absence
    assert drive.read(3.0) is not None
    drive.close()
    assert not device.taken


def test_the_loop_runs_with_default_settings_on_what_measures_no_voltage(device, actuators):
    """Homing and standing ready for 2 s, until the device's watchdog expires."""
    settings, robot = ControllerSettings(), RobotSettings(section_length_mm=(40.0, 40.0), stage=False)
    loop, drive, model = Loop(settings, robot), Drive(actuators), settings.kinematics(robot)
    state, start_mm, arc_mm = loop.start(), device.place_mm, np.array([40.0, 80.0])

    def cycle(number, *requests):
        nonlocal state
        inputs = Inputs(
            now_s=number * PERIOD_S,
            dt_s=PERIOD_S,
            sighting=sighting_of(
                ("middle", "tip"),
                arc_mm,
                model.nodes_mm(device.place_mm - start_mm, arc_mm),
                age_s=0.002,
                standard_deviation_mm=0.03,
            ),
            drive=drive.read(number * PERIOD_S),
            absence=drive.absence,
            absence_fault=drive.absence_fault,
            requests=requests,
        )
        state, outputs = loop.step(state, inputs)
        drive.act(outputs, number * PERIOD_S)

    cycle(0)
    cycle(1, ActionRequest(action=Action.HOME))
    for number in range(2, 402):
        cycle(number)
        assert state.mode in ("homing", "ready"), state.supervision
    assert device.moved > 100
    device.expire()
    cycle(402)
    assert state.supervision.fault.code == "watchdog_expired"
    assert not device.holding
