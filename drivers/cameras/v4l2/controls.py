"""Lock a camera's controls: switch off what works by itself, set what the bench wants, and read both back.

Order matters: a camera refuses a value that it sets itself (V4L2 user-space API, "Camera Control Reference").
"""

import dataclasses
import math
import time
from collections.abc import Callable, Mapping
from types import MappingProxyType

import msgspec
from linuxpy.video.device import BaseMonoControl, ControlID, ControlType, Device, MenuControl

from drivers.cameras.errors import CameraControlError
from drivers.cameras.v4l2.settings import V4l2Controls

ATTEMPTS = 3
PAUSE_S = 0.05
"""Some cameras answer with an error, or with the value before, while they still work on the last order."""

NUMBERED = {ControlType.INTEGER, ControlType.BOOLEAN, ControlType.MENU, ControlType.INTEGER_MENU}

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
    "zoom": ControlSetting(control=ControlID.ZOOM_ABSOLUTE),
    "pan": ControlSetting(control=ControlID.PAN_ABSOLUTE),
    "tilt": ControlSetting(control=ControlID.TILT_ABSOLUTE),
}


def setting_of(control: int) -> str | None:
    """The key of [cameras.NAME.controls] that sets this control, if one does."""
    return next((key for key, setting in SETTINGS.items() if setting.control == control), None)


def locked_controls(
    device: Device, wanted: V4l2Controls, before: Mapping[int, int] = MappingProxyType({})
) -> dict[int, int]:
    """Lock everything; what then holds, by control and in the camera's own numbers.

    What the bench does not say becomes what it was `before`, when this camera was locked first: one that lost its power
    has its factory's values. Raises CameraControlError naming the control, what was asked, what holds and what is allowed.
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
    said = SWITCHED_OFF.keys() | {SETTINGS[key].control for key in asked}
    for number, held in before.items():
        if number in said:
            continue
        if number not in present:
            lost = setting_of(number) or f"control {number:#x}"
            raise CameraControlError(f"it has no {lost} any more: it is another camera than before")
        if present[number].value != held:
            _lock(present[number], ControlSetting(control=number), present[number].config_name, held)
    return {number: int(control.value) for number, control in present.items() if _stays(control)}


def in_settings(held: Mapping[int, int]) -> dict[str, float]:
    """By the keys of [cameras.NAME.controls] and in their units, as far as they have one."""
    return {
        key: setting.value(held[setting.control])
        for key, setting in SETTINGS.items()
        if setting.control in held
    }


def _stays(control: BaseMonoControl) -> bool:
    """Whether it holds what was set until it is set again."""
    unset = control.is_flagged_write_only or control.is_flagged_volatile
    return control.is_writeable and not unset and control.type in NUMBERED


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
