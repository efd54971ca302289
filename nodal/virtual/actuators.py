"""The tendon drive on a virtual bench: what `drivers.dynamixel` does with packets, done with the emulated servos' registers.

The same rounding to encoder ticks, the same watchdog and the same errors, so that `controller.drive` and `controller.watch`
meet what they meet on a bench. Only a travel of its own it has none.
"""

import math
from collections.abc import Sequence
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivers.actuators import (
    ActuatorError,
    ActuatorState,
    CommandRefusedError,
    ServoAlarmError,
    ServoRestartedError,
    WatchdogExpiredError,
)
from drivers.dynamixel.control_table import hardware_error_names
from drivers.simulated.servos.servo import (
    ACCELERATION_UNIT_RAD_S2,
    CURRENT_UNIT_A,
    TICK_RAD,
    VELOCITY_UNIT_RAD_S,
    WATCHDOG_EXPIRED,
    Servo,
)
from nodal.virtual.settings import ServoSettings

Array = NDArray[np.float64]

_WATCHDOG_UNIT_MS = 20
_ROUNDING_S = 1e-9
_CONFIGURED = "profile_velocity"
"""A register that is never 0 in a servo that the drive has set up: one that restarted has forgotten it."""


class VirtualActuators:
    """The `Actuators` of a virtual bench."""

    def __init__(
        self, settings: ServoSettings, servos: Sequence[Servo], mm_per_rad: Array, tendon_axes: int
    ) -> None:
        """`mm_per_rad` (A,) is what the drive believes of the plant's servos; the stage's, if any, follows the tendons'."""
        self._settings = settings
        self._servos = servos
        self._tendon_axes = tendon_axes
        self._mm_per_tick = mm_per_rad * TICK_RAD
        self._zero_ticks: Array = np.zeros(len(servos))
        self._now_s = 0.0
        self._busy_until_s = 0.0
        self._relax_at_s = math.inf
        self.silent: set[int] = set()
        """Axes whose servos answer nothing and hear nothing."""

    def pass_time(self, now_s: float) -> bool:
        """It is `now_s` now; the bench says so in every cycle. False while the drive still waits in vain for an answer."""
        self._now_s = now_s
        if now_s >= self._relax_at_s - _ROUNDING_S:
            self._relax()
        return now_s >= self._busy_until_s - _ROUNDING_S

    def open(self) -> None:
        """Relax and set up every servo; raises ActuatorError for one that is silent."""
        self.disable()
        velocity = max(1, round(self._settings.profile_velocity_rad_s / VELOCITY_UNIT_RAD_S))
        acceleration = max(1, round(self._settings.profile_acceleration_rad_s2 / ACCELERATION_UNIT_RAD_S2))
        for servo in self._servos:
            servo.memory["profile_velocity"] = velocity
            servo.memory["profile_acceleration"] = acceleration
            servo.memory["goal_current"] = int(self._settings.maximum_current_ma * 1e-3 / CURRENT_UNIT_A)
        (self._zero_ticks,) = self._read("present_position")

    def close(self) -> None:
        """Relax the servos; raises ActuatorError for those that do not confirm."""
        self.disable()

    def __enter__(self) -> Self:
        """Open."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def read(self) -> ActuatorState:
        """One reading of all servos; raises ActuatorError, ServoRestartedError and WatchdogExpiredError."""
        self._speak()
        configured, watchdog, ticks, velocity, current, temperature, voltage = self._read(
            _CONFIGURED,
            "bus_watchdog",
            "present_position",
            "present_velocity",
            "present_current",
            "present_temperature",
            "present_input_voltage",
        )
        if not configured.all():
            raise ServoRestartedError("a servo restarted by itself and forgot its turns; home again")
        if (watchdog == WATCHDOG_EXPIRED).any():
            raise WatchdogExpiredError(
                f"the servos heard nothing for {self._settings.watchdog_ms} ms and stopped"
            )
        position_mm = (ticks - self._zero_ticks) * self._mm_per_tick
        speed_mm_s = velocity * VELOCITY_UNIT_RAD_S * (self._mm_per_tick / TICK_RAD)
        return ActuatorState(
            displacement_mm=position_mm[: self._tendon_axes],
            displacement_mm_s=speed_mm_s[: self._tendon_axes],
            insertion_mm=float(position_mm[self._tendon_axes :].sum()),
            insertion_mm_s=float(speed_mm_s[self._tendon_axes :].sum()),
            current_ma=current * CURRENT_UNIT_A * 1e3,
            temperature_c=temperature,
            voltage_v=voltage / 10,
            hardware_error=tuple(servo.memory["hardware_error_status"] for servo in self._servos),
            torque=all(servo.torque_enabled for servo in self._servos),
            alarm="; ".join(
                f"servo {servo.id}: {hardware_error_names(bits)}"
                for servo in self._servos
                if (bits := servo.memory["hardware_error_status"])
            ),
        )

    def write(self, displacement_mm: Array, insertion_mm: float) -> None:
        """Set the goals, which nobody acknowledges and an expired watchdog ignores; raises CommandRefusedError."""
        goal_mm = self._positions_mm(displacement_mm, insertion_mm)
        ticks = np.round(self._zero_ticks + goal_mm / self._mm_per_tick).astype(int).tolist()
        self._speak()
        for servo, goal in zip(self._hearing(), [ticks[axis] for axis in self._answering()], strict=True):
            servo.memory["goal_position"] = goal

    def set_zero(self, displacement_mm: Array, insertion_mm: float) -> None:
        """Call the present position `displacement_mm` (D,) and `insertion_mm`; raises CommandRefusedError."""
        position_mm = self._positions_mm(displacement_mm, insertion_mm)
        (ticks,) = self._read("present_position")
        self._zero_ticks = ticks - position_mm / self._mm_per_tick

    def enable(self) -> None:
        """Hold the present position and arm the watchdog; raises ActuatorError."""
        self._speak()
        units = math.ceil(self._settings.watchdog_ms / _WATCHDOG_UNIT_MS)
        self._read("present_position")
        for servo in self._servos:
            servo.memory["bus_watchdog"] = 0
            servo.memory["goal_position"] = servo.memory["present_position"]
            self._set_torque(servo, 1)
            servo.memory["bus_watchdog"] = units

    def disable(self) -> None:
        """Torque and watchdog off, once the drive waits no more; raises ActuatorError for servos that do not confirm."""
        self._relax_at_s = max(self._now_s, self._busy_until_s)
        if self._relax_at_s == self._now_s:
            self._relax()
        self._read("torque_enable")

    def _relax(self) -> None:
        self._relax_at_s = math.inf
        self._speak()
        for servo in self._hearing():
            self._set_torque(servo, 0)
            servo.memory["bus_watchdog"] = 0

    def _positions_mm(self, displacement_mm: Array, insertion_mm: float) -> Array:
        stage = len(self._servos) > self._tendon_axes
        position_mm = np.append(displacement_mm, insertion_mm)
        if np.shape(displacement_mm) != (self._tendon_axes,) or not np.isfinite(position_mm).all():
            raise CommandRefusedError(
                f"{position_mm.tolist()} mm refused: {self._tendon_axes} displacements and an insertion must be finite"
            )
        if not stage and insertion_mm:
            raise CommandRefusedError(f"insertion {insertion_mm} mm must be 0: there is no stage")
        return position_mm[: len(self._servos)]

    def _set_torque(self, servo: Servo, torque: int) -> None:
        if torque and servo.memory["hardware_error_status"] & servo.memory["shutdown"]:
            raise ServoAlarmError(f"servo {servo.id} shows a hardware error and takes no torque")
        if torque and not servo.torque_enabled:
            servo.motor.hold_here()
        servo.memory["torque_enable"] = torque

    def _speak(self) -> None:
        for servo in self._hearing():
            servo.hear(self._now_s)

    def _answering(self) -> list[int]:
        return [
            axis
            for axis, servo in enumerate(self._servos)
            if axis not in self.silent and servo.is_awake(self._now_s)
        ]

    def _hearing(self) -> list[Servo]:
        return [self._servos[axis] for axis in self._answering()]

    def _read(self, *registers: str) -> list[Array]:
        """(A,) of each register; raises ActuatorError naming the servos that do not answer."""
        answering = self._answering()
        if len(answering) < len(self._servos):
            missing = sorted(set(range(len(self._servos))) - set(answering))
            self._busy_until_s = max(self._now_s, self._busy_until_s) + self._settings.unanswered_s
            raise ActuatorError(f"no answer from servo {', '.join(str(self._servos[a].id) for a in missing)}")
        return [
            np.array([servo.memory[register] for servo in self._servos], dtype=np.float64)
            for register in registers
        ]
