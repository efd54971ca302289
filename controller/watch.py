"""What the loop watches: whether shapes can be trusted, whether the drive is well, and whether motion must end.

Pure; thresholds from settings. Each fault says its reason, the value and the limit.
"""

import dataclasses
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from controller.errors import FaultError
from controller.faults import (
    FAULTS,
    DriveLostError,
    ExcessCurrentError,
    HomingTimeoutError,
    LoopStalledError,
    NotFollowingError,
    OperatorLostError,
    RegionEnteredError,
    SensingLostError,
    ServoAlarmError,
    SupplyVoltageError,
    TooHotError,
    TorqueLostError,
    TravelError,
)
from controller.limits import axis_name
from controller.plant import Plant
from controller.settings import ControllerSettings
from drivers.actuators import ActuatorState
from messaging.shape import ShapeEstimate

Array = NDArray[np.float64]

TRAVEL_TOLERANCE_MM = 0.5
"""How far a servo may stand beyond its travel, by settling and by being pushed, before that is a fault."""
_NEARING_MM_S = 0.5
"""A servo that comes nearer to where it was sent so fast is slow, but follows."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Trouble:
    """Since when things have been wrong that are allowed for a moment; infinity while they are right."""

    current_since_s: Array
    """(A,)."""
    following_since_s: Array
    """(A,)."""
    voltage_since_s: Array
    """(A,)."""
    travel_since_s: float = np.inf
    travel: str = ""

    @classmethod
    def none(cls, axes: int) -> "Trouble":
        """All is well."""
        right = np.full(axes, np.inf)
        return cls(current_since_s=right, following_since_s=right, voltage_since_s=right)

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
    if not 0 <= age_s < np.inf:
        return f"shape is said to be {age_s} s old; that must be finite, and 0 or more"
    if age_s > maximum_age_s:
        return (
            f"shape arrived {age_s * 1e3:.0f} ms after its capture, {maximum_age_s * 1e3:.0f} ms are allowed"
        )
    if capture_s <= last_capture_s:
        return "shape is older than the one before"
    return ""


class Watch:
    """Everything that may end in a fault while torque is on."""

    def __init__(self, settings: ControllerSettings, plant: Plant) -> None:
        """For one robot."""
        self._settings = settings
        self._limits = settings.limits
        self._plant = plant

    def absent(self, words: str, code: str) -> FaultError:
        """The fault that a drive without a reading is; `code` says of which kind."""
        return FAULTS.get(code, DriveLostError)(words)

    def drive(
        self, drive: ActuatorState, command_mm: Array, trouble: Trouble, now_s: float
    ) -> tuple[Trouble, list[FaultError]]:
        """What is wrong with this reading of the drive, which was sent to `command_mm` (A,) a cycle ago."""
        limits, (low_v, high_v) = self._limits, self._limits.voltage_v
        missing_mm = command_mm - drive.position_mm
        behind_mm = np.abs(missing_mm)
        nearing = np.sign(missing_mm) * drive.velocity_mm_s > _NEARING_MM_S
        astray = (behind_mm > limits.following_mm) & ~nearing
        measured = drive.voltage_v != 0.0
        unpowered = measured & ((drive.voltage_v < low_v) | (drive.voltage_v > high_v))
        trouble = dataclasses.replace(
            trouble,
            current_since_s=_since(
                np.abs(drive.current_ma) > limits.current_ma, trouble.current_since_s, now_s
            ),
            following_since_s=_since(astray, trouble.following_since_s, now_s),
            voltage_since_s=_since(unpowered, trouble.voltage_since_s, now_s),
        )
        return trouble, [*self._alarms(drive), *self._strains(drive, behind_mm, trouble, now_s)]

    def _alarms(self, drive: ActuatorState) -> Iterator[FaultError]:
        """What may not be for a single cycle."""
        plant, limit_c = self._plant.limits, self._limits.temperature_c
        if any(drive.hardware_error):
            bits = ", ".join(
                f"{self._name(axis)} 0x{error:02x}"
                for axis, error in enumerate(drive.hardware_error)
                if error
            )
            words = f" ({drive.alarm})" if drive.alarm else ""
            yield ServoAlarmError(f"hardware error bits: {bits}{words}")
        if not drive.torque:
            yield TorqueLostError("a servo let its tendon go by itself")
        if beyond := plant.beyond_travel(drive.position_mm, TRAVEL_TOLERANCE_MM):
            axis = int(
                np.maximum(drive.position_mm - plant.high_mm, plant.low_mm - drive.position_mm).argmax()
            )
            value = float(drive.position_mm[axis])
            limit = plant.high_mm[axis] if value > plant.high_mm[axis] else plant.low_mm[axis]
            yield TravelError("; ".join(beyond), value=value, limit=limit, unit="mm")
        if (drive.temperature_c > limit_c).any():
            axis = int(drive.temperature_c.argmax())
            value = float(drive.temperature_c[axis])
            words = f"the servo of {self._name(axis)} has {value:.0f} C; at most {limit_c:g} C are allowed"
            yield TooHotError(words, value=value, limit=limit_c, unit="C")

    def _strains(
        self, drive: ActuatorState, behind_mm: Array, trouble: Trouble, now_s: float
    ) -> Iterator[FaultError]:
        """What may be for a moment."""
        limits = self._limits
        if (axis := _lasting(trouble.current_since_s, limits.current_grace_s, now_s)) is not None:
            value, limit = abs(float(drive.current_ma[axis])), limits.current_ma
            words = (
                f"{self._name(axis)} draws {value:.0f} mA for more than {limits.current_grace_s:g} s; "
                f"at most {limit:g} mA are allowed"
            )
            yield ExcessCurrentError(words, value=value, limit=limit, unit="mA")
        if (axis := _lasting(trouble.voltage_since_s, limits.voltage_grace_s, now_s)) is not None:
            value, (low, high) = float(drive.voltage_v[axis]), limits.voltage_v
            words = (
                f"the servo of {self._name(axis)} has {value:.1f} V for more than {limits.voltage_grace_s:g} s; "
                f"{low:g} to {high:g} V are allowed"
            )
            yield SupplyVoltageError(words, value=value, limit=high if value > high else low, unit="V")
        if (axis := _lasting(trouble.following_since_s, limits.following_grace_s, now_s)) is not None:
            value, limit = float(behind_mm[axis]), limits.following_mm
            words = (
                f"{self._name(axis)} stands {value:.2f} mm from where it was sent for more than "
                f"{limits.following_grace_s:g} s; {limit:g} mm are allowed"
            )
            yield NotFollowingError(words, value=value, limit=limit, unit="mm")

    def pushed(self, trouble: Trouble, now_s: float) -> list[FaultError]:
        """Commands that were cut short at the end of a travel for too long."""
        pushed_s, limit_s = now_s - trouble.travel_since_s, self._limits.travel_grace_s
        if pushed_s <= limit_s:
            return []
        words = f"pushed for more than {limit_s:g} s beyond travel: {trouble.travel}"
        return [TravelError(words, value=pushed_s, limit=limit_s, unit="s")]

    def unseen(self, unseen_s: float, distrusted: str) -> list[FaultError]:
        """Moving or waiting without trusted shapes."""
        limit_s = self._settings.sensing.hold_at_most_s
        if unseen_s <= limit_s:
            return []
        words = f"no trusted shape for {unseen_s:.2f} s, {limit_s:g} s are allowed: {distrusted}"
        return [SensingLostError(words, value=min(unseen_s, _LONG_S), limit=limit_s, unit="s")]

    def straightening(self, since_s: float, now_s: float) -> list[FaultError]:
        """Homing that does not end."""
        homing, took_s = self._settings.homing, now_s - since_s
        if took_s <= homing.timeout_s:
            return []
        words = f"the robot is not straight within {homing.within_mm:g} mm after {homing.timeout_s:g} s"
        return [HomingTimeoutError(words, value=took_s, limit=homing.timeout_s, unit="s")]

    def body(self, shape: ShapeEstimate) -> list[FaultError]:
        """Any part of the robot that is seen inside a forbidden region."""
        regions = self._plant.regions
        if not len(regions):
            return []
        seen_mm = np.concatenate([shape.centreline_mm, shape.node_mm])
        clearance, _ = regions.clearance(seen_mm)
        point, region = np.unravel_index(clearance.argmin(), clearance.shape)
        depth_mm = -float(clearance[point, region])
        if depth_mm <= 0:
            return []
        place = ", ".join(f"{value:.1f}" for value in seen_mm[point])
        words = f"the robot is {depth_mm:.1f} mm inside the forbidden region {regions.names[region]}, at ({place}) mm"
        return [RegionEnteredError(words, value=depth_mm, limit=0.0, unit="mm")]

    def operator(self, unheard_s: float) -> list[FaultError]:
        """Nobody there for longer than a hold may last."""
        operator = self._settings.operator
        limit_s = operator.heartbeat_s + operator.hold_s
        if not operator.heartbeat_s or unheard_s <= limit_s:
            return []
        words = f"no operator's heartbeat for {unheard_s:.1f} s, {limit_s:g} s are allowed"
        return [OperatorLostError(words, value=min(unheard_s, _LONG_S), limit=limit_s, unit="s")]

    def cycle(self, gap_s: float) -> list[FaultError]:
        """Too much time since the last cycle."""
        limit_s = self._settings.stall_s
        if gap_s <= limit_s:
            return []
        words = f"the loop stood still for {gap_s:.2f} s, {limit_s:g} s are allowed"
        return [LoopStalledError(words, value=gap_s, limit=limit_s, unit="s")]

    def _name(self, axis: int) -> str:
        return axis_name(axis, self._plant.limits.tendons)


_LONG_S = 1e9
"""What a fault says instead of for ever: messages carry finite numbers only."""


def _since(wrong: NDArray[np.bool_], since_s: Array, now_s: float) -> Array:
    return np.where(wrong, np.minimum(since_s, now_s), np.inf)


def _lasting(since_s: Array, grace_s: float, now_s: float) -> int | None:
    """The first axis of which something has been wrong for longer than `grace_s`."""
    lasting = now_s - since_s > grace_s
    return int(lasting.argmax()) if lasting.any() else None
