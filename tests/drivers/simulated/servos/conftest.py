"""An emulated bus without a device, and one behind a pty."""

import pytest

from drivers.simulated.servos.bus import ServoBus
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.settings import EmulatedServosSettings

IDS = (1, 2, 3)


@pytest.fixture
def settings(tmp_path):
    return EmulatedServosSettings(link=str(tmp_path / "servos"), ids=IDS)


@pytest.fixture
def bus(settings):
    return ServoBus(settings)


@pytest.fixture
def servos(settings):
    with EmulatedServos(settings) as servos:
        yield servos
