"""Emulated servos on a pty, and the project's own driver in front of them."""

import msgspec
import numpy as np
import pytest

from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.bus import DynamixelBus
from drivers.dynamixel.port import SerialPort
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.settings import EmulatedServosSettings
from drivers.simulated.servos.virtual_line import VirtualLine

IDS = (11, 12, 21, 22, 30)


class Bench(EmulatedServos):
    """Emulated servos that move only when told to, with a clock of their own."""

    def __init__(self, link, **settings):
        self.now_s = 100.0
        super().__init__(
            EmulatedServosSettings(link=str(link), ids=IDS, **settings), clock=lambda: self.now_s
        )

    def run(self, seconds, load_torque_Nm=0.0):
        """Let time pass and return the horns' angles."""
        for _ in range(round(seconds / 0.01)):
            self.now_s += 0.01
            angles = self.step(0.01, np.full(len(IDS), load_torque_Nm))
        return angles


@pytest.fixture
def make_bench(tmp_path):
    benches = []

    def make(**settings):
        benches.append(Bench(tmp_path / "servos", **settings))
        benches[-1].open()
        return benches[-1]

    yield make
    for bench in benches:
        bench.close()


@pytest.fixture
def bench(make_bench):
    return make_bench()


@pytest.fixture
def settings(tmp_path):
    def axis(name, servo, mm_per_rad=8.0):
        return AxisSettings(
            name=name, id=servo, mm_per_rad=mm_per_rad, min_mm=-6.0, max_mm=6.0, max_current_ma=800.0
        )

    return ServoSettings(
        port=str(tmp_path / "servos"),
        tendons=(axis("a", 11), axis("b", 12, -8.0), axis("c", 21), axis("d", 22)),
        stage=axis("stage", 30, 1.5),
        watchdog_ms=200,
        answer_timeout_ms=50,
    )


@pytest.fixture
def bus(bench, settings):
    with DynamixelBus(SerialPort(settings.port), answer_timeout_s=0.05) as bus:
        yield bus


@pytest.fixture
def actuators(bench, settings):
    with TendonActuators(settings) as actuators:
        yield actuators


@pytest.fixture
def line():
    return VirtualLine(EmulatedServosSettings(link="virtual", ids=IDS))


@pytest.fixture
def drive(line, settings):
    """The whole drive over the virtual line, opened, as it is on a bench: 20 ms for an answer, two retries."""
    drive = TendonActuators(msgspec.structs.replace(settings, answer_timeout_ms=20), line)
    drive.open()
    return drive
