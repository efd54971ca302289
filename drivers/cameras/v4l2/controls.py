"""Lock a camera's controls: switch off what works by itself, set what the bench wants, and read both back.

Order matters: a camera refuses a value that it sets itself (V4L2 user-space API, "Camera Control Reference").
"""

import dataclasses
import math
import time
from collections.abc import Callable

import msgspec
from linuxpy.video.device import BaseMonoControl, ControlID, Device, MenuControl

from drivers.cameras.errors import CameraControlError
from drivers.cameras.v4l2.settings import V4l2Controls

ATTEMPTS = 3
PAUSE_S = 0.05
"""Some cameras answer with an error, or with the value before, while they still work on the last order."""

EXPOSURES_PER_S = 10_000
MANUAL_EXPOSURE = 1
SWITCHED_OFF = {
    ControlID.EXPOSURE_AUTO: MANUAL_EXPOSURE,
    ControlID.EXPOSURE_AUTO_PRIORITY: 0,
    ControlID.AUTOGAIN: 0,
    ControlID.ISO_SENSITIVITY_AUTO: 0,
    ControlID.AUTO_WHITE_BALANCE: 0,
    ControlID.FOCUS_AUTO: 0,
    ControlID.BACKLIGHT_COMPENSATION: 0,
    ControlID.AUTOBRIGHTNESS: 0,
    ControlID.HUE_AUTO: 0,
    ControlID.WIDE_DYNAMIC_RANGE: 0,
    ControlID.IMAGE_STABILIZATION: 0,
}
"""What would change the picture by itself, and the value that keeps it from doing so."""

POWER_LINE_HZ = (0, 50, 60)
"""By the menu of V4L2_CID_POWER_LINE_FREQUENCY; a fourth entry, where there is one, leaves it to the camera."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class ControlSetting:
    """How a key of [cameras.NAME.controls] and a control's number go over into one another."""

    control: ControlID
    number: Callable[[float], int] = round
    value: Callable[[int], float] = int


SETTINGS = {
    "exposure_s": ControlSetting(
        control=ControlID.EXPOSURE_ABSOLUTE,
        number=lambda exposure_s: round(exposure_s * EXPOSURES_PER_S),
        value=lambda number: number / EXPOSURES_PER_S,
    ),
    "gain": ControlSetting(control=ControlID.GAIN),
    "focus": ControlSetting(control=ControlID.FOCUS_ABSOLUTE),
    "white_balance_k": ControlSetting(control=ControlID.WHITE_BALANCE_TEMPERATURE),
    "power_line_hz": ControlSetting(
        control=ControlID.POWER_LINE_FREQUENCY,
        number=lambda hz: POWER_LINE_HZ.index(int(hz)),
        value=lambda number: dict(enumerate(POWER_LINE_HZ)).get(number, math.nan),
    ),
    "sharpness": ControlSetting(control=ControlID.SHARPNESS),
    "brightness": ControlSetting(control=ControlID.BRIGHTNESS),
    "contrast": ControlSetting(control=ControlID.CONTRAST),
    "saturation": ControlSetting(control=ControlID.SATURATION),
}


def setting_of(control: int) -> str | None:
    """The key of [cameras.NAME.controls] that sets this control, if one does."""
    return next((key for key, setting in SETTINGS.items() if setting.control == control), None)


def locked_controls(device: Device, wanted: V4l2Controls) -> dict[str, float]:
    """Lock everything; what then holds, by the keys of [cameras.NAME.controls] and in their units.

    Raises CameraControlError naming the control, what was asked, what holds and what is allowed.
    """
    present = {
        control.id: control for control in device.controls.values() if isinstance(control, BaseMonoControl)
    }
    asked = {key: value for key, value in msgspec.structs.asdict(wanted).items() if value is not None}
    for key in asked:
        if SETTINGS[key].control not in present:
            has = ", ".join(key for key, setting in SETTINGS.items() if setting.control in present)
            raise CameraControlError(f"it has no {key}; it has {has or 'no control at all'}")
    for number, off in SWITCHED_OFF.items():
        if (control := present.get(number)) is not None:
            _lock(control, ControlSetting(control=number), control.config_name, max(off, control.minimum))
    for key, value in asked.items():
        _lock(present[SETTINGS[key].control], SETTINGS[key], key, value)
    return {
        key: setting.value(int(present[setting.control].value))
        for key, setting in SETTINGS.items()
        if setting.control in present
    }


def _lock(control: BaseMonoControl, setting: ControlSetting, key: str, value: float) -> None:
    """Set and read back. What the camera answers to the order does not count, only what it holds then."""
    number = setting.number(value)
    allowed = _allowed(control, setting)
    if not control.minimum <= number <= control.maximum:
        raise CameraControlError(f"{key} = {value:g} cannot be; it takes {allowed}")
    held, refusal = 0, None
    for attempt in range(ATTEMPTS):
        time.sleep(PAUSE_S if attempt else 0)
        try:
            control.value = number
        except (OSError, AttributeError) as error:
            refusal = str(error)
        held = int(control.value)
        if held == number:
            return
    answered = f" and answers: {refusal}" if refusal else ""
    raise CameraControlError(
        f"{key}: asked for {value:g}, the camera holds {setting.value(held):g}{answered}; it takes {allowed}"
    )


def _allowed(control: BaseMonoControl, setting: ControlSetting) -> str:
    if isinstance(control, MenuControl):
        return ", ".join(f"{setting.value(number):g} ({name})" for number, name in control.items())
    least, most = setting.value(control.minimum), setting.value(control.maximum)
    step = f" in steps of {setting.value(control.step):g}" if control.step > 1 else ""
    return f"{least:g} to {most:g}{step}"
