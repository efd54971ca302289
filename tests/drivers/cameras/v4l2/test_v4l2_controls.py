"""Controls are locked, in an order that cameras accept, and read back."""

import errno

import pytest
from hypothesis import given
from hypothesis import strategies as st
from linuxpy.video.raw import ControlID

from drivers.cameras import CameraControlError, V4l2Controls
from drivers.cameras.v4l2.controls import SETTINGS
from drivers.simulated.v4l2 import StandInCamera, plugged_in
from drivers.simulated.v4l2.description import CONTROLS, CameraDescription

WANTED = V4l2Controls(
    exposure_s=0.005,
    gain=12,
    focus=40,
    white_balance_k=4500,
    power_line_hz=50,
    sharpness=100,
    brightness=120,
    contrast=110,
    saturation=90,
    zoom=120,
    pan=-3600,
    tilt=3600,
)


def test_everything_is_set_and_all_that_works_by_itself_is_off(webcam, opened):
    opened(webcam, controls=WANTED)
    held = webcam.controls.values
    assert {key: held[setting.control] for key, setting in SETTINGS.items()} == {
        "exposure_s": 50,
        "gain": 12,
        "focus": 40,
        "white_balance_k": 4500,
        "power_line_hz": 1,
        "sharpness": 100,
        "brightness": 120,
        "contrast": 110,
        "saturation": 90,
        "zoom": 120,
        "pan": -3600,
        "tilt": 3600,
    }
    assert held[ControlID.EXPOSURE_AUTO] == 1
    for switch in (
        ControlID.EXPOSURE_AUTO_PRIORITY,
        ControlID.AUTO_WHITE_BALANCE,
        ControlID.FOCUS_AUTO,
        ControlID.BACKLIGHT_COMPENSATION,
    ):
        assert held[switch] == 0


def test_what_the_bench_does_not_say_keeps_the_cameras_value_and_is_locked_all_the_same(webcam, opened):
    webcam.controls.values[ControlID.GAIN] = 77
    opened(webcam)
    assert webcam.controls.values[ControlID.GAIN] == 77
    assert webcam.controls.values[ControlID.FOCUS_AUTO] == 0


@pytest.mark.parametrize(
    ("controls", "message"),
    [
        ({"focus": 300}, "focus = 300 cannot be; it takes 0 to 250 in steps of 5"),
        ({"focus": 42}, "focus: asked for 42, the camera holds 40; it takes 0 to 250 in steps of 5"),
        ({"exposure_s": 1.0}, "exposure_s = 1 cannot be; it takes 0.0003 to 0.2047"),
    ],
)
def test_a_value_that_the_camera_does_not_have_is_named_with_its_range(webcam, opened, controls, message):
    with pytest.raises(CameraControlError) as raised:
        opened(webcam, controls=V4l2Controls(**controls))
    assert str(raised.value) == f"camera left: {message}"


def test_a_refused_control_is_named_with_the_cameras_answer(webcam, opened):
    webcam.controls.refused[ControlID.SHARPNESS] = errno.EIO
    with pytest.raises(
        CameraControlError,
        match=r"left: sharpness: asked for 90, the camera holds 128 and answers: .*Input/output error; it takes 0 to 255",
    ):
        opened(webcam, controls=V4l2Controls(sharpness=90))


def test_a_control_that_reads_back_something_else_is_named(webcam, opened):
    webcam.controls.stubborn[ControlID.POWER_LINE_FREQUENCY] = 2
    with pytest.raises(
        CameraControlError, match="power_line_hz: asked for 50, the camera holds 60; it takes 0"
    ):
        opened(webcam, controls=V4l2Controls(power_line_hz=50))


def test_a_camera_that_keeps_its_automatic_exposure_is_named(webcam, opened):
    webcam.controls.stubborn[ControlID.EXPOSURE_AUTO] = 3
    with pytest.raises(
        CameraControlError, match=r"auto_exposure: asked for 1, the camera holds 3; .*1 \(Manual Mode\)"
    ):
        opened(webcam)


def test_a_control_that_the_camera_lacks_is_named_beside_those_it_has(pictures, settings, opened):
    without = tuple(control for control in CONTROLS if control.id != ControlID.FOCUS_ABSOLUTE)
    fixed_focus = StandInCamera(pictures, CameraDescription(controls=without), running=False)
    with plugged_in(fixed_focus):
        opened(fixed_focus).close()
        with pytest.raises(
            CameraControlError, match="it has no focus; it has exposure_s, gain, white_balance_k"
        ):
            opened(fixed_focus, controls=V4l2Controls(focus=10))


@given(st.integers(1, 100_000))
def test_exposures_go_over_into_the_cameras_units_and_back(number):
    setting = SETTINGS["exposure_s"]
    assert setting.number(setting.value(number)) == number
