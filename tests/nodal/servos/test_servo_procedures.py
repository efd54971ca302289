"""Scanning, setting up and checking servos, in virtual time: what is found, what is written, what is refused."""

import pytest

from drivers.dynamixel import control_table as table
from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.bus import DynamixelBus
from drivers.dynamixel.errors import UnconfirmedError, WrongModelError
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults
from drivers.simulated.servos.virtual_line import VirtualLine
from nodal.errors import BusError, CommandError, SetupRefusedError
from nodal.servos import words
from nodal.servos.findings import examine
from nodal.servos.identify import blink
from nodal.servos.scan import scan
from nodal.servos.setting_up import Order, set_up

OVERLOAD = 0x20


def axis(name, servo, **other):
    return AxisSettings(
        **{
            "name": name,
            "id": servo,
            "mm_per_rad": 5.0,
            "min_mm": -6.0,
            "max_mm": 6.0,
            "max_current_ma": 500.0,
        }
        | other
    )


SETTINGS = ServoSettings(
    port="virtual",
    tendons=(axis("bend x", 11), axis("bend y", 12)),
    stage=axis("stage", 13, mm_per_rad=2.0, min_mm=-5.0, max_mm=45.0, zero_ticks=2048),
)
ONE = ServoSettings(port="virtual", tendons=(axis("only", 5),))


class Bench:
    """Servos on a virtual line, and the bus to them."""

    def __init__(self, *ids, **settings):
        self.line = VirtualLine(EmulatedServosSettings(link="virtual", ids=ids, **settings))

    def __call__(self, baud_rate):
        return DynamixelBus(self.line.speaking_at(baud_rate))

    def memory(self, servo):
        return self.line.servos.servo(servo).memory

    def writes(self):
        """Everything that a conversation may have changed."""
        return [servo.memory.read(0, 200) for servo in self.line.servos.servos]

    def found(self, rates=table.BAUD_RATES, ids=range(20)):
        return list(scan(self, rates, ids))

    def findings(self, settings=SETTINGS):
        return list(examine(self, settings))

    def set_up(self, settings=SETTINGS, **order):
        return list(set_up(self, Order(settings=settings, **order)))


@pytest.fixture
def bench():
    return Bench(11, 12, 13)


@pytest.fixture
def ready(bench):
    bench.set_up()
    return bench


class TestScan:
    """Who answers, and whether alone."""

    def test_everybody_is_found_at_whatever_speed(self, bench):
        bench.memory(12)["baud_rate"] = 1
        assert [(servo.id, servo.baud_rate) for servo in bench.found()] == [
            (12, 57_600),
            (11, 1_000_000),
            (13, 1_000_000),
        ]

    def test_a_row_says_what_matters(self, bench):
        bench.line.servos.servo(11).fail(OVERLOAD)
        assert [words.line(words.HEADER), *map(words.row, bench.found([1_000_000], [11]))] == [
            "id  model       firmware baud     mode                    torque position V     C    hardware error",
            "11  XM430-W350  48       1000000  current-based position  off    2048     12.0  28   overload",
        ]

    def test_a_model_without_a_name_is_listed_by_its_number(self):
        (servo,) = Bench(1, model_number=1060).found()
        assert servo.model_name == "model 1060"

    @pytest.mark.parametrize("delay", [0, 3, 250])
    def test_two_with_one_id_are_told(self, bench, delay):
        bench.memory(12)["return_delay_time"] = delay
        bench.line.run(0.02)
        bench.memory(12)["id"] = 11
        shared, stage = bench.found([1_000_000])
        assert (shared.id, shared.alone, stage.alone) == (11, False, True)
        assert "two servos with this id" in words.row(shared)

    def test_a_late_adapter_loses_nobody(self, bench):
        bench.line.servos.set_faults(Faults(delay=frozenset(range(1, 4)), delay_s=0.004))
        assert [servo.id for servo in bench.found([1_000_000])] == [11, 12, 13]

    def test_noise_is_no_servo(self, bench):
        bench.line.servos.set_faults(
            Faults(truncate=frozenset({1}), noise=frozenset({1}), silent=frozenset({12, 13}))
        )
        assert [servo.id for servo in bench.found([1_000_000])] == [11]

    def test_nothing_is_changed(self, bench):
        before = bench.writes()
        bench.found()
        assert bench.writes() == before


def test_one_lost_answer_hides_nobody(bench):
    bench.set_up()
    for settled in (bench.set_up, bench.findings):
        bench.line.servos.set_faults(Faults(unheard=frozenset({2, 12, 13})))
        assert settled() == []


