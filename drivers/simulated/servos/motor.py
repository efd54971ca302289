"""A servo's motor, gear, position controller and motion profile: goals in, angle and current out, in SI units at the horn.

The controller sets a voltage; the current follows from it and the back EMF, is bounded, and turns the inertia against
friction and load: a second-order system that creeps towards its goal, saturates, and gives way under load as real ones do.
"""

import dataclasses
import math

from drivers.simulated.servos.settings import MotorSettings

LONGEST_STEP_S = 0.001
FULL_PWM = 885
HEATING_C_PER_W_S = 0.02
COOLING_PER_S = 0.004
VOLTAGE_SAG_OHM = 0.15


@dataclasses.dataclass(frozen=True, slots=True)
class Drive:
    """What the servo's registers ask of the motor at this moment.

    Exactly one of `goal_rad`, `goal_rad_s` and `goal_A` is set; none is when torque is off. A profile value of inf means
    that the goal is followed at once.
    """

    goal_rad: float | None = None
    goal_rad_s: float | None = None
    goal_A: float | None = None
    current_limit_A: float = math.inf
    stiffness_V_per_rad: float = 0.0
    profile_velocity_rad_s: float = math.inf
    profile_acceleration_rad_s2: float = math.inf


COASTING = Drive()
SPEED_GAIN = 4.0
"""Volts of correction per volt of back EMF missing, in velocity control."""


class Motor:
    """The state of one motor. Angles are continuous over turns; positive is counter-clockwise."""

    def __init__(self, settings: MotorSettings) -> None:
        """At rest, at the temperature around it."""
        self.position_rad = 0.0
        self.velocity_rad_s = 0.0
        self.current_A = 0.0
        self.duty = 0.0
        self.temperature_C = settings.ambient_C
        self.profile_rad = 0.0
        self.profile_rad_s = 0.0
        self._settings = settings
        self._torque_per_A = settings.stall_torque_Nm / settings.stall_current_A
        self._resistance_ohm = settings.supply_V / settings.stall_current_A
        self._back_emf_V_s = settings.supply_V / settings.no_load_speed_rad_s

    @property
    def volts(self) -> float:
        """Supply voltage at the servo under its own load."""
        return self._settings.supply_V - VOLTAGE_SAG_OHM * abs(self.current_A * self.duty)

    def hold_here(self) -> None:
        """Begin profiles anew from where the horn is."""
        self.profile_rad, self.profile_rad_s = self.position_rad, 0.0

    def step(self, dt_s: float, drive: Drive, load_torque_Nm: float) -> None:
        """Move on by `dt_s`; positive `load_torque_Nm` pulls the horn towards smaller angles."""
        count = max(1, math.ceil(dt_s / LONGEST_STEP_S - 1e-9))
        for _ in range(count):
            self._substep(dt_s / count, drive, load_torque_Nm)
        heat_W = self.current_A**2 * self._resistance_ohm
        excess_C = self.temperature_C - self._settings.ambient_C
        self.temperature_C += dt_s * (HEATING_C_PER_W_S * heat_W - COOLING_PER_S * excess_C)

    def _substep(self, dt_s: float, drive: Drive, load_torque_Nm: float) -> None:
        self.current_A = self._current(dt_s, drive)
        torque_Nm = self._torque_per_A * self.current_A - load_torque_Nm
        velocity = self.velocity_rad_s + dt_s * torque_Nm / self._settings.inertia_kg_m2
        friction = dt_s * self._settings.friction_Nm / self._settings.inertia_kg_m2
        self.velocity_rad_s = math.copysign(max(0.0, abs(velocity) - friction), velocity)
        self.position_rad += dt_s * self.velocity_rad_s

    def _current(self, dt_s: float, drive: Drive) -> float:
        if drive.goal_rad is not None:
            self._follow_profile(dt_s, drive.goal_rad, drive)
            asked_V = drive.stiffness_V_per_rad * (self.profile_rad - self.position_rad)
        elif drive.goal_rad_s is not None:
            self.profile_rad_s = _towards(
                self.profile_rad_s, drive.goal_rad_s, dt_s * drive.profile_acceleration_rad_s2
            )
            missing_V = self._back_emf_V_s * (self.profile_rad_s - self.velocity_rad_s)
            asked_V = self._back_emf_V_s * self.profile_rad_s + SPEED_GAIN * missing_V
        elif drive.goal_A is not None:
            asked_V = drive.goal_A * self._resistance_ohm + self._back_emf_V_s * self.velocity_rad_s
        else:
            self.duty = 0.0
            return 0.0
        supply_V = self._settings.supply_V
        voltage_V = min(supply_V, max(-supply_V, asked_V))
        self.duty = voltage_V / supply_V
        current_A = (voltage_V - self._back_emf_V_s * self.velocity_rad_s) / self._resistance_ohm
        return min(drive.current_limit_A, max(-drive.current_limit_A, current_A))

    def _follow_profile(self, dt_s: float, goal_rad: float, drive: Drive) -> None:
        """Trapezoidal velocity towards the goal, slowing down in time; goes on smoothly when the goal changes."""
        distance = goal_rad - self.profile_rad
        speed = min(drive.profile_velocity_rad_s, abs(distance) / dt_s)
        change = dt_s * drive.profile_acceleration_rad_s2
        if math.isfinite(change):
            speed = min(speed, math.sqrt(2 * drive.profile_acceleration_rad_s2 * abs(distance)))
        self.profile_rad_s = _towards(self.profile_rad_s, math.copysign(speed, distance), change)
        self.profile_rad += dt_s * self.profile_rad_s


def _towards(value: float, goal: float, change: float) -> float:
    return min(value + change, max(value - change, goal))
