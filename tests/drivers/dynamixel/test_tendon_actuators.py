"""The whole drive in mm against emulated servos: what it checks, what it refuses, and that it always lets go."""

import msgspec
import numpy as np
import pytest

from drivers.actuators import Actuators, CommandRefusedError, WatchdogExpiredError
from drivers.dynamixel import control_table as table
from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.bus import DynamixelBus
from drivers.dynamixel.errors import (
    NoAnswerError,
    PortLostError,
    PortMissingError,
    RestartedError,
    StatusError,
    WrongModelError,
    WrongSetupError,
)
from drivers.dynamixel.port import SerialPort
from drivers.simulated.servos.settings import Faults

MM_PER_RAD = np.array([8.0, -8.0, 8.0, 8.0])
TICK_MM = 8.0 * 2 * np.pi / 4096


def hold(actuators, bench, goal_mm, insertion_mm, seconds=1.0):
    """Command a goal long enough to be reached, feeding the watchdog on the way."""
    for _ in range(round(seconds / 0.1)):
        command(actuators, goal_mm, insertion_mm)
        bench.run(0.1)
    return actuators.read()


def command(actuators, goal_mm, insertion_mm):
    """Command a goal and wait, by reading, until it has arrived: nobody acknowledges it."""
    actuators.write(np.asarray(goal_mm, float), insertion_mm)
    actuators.read()


def test_it_is_an_actuators(settings):
    drive: Actuators = TendonActuators(settings)
    assert drive


def test_after_opening_everything_is_relaxed_and_at_zero(bench, actuators):
    state = actuators.read()
    assert np.array_equal(state.displacement_mm, np.zeros(4))
    assert state.insertion_mm == 0
    assert not state.torque
    assert state.hardware_error == (0,) * 5
    assert np.allclose(state.voltage_v, 12.0)
    assert np.allclose(state.temperature_c, 28.0)
    assert bench.torque_enabled == (False,) * 5


def test_goals_in_mm_turn_the_servos_the_right_way(bench, actuators):
    actuators.enable()
    state = hold(actuators, bench, [2.0, 2.0, -1.0, 0.0], 3.0)
    assert state.torque
    assert np.allclose(state.displacement_mm, [2.0, 2.0, -1.0, 0.0], atol=0.1)
    assert state.insertion_mm == pytest.approx(3.0, abs=0.1)
    angles = bench.run(0.01)
    assert np.allclose(angles[:4] * MM_PER_RAD, state.displacement_mm, atol=TICK_MM)
    assert angles[1] < 0 < angles[0]


def test_a_load_shows_as_current_that_is_positive_where_it_pulls_in(bench, actuators):
    """The second servo's positive turns let its pair's first tendon out."""
    actuators.enable()
    for _ in range(5):
        actuators.read()
        bench.run(0.1, load_torque_Nm=0.5)
    assert (actuators.read().current_ma * [1, -1, 1, 1, 1] > 150).all()


def test_current_never_exceeds_its_bound(bench, actuators):
    actuators.enable()
    command(actuators, np.full(4, 6.0), 0.0)
    bench.run(0.1, load_torque_Nm=2.5)
    assert (np.abs(actuators.read().current_ma) <= 800).all()


def test_zero_is_where_it_is_said_to_be(bench, actuators):
    actuators.enable()
    hold(actuators, bench, [2.0, 2.0, -1.0, 0.0], 3.0)
    actuators.set_zero(np.array([0.5, 0.0, 0.0, -0.5]), 1.0)
    state = actuators.read()
    assert np.allclose(state.displacement_mm, [0.5, 0.0, 0.0, -0.5], atol=TICK_MM)
    assert state.insertion_mm == pytest.approx(1.0, abs=TICK_MM)
    angles = bench.run(0.01)
    state = hold(actuators, bench, [0.5, 0.0, 0.0, -0.5], 1.0)
    assert np.allclose(bench.run(0.01), angles, atol=0.01)


@pytest.mark.parametrize(
    ("displacement_mm", "insertion_mm", "complaint"),
    [
        ([np.nan, 0, 0, 0], 0, "axis a: goal nan mm"),
        ([0, 0, np.inf, 0], 0, "axis c: goal inf mm"),
        ([0, 6.1, 0, 0], 0, "axis b: goal 6.1 mm must be a number from -6.0 to 6.0"),
        ([0, 0, 0, 0], -7, "axis stage"),
        ([0, 0, 0], 0, "4 tendon pairs"),
    ],
)
def test_bad_commands_are_refused_and_nothing_is_sent(
    bench, actuators, displacement_mm, insertion_mm, complaint
):
    actuators.enable()
    with pytest.raises(CommandRefusedError, match=complaint):
        actuators.write(np.array(displacement_mm, float), insertion_mm)
    assert np.allclose(bench.run(0.1), 0, atol=0.01)


