"""What comes into a cycle, looked at once: whatever is not finite or not of the right size must not get any further. Pure."""

import dataclasses
import math

import numpy as np

from controller.cycle import Inputs
from controller.errors import ClockError
from controller.faults import DriveLostError
from drivers.actuators import ActuatorState

_OF_TENDONS = ("displacement_mm", "displacement_mm_s")
_OF_AXES = ("current_ma", "temperature_c", "voltage_v", "hardware_error")


def checked(inputs: Inputs, tendons: int, axes: int) -> Inputs:
    """The same; a reading of the drive that is of no use is as good as none. Raises ClockError.

    Shapes are finite by their type; an age that is not makes them distrusted, as other ages do.
    """
    if not math.isfinite(inputs.now_s) or not 0 < inputs.dt_s < math.inf:
        raise ClockError(
            f"a cycle at now_s = {inputs.now_s} s, dt_s = {inputs.dt_s} s after the last: "
            "now_s must be finite, and dt_s finite and above 0"
        )
    if inputs.drive is None or not (wrong := _wrong(inputs.drive, tendons, axes)):
        return inputs
    return dataclasses.replace(inputs, drive=None, absence=wrong, absence_fault=DriveLostError.code)


def _wrong(drive: ActuatorState, tendons: int, axes: int) -> str:
    """What is wrong with a reading; nothing when it is sound."""
    for names, count in ((_OF_TENDONS, tendons), (_OF_AXES, axes)):
        for name in names:
            value = getattr(drive, name)
            if np.shape(value) != (count,) or not np.isfinite(value).all():
                return (
                    f"the tendon drive reports {name} = {np.asarray(value).tolist()}; "
                    f"it must be {count} finite numbers"
                )
    for name in ("insertion_mm", "insertion_mm_s"):
        if not math.isfinite(value := getattr(drive, name)):
            return f"the tendon drive reports {name} = {value}; it must be finite"
    return ""
