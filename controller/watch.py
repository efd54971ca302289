"""What the loop watches: whether shapes can be trusted, and whether the drive is well. Pure; thresholds from settings."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from controller.errors import (
    DriveLostError,
    ExcessCurrentError,
    FaultError,
    HomingTimeoutError,
    SensingLostError,
    ServoAlarmError,
    TorqueLostError,
    TravelError,
)
from controller.limits import Limits, axis_name
from controller.settings import ControllerSettings
from controller.supervisor import Mode, Supervision
from drivers.actuators import ActuatorState
from messaging.shape import ShapeEstimate

Array = NDArray[np.float64]

_TRAVEL_TOLERANCE_MM = 0.5
"""How far a servo may stand beyond its travel, by settling and by being pushed, before that is a fault."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Trouble:
    """Since when things have been wrong that are allowed for a moment; infinity while they are right."""

    current_since_s: Array
    """(A,)."""
    travel_since_s: float = np.inf
    travel: str = ""

    @classmethod
    def none(cls, axes: int) -> "Trouble":
        """All is well."""
        return cls(current_since_s=np.full(axes, np.inf))

    def pushing(self, travel: str, now_s: float) -> "Trouble":
        """The same, now that commands were cut short at the end of a travel, or were not (no `travel` in words)."""
        since_s = min(self.travel_since_s, now_s) if travel else np.inf
        return dataclasses.replace(self, travel_since_s=since_s, travel=travel)


def distrust(
    shape: ShapeEstimate, age_s: float, capture_s: float, last_capture_s: float, maximum_age_s: float
) -> str:
    """Why this shape must not be acted on; nothing when it may."""
    if shape.refusal:
        return f"shape refused: {shape.refusal}"
    if shape.flags:
        return f"shape flagged: {', '.join(shape.flags)}"
    if age_s > maximum_age_s:
        return (
            f"shape arrived {age_s * 1e3:.0f} ms after its capture, {maximum_age_s * 1e3:.0f} ms are allowed"
        )
    if capture_s <= last_capture_s:
        return "shape is older than the one before"
    return ""


def drive_faults(
    drive: ActuatorState | None,
    absence: str,
    trouble: Trouble,
    *,
    settings: ControllerSettings,
    limits: Limits,
    now_s: float,
) -> tuple[Trouble, list[FaultError]]:
    """What is wrong with the drive while torque should be on; `absence` says why there is no reading."""
    if drive is None:
        return trouble, [DriveLostError(absence)]
    faults: list[FaultError] = []
    if any(drive.hardware_error):
        bits = ", ".join(
            f"{axis_name(axis, limits.tendons)} 0x{error:02x}"
            for axis, error in enumerate(drive.hardware_error)
            if error
        )
        faults.append(ServoAlarmError(f"hardware error bits: {bits}"))
    if not drive.torque:
        faults.append(TorqueLostError("a servo let its tendon go by itself"))
    if beyond := limits.beyond_travel(drive.position_mm, _TRAVEL_TOLERANCE_MM):
        faults.append(TravelError("; ".join(beyond)))
    excess = np.abs(drive.current_ma) > settings.limits.current_ma
    since = np.where(excess, np.minimum(trouble.current_since_s, now_s), np.inf)
    lasting = now_s - since > settings.limits.current_grace_s
    if lasting.any():
        axis = int(lasting.argmax())
        faults.append(
            ExcessCurrentError(
                f"{axis_name(axis, limits.tendons)} draws {drive.current_ma[axis]:.0f} mA for more than "
                f"{settings.limits.current_grace_s:g} s; at most {settings.limits.current_ma:g} mA are allowed"
            )
        )
    if now_s - trouble.travel_since_s > settings.limits.travel_grace_s:
        faults.append(
            TravelError(
                f"pushed for more than {settings.limits.travel_grace_s:g} s beyond travel: {trouble.travel}"
            )
        )
    return dataclasses.replace(trouble, current_since_s=since), faults


def motion_faults(
    supervision: Supervision, unseen_s: float, distrusted: str, settings: ControllerSettings, now_s: float
) -> list[FaultError]:
    """What must not go on: moving or waiting without trusted shapes, homing without an end."""
    faults: list[FaultError] = []
    allowed_s = settings.sensing.hold_at_most_s
    if supervision.mode in (Mode.HOMING, Mode.WAITING) and unseen_s > allowed_s:
        faults.append(
            SensingLostError(
                f"no trusted shape for {unseen_s:.2f} s, {allowed_s:g} s are allowed: {distrusted}"
            )
        )
    if supervision.mode is Mode.HOMING and now_s - supervision.since_s > settings.homing.timeout_s:
        faults.append(
            HomingTimeoutError(
                f"the robot is not straight within {settings.homing.within_mm:g} mm after {settings.homing.timeout_s:g} s"
            )
        )
    return faults