def test_enabling_does_not_move_even_when_an_old_goal_waits(bench, actuators, settings):
    actuators._bus.sync_write(table.GOAL_POSITION, dict.fromkeys((11, 12, 21, 22, 30), 9000))
    actuators.enable()
    assert bench.torque_enabled == (True,) * 5
    assert np.allclose(bench.run(0.15), 0, atol=0.01)


def test_a_goal_that_does_not_arrive_keeps_torque_off(bench, actuators):
    bench.set_faults(Faults(silent=frozenset({22})))
    with pytest.raises(NoAnswerError, match="22"):
        actuators.enable()
    assert bench.torque_enabled == (False,) * 5
    bench.set_faults(Faults())


def test_servos_that_do_not_confirm_their_torque_are_let_go(bench, actuators):
    asked_before = 4 * 5  # hardware error, feedback, watchdog and goal of five servos
    bench.set_faults(Faults(drop=frozenset(range(asked_before + 1, 1000))))
    with pytest.raises(NoAnswerError) as caught:
        actuators.enable()
    assert "while letting the servos go" in caught.value.__notes__[0]
    bench.set_faults(Faults())
    assert actuators.read().torque is False
    assert bench.torque_enabled == (False,) * 5


def test_silence_stops_the_servos_and_is_told(bench, actuators):
    actuators.enable()
    hold(actuators, bench, [1.0, 1.0, 1.0, 1.0], 1.0)
    command(actuators, np.full(4, 6.0), 6.0)
    bench.run(0.3)
    stopped = bench.run(0.1)
    assert np.allclose(bench.run(0.5), stopped, atol=1e-3)
    with pytest.raises(
        WatchdogExpiredError, match="axis a, b, c, d, stage heard nothing for more than 200 ms"
    ):
        actuators.read()
    with pytest.raises(WatchdogExpiredError):
        command(actuators, np.full(4, -6.0), 0.0)
    assert np.allclose(bench.run(0.1), stopped, atol=1e-2)
    actuators.disable()
    assert not actuators.read().torque
    actuators.enable()
    assert actuators.read().torque


def test_reading_feeds_the_watchdog(bench, actuators):
    actuators.enable()
    for _ in range(10):
        bench.run(0.1)
        actuators.read()


def test_a_servo_that_restarted_by_itself_is_not_believed(bench, actuators):
    actuators.enable()
    bench.restart(21)
    bench.now_s += 1
    with pytest.raises(RestartedError, match=r"servo \[21\] restarted"):
        actuators.read()


def test_a_drive_that_was_not_opened_says_so(settings):
    for use in (
        lambda drive: drive.read(),
        lambda drive: drive.write(np.zeros(4), 0.0),
        lambda drive: drive.set_zero(np.zeros(4), 0.0),
        lambda drive: drive.enable(),
        lambda drive: drive.disable(),
    ):
        with pytest.raises(PortLostError, match="not"):
            use(TendonActuators(settings))


def enable_and_raise(settings, trouble, before_raising=lambda: None):
    with TendonActuators(settings) as actuators:
        actuators.enable()
        before_raising()
        raise trouble


def test_torque_goes_off_when_all_is_well(bench, settings):
    with TendonActuators(settings) as actuators:
        actuators.enable()
    assert bench.torque_enabled == (False,) * 5