class TestSetUp:
    """What differs is written and confirmed; what must not be is refused before anything is."""

    def test_what_differs_is_said_and_written_once(self, bench):
        assert "servo 11 (bend x): Current Limit 1193 (3209 mA) -> 186 (500 mA)" in bench.set_up()
        assert bench.memory(11)["current_limit"] == 186
        assert bench.memory(13)["temperature_limit"] == 75
        assert bench.set_up() == []

    def test_a_dry_run_says_the_same_and_writes_nothing(self, bench):
        before = bench.writes()
        said = bench.set_up(dry_run=True)
        assert bench.writes() == before
        assert said == bench.set_up()

    @pytest.mark.parametrize(
        ("register", "found", "needed"),
        [
            ("operating_mode", 3, 5),
            ("return_delay_time", 250, 0),
            ("drive_mode", 1, 0),
            ("secondary_id", 12, 255),
            ("startup_configuration", 1, 0),
            ("velocity_limit", 1023, 167),
            ("temperature_limit", 80, 75),
            ("min_position_limit", 100, 0),
            ("max_position_limit", 3000, 4095),
            ("shutdown", 0x01, 0x35),
            ("bus_watchdog", -1, 0),
            ("led", 1, 0),
        ],
    )
    def test_every_register_is_put_right(self, ready, register, found, needed):
        ready.memory(12)[register] = found
        (change,) = ready.set_up()
        assert change.startswith("servo 12 (bend y): ")
        assert ready.memory(12)[register] == needed

    def test_servos_at_another_speed_are_brought_to_the_benchs(self, ready):
        ready.memory(12)["baud_rate"] = 1
        assert ready.set_up() == ["servo 12 (bend y): Baud Rate 57600 -> 1000000"]
        assert ready.memory(12)["baud_rate"] == 3

    def test_a_new_servo_becomes_an_axis(self):
        bench = Bench(1, baud_rate=57_600, operating_mode=3, return_delay_us=500)
        said = bench.set_up(ONE, axis="only", from_id=1)
        assert said[-2:] == ["servo 1 (only): ID 1 -> 5", "servo 5 (only): Baud Rate 57600 -> 1000000"]
        assert [(servo.id, servo.baud_rate) for servo in bench.found()] == [(5, 1_000_000)]
        assert bench.findings(ONE) == []

    def test_an_id_that_is_taken_is_refused_even_at_another_speed(self):
        bench = Bench(1, 5)
        bench.memory(5)["baud_rate"] = 1
        before = bench.writes()
        with pytest.raises(
            SetupRefusedError, match=r"servo 1 .only. cannot become 5: XM430-W350 at 57600 baud has"
        ):
            bench.set_up(ONE, axis="only", from_id=1)
        assert bench.writes() == before

    def test_torque_is_refused_unless_it_may_go(self, bench):
        bench.memory(13)["torque_enable"] = 1
        before = bench.writes()
        with pytest.raises(SetupRefusedError, match=r"servo 13 .stage.: torque is on, .* --relax"):
            bench.set_up()
        assert bench.writes() == before
        assert "servo 13 (stage): Torque Enable 1 -> 0" in bench.set_up(relax=True)

    def test_two_servos_with_one_id_are_refused(self, bench):
        bench.line.run(0.02)
        bench.memory(12)["id"] = 11
        with pytest.raises(SetupRefusedError, match="two servos with this id"):
            bench.set_up(axis="bend x")

    def test_two_servos_with_one_id_at_two_speeds_are_refused(self, bench):
        bench.memory(12)["baud_rate"] = 1
        bench.memory(12)["id"] = 11
        with pytest.raises(SetupRefusedError, match="answers at 1000000 and 57600 baud each"):
            bench.set_up(axis="bend x")

    def test_a_servo_that_is_not_there_is_named_before_anything_is_written(self, bench):
        bench.line.servos.set_faults(Faults(silent=frozenset({13})))
        before = bench.writes()
        with pytest.raises(BusError, match=r"servo 13 .stage. does not answer at any baud rate"):
            bench.set_up()
        assert bench.writes() == before

    def test_an_axis_that_is_not_there_is_named(self, bench):
        with pytest.raises(CommandError, match="--axis bend z: the bench has bend x, bend y, stage"):
            bench.set_up(axis="bend z")

    def test_only_one_axis_may_be_meant(self, bench):
        assert {change.partition(":")[0] for change in bench.set_up(axis="stage")} == {"servo 13 (stage)"}

    def test_a_write_that_does_not_stay_is_an_error(self, bench, monkeypatch):
        memory = bench.memory(11)
        monkeypatch.setattr(bench.line.servos.servo(11), "write", lambda *_: None)
        with pytest.raises(
            UnconfirmedError, match="servo 11: Current Limit reads 1193 after 186 was written"
        ):
            bench.set_up()
        assert memory["current_limit"] == 1193

    def test_a_model_that_the_bench_cannot_use_is_refused(self):
        bench = Bench(5, model_number=1060)
        with pytest.raises(WrongModelError, match="model number 1060"):
            bench.set_up(ONE)

    def test_nothing_is_written_when_the_last_one_cannot_be_used(self, bench):
        bench.memory(13)["model_number"] = 1060
        before = bench.writes()
        with pytest.raises(WrongModelError, match=r"virtual: servo 13 \(stage\) has model number 1060"):
            bench.set_up()
        assert bench.writes() == before


