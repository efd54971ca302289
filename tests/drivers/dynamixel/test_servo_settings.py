"""Bounds of the servo settings: every bad value is refused, and the message says what is wrong."""

import msgspec
import pytest

from drivers.dynamixel.settings import ServoSettings

AXIS = {"name": "a", "id": 1, "mm_per_rad": 8.0, "min_mm": -5.0, "max_mm": 5.0, "max_current_ma": 500.0}
STAGE = AXIS | {"name": "stage", "id": 2}
GOOD = {"port": "/dev/ttyUSB0", "tendons": [AXIS], "stage": STAGE}


def test_a_plain_bench_is_accepted():
    settings = msgspec.convert(GOOD, ServoSettings)
    assert [axis.id for axis in settings.axes] == [1, 2]


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"port": ""}, "port"),
        ({"tendons": []}, "tendons"),
        ({"watchdog_ms": 10}, "watchdog_ms"),
        ({"watchdog_ms": 3000}, "watchdog_ms"),
        ({"baud_rate": 1}, "baud_rate"),
        ({"profile_velocity_rad_s": 0}, "profile_velocity_rad_s"),
        ({"colour": "red"}, "colour"),
        ({"tendons": [AXIS | {"id": 253}]}, "id"),
        ({"tendons": [AXIS | {"mm_per_rad": 0.0}]}, "axis a: mm_per_rad"),
        ({"tendons": [AXIS | {"max_mm": -6.0}]}, "axis a: min_mm -5.0 must be below max_mm -6.0"),
        ({"tendons": [AXIS | {"id": 2}]}, "every id must be used once"),
        ({"tendons": [AXIS | {"name": "stage"}]}, "every name must be used once"),
    ],
)
def test_bad_settings_are_refused(change, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        msgspec.convert(GOOD | change, ServoSettings)