@pytest.mark.parametrize("trouble", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_torque_goes_off_whatever_happens(bench, settings, trouble):
    with pytest.raises(trouble):
        enable_and_raise(settings, trouble)
    assert bench.torque_enabled == (False,) * 5


def test_trouble_on_the_way_out_does_not_hide_the_reason_and_relaxes_who_can_be_reached(bench, settings):
    with pytest.raises(ZeroDivisionError) as caught:
        enable_and_raise(
            settings, ZeroDivisionError, lambda: bench.set_faults(Faults(silent=frozenset({12})))
        )
    assert "no answer from servo 12" in caught.value.__notes__[0]
    assert bench.torque_enabled == (False, True, False, False, False)


def test_a_restart_never_finds_the_servos_armed(bench, settings):
    with DynamixelBus(SerialPort(settings.port)) as bus:
        bus.sync_write(table.STATUS_RETURN_LEVEL, dict.fromkeys((11, 12, 21, 22, 30), 0))
        bus.sync_write(table.TORQUE_ENABLE, dict.fromkeys((11, 12, 21, 22, 30), 1))
        bus.ping(11)
    assert all(bench.torque_enabled)
    with TendonActuators(settings):
        assert not any(bench.torque_enabled)


@pytest.mark.parametrize(
    ("servos", "error", "complaint"),
    [
        ({"model_number": 1060}, WrongModelError, "servo 11 .a. has model number 1060"),
        ({"firmware": 42}, WrongModelError, "firmware 42; fast sync read needs 45"),
        ({"operating_mode": 3}, WrongSetupError, "Operating Mode is 3, needed is 5"),
        ({"return_delay_us": 500}, WrongSetupError, "Return Delay Time is 250, needed is 0"),
    ],
)
def test_the_wrong_servos_are_refused_and_the_port_let_go(make_bench, settings, servos, error, complaint):
    make_bench(**servos)
    actuators = TendonActuators(settings)
    with pytest.raises(error, match=complaint):
        actuators.open()
    with DynamixelBus(SerialPort(settings.port)) as bus:
        assert bus.ping(11)


def test_a_current_above_the_servos_own_limit_is_refused(bench, settings):
    strong = msgspec.structs.replace(
        settings, stage=msgspec.structs.replace(settings.stage, max_current_ma=4000.0)
    )
    with pytest.raises(WrongSetupError, match=r"servo 30 .stage.: max_current_ma 4000 is above .* 3209 mA"):
        TendonActuators(strong).open()


def test_travel_beyond_the_servos_turns_is_refused(bench, settings):
    stage = msgspec.structs.replace(settings.stage, mm_per_rad=0.002)
    with pytest.raises(WrongSetupError, match="256 turns"):
        TendonActuators(msgspec.structs.replace(settings, stage=stage)).open()


def test_a_servo_that_is_not_on_the_bus_is_named(bench, settings):
    stage = msgspec.structs.replace(settings.stage, id=99)
    with pytest.raises(NoAnswerError, match="servo 99"):
        TendonActuators(msgspec.structs.replace(settings, stage=stage)).open()


def test_an_unplugged_port_is_plugged_in_again_and_the_servos_are_relaxed(bench, settings):
    actuators = TendonActuators(settings)
    actuators.open()
    actuators.enable()
    bench.unplug()
    with pytest.raises(PortLostError, match="was lost"):
        actuators.read()
    with pytest.raises(PortMissingError, match="does not exist"):
        actuators.open()
    bench.run(0.5)
    bench.plug_in()
    actuators.open()
    assert bench.torque_enabled == (False,) * 5
    assert not actuators.read().torque
    actuators.close()


def test_servos_that_restarted_while_nobody_looked_are_told_once(bench, settings):
    actuators = TendonActuators(settings)
    actuators.open()
    actuators.close()
    bench.restart(21)
    bench.fail(12, 0x20)
    bench.now_s += 1
    with pytest.raises(RestartedError, match=r"servo \[21\] restarted by itself .*; servo 12: overload"):
        actuators.open()
    actuators.open()
    said = actuators.read()
    assert said.hardware_error == (0, 0x20, 0, 0, 0)
    assert said.alarm.endswith(": overload")
    actuators.close()


def test_a_refused_register_is_an_error_that_says_so(bench, actuators):
    with pytest.raises(StatusError, match="beyond a limit"):
        actuators._set(table.GOAL_CURRENT, 2000)


def test_a_stage_keeps_its_place_over_a_restart_when_its_zero_is_known(bench, settings):
    stage = msgspec.structs.replace(settings.stage, zero_ticks=2048)
    settings = msgspec.structs.replace(settings, stage=stage)
    with TendonActuators(settings) as actuators:
        assert actuators.read().insertion_mm == pytest.approx(0.0, abs=TICK_MM)
        actuators.enable()
        hold(actuators, bench, [1.0, 0.0, 0.0, 0.0], 3.0)
    with TendonActuators(settings) as actuators:
        state = actuators.read()
    assert state.insertion_mm == pytest.approx(3.0, abs=0.1)
    assert np.array_equal(state.displacement_mm, np.zeros(4))