class TestCheck:
    """Each difference is one finding with what to do."""

    def test_nothing_is_found_after_setting_up(self, ready):
        assert ready.findings() == []

    def test_nothing_is_changed(self, bench):
        before = bench.writes()
        assert bench.findings()
        assert bench.writes() == before

    @pytest.mark.parametrize(
        ("change", "finding"),
        [
            ({"operating_mode": 3}, "Operating Mode is 3 (position), needed is 5 (current-based position); run `nodal"),
            ({"return_delay_time": 250}, "Return Delay Time is 250 (500 us), needed is 0 (0 us); run `nodal"),
            ({"velocity_limit": 350}, "Velocity Limit is 350 (8.39 rad/s), needed is 167 (4.00 rad/s); run"),
            ({"shutdown": 0}, "Shutdown is 0 (never), needed is 52 (overheating, electrical shock, overload); run"),
            ({"hardware_error_status": OVERLOAD}, "hardware error overload; find the cause, then `nodal servos reboot 12`"),
            ({"torque_enable": 1}, "torque is on though nobody controls it; `nodal servos setup --relax`"),
            ({"bus_watchdog": -1}, "its watchdog has stopped it"),
            ({"present_input_voltage": 52}, "its supply is 5.2 V, allowed are 9.5 to 16.0 V; look at"),
            ({"present_temperature": 66}, "it is 66 C warm and lets go at 75 C; let it cool"),
            ({"firmware_version": 44}, "has firmware 44; fast sync read needs 45 or newer; exchange it, or update"),
            ({"model_number": 1060}, "has model number 1060; known models"),
            ({"baud_rate": 1}, "speaks at 57600 baud, the bench at 1000000; run `nodal servos setup`"),
            ({"id": 99}, "does not answer at any baud rate; is it plugged in and powered?"),
        ],
    )  # fmt: skip
    def test_each_difference_is_said(self, ready, change, finding):
        for name, value in change.items():
            ready.memory(12)[name] = value
        found = ready.findings()
        assert found[0].startswith("servo 12 (bend y): ")
        assert finding in found[0]

    def test_a_stage_that_lost_its_turns_is_found(self, ready):
        ready.memory(13)["present_position"] = 2048 - 8000
        (finding,) = ready.findings()
        assert finding.startswith(
            "servo 13 (stage): it stands at -24.5 mm, travel is -5 to 45 mm: it lost its turns"
        )

    def test_two_with_one_id_are_said(self, ready):
        ready.line.run(0.02)
        ready.memory(12)["id"] = 11
        assert ready.findings()[0] == f"servo 11 (bend x): {words.SHARED}"

    def test_a_servo_too_many_is_said(self):
        bench = Bench(5, 77)
        bench.set_up(ONE)
        (finding,) = bench.findings(ONE)
        assert finding.startswith("servo 77, XM430-W350, is no axis of the bench; take it off the bus, or")


def interrupt(_seconds):
    raise KeyboardInterrupt


def test_a_blinking_servo_is_dark_afterwards(bench):
    lit = []
    with bench(1_000_000) as bus:
        blink(bus, 12, 1.0, lambda _: lit.append(bench.memory(12)["led"]))
        assert lit == [1, 0, 1, 0]
        with pytest.raises(KeyboardInterrupt):
            blink(bus, 12, 1.0, interrupt)
    assert bench.memory(12)["led"] == 0


def test_limits_of_the_servo_do_not_hinder_the_drive(ready):
    with TendonActuators(SETTINGS, ready.line.speaking_at(1_000_000)) as drive:
        drive.enable()
        assert drive.read().torque
