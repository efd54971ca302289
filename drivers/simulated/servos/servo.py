"""One emulated X servo: its control table brought to life."""

import enum
import math

from drivers.simulated.servos.memory import (
    ACCESS_ERROR,
    BAUD_RATES,
    GOALS,
    INSTRUCTION_ERROR,
    LIMIT_ERROR,
    RANGE_ERROR,
    RESULT_FAIL,
    InstructionRefusedError,
    Memory,
)
from drivers.simulated.servos.motor import COASTING, FULL_PWM, Drive, Motor
from drivers.simulated.servos.settings import EmulatedServosSettings

TICK_RAD = math.tau / 4096
VELOCITY_UNIT_RAD_S = 0.229 * math.tau / 60
ACCELERATION_UNIT_RAD_S2 = 214.577 * math.tau / 3600
CURRENT_UNIT_A = 0.00269
POSITION_GAIN_UNIT = 128
WATCHDOG_UNIT_S = 0.02
WATCHDOG_EXPIRED = -1
OVERHEATED = 0x04
OVERLOADED = 0x20
ALERT = 0x80

HORN_AT_START_TICKS = 2048
CLEAR_TURNS = b"\x01DXL\x22"
_LIMIT_OF_GOAL = {"goal_current": "current_limit", "goal_velocity": "velocity_limit", "goal_pwm": "pwm_limit"}


class Mode(enum.IntEnum):
    """Operating modes that are emulated."""

    CURRENT = 0
    VELOCITY = 1
    POSITION = 3
    EXTENDED_POSITION = 4
    CURRENT_BASED_POSITION = 5


class Servo:
    """Registers, rules, watchdog and motor of one servo. Times are handed in; `now_s` must not run backwards."""

    def __init__(self, settings: EmulatedServosSettings, servo_id: int) -> None:
        """Just powered on, in the middle of its first turn; that is angle 0 of its motor."""
        self.motor = Motor(settings.motor)
        self._settings = settings
        self._turns_forgotten = 0
        self._registered: tuple[int, bytes] | None = None
        self._heard_s = 0.0
        self._silent_until_s = -math.inf
        self._overloaded_s = 0.0
        self._began_ms = 7 * servo_id  # no two power on in the same millisecond
        eeprom = {
            "model_number": settings.model_number,
            "firmware_version": settings.firmware,
            "id": servo_id,
            "baud_rate": BAUD_RATES.index(settings.baud_rate),
            "operating_mode": settings.operating_mode,
            "return_delay_time": settings.return_delay_us // 2,
        }
        self.memory = Memory(eeprom, self._check_limits)
        self._begin_turns()

    @property
    def id(self) -> int:
        """The id it answers to."""
        return self.memory["id"]

    @property
    def baud_rate(self) -> int:
        """The speed that it hears and speaks."""
        return BAUD_RATES[self.memory["baud_rate"]]

    @property
    def return_delay_s(self) -> float:
        """How long it waits before it answers."""
        return self.memory["return_delay_time"] * 2e-6

    @property
    def torque_enabled(self) -> bool:
        """Whether the motor is driven."""
        return bool(self.memory["torque_enable"])

    @property
    def alert(self) -> int:
        """The alert bit of its answers, set while there is a hardware error."""
        return ALERT if self.memory["hardware_error_status"] else 0

    def is_awake(self, now_s: float) -> bool:
        """False while it restarts."""
        return now_s >= self._silent_until_s

    def hear(self, now_s: float) -> None:
        """An instruction packet, to whomever, was on the bus: feeds the watchdog."""
        self.check_watchdog(now_s)
        self._heard_s = now_s

    def check_watchdog(self, now_s: float) -> None:
        """Stop when the bus has been silent for too long."""
        limit = self.memory["bus_watchdog"]
        if self.torque_enabled and limit > 0 and now_s - self._heard_s > limit * WATCHDOG_UNIT_S:
            self.memory["bus_watchdog"] = WATCHDOG_EXPIRED
            self.motor.hold_here()

    def write(self, address: int, data: bytes) -> None:
        """A controller's write; raises InstructionRefusedError, and then nothing has changed."""
        for item, value in self.memory.check_write(address, data):
            self._put(item.name, value)

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`; raises InstructionRefusedError."""
        self.memory.check_write(address, data)
        self._registered = (address, data)
        self.memory["registered_instruction"] = 1

    def action(self) -> None:
        """Do what was registered; raises InstructionRefusedError when nothing was."""
        if self._registered is None:
            raise InstructionRefusedError(INSTRUCTION_ERROR)
        registered, self._registered = self._registered, None
        self.memory["registered_instruction"] = 0
        self.write(*registered)

    def clear(self, parameters: bytes) -> None:
        """Forget the turns counted, when standing still; raises InstructionRefusedError."""
        if parameters != CLEAR_TURNS:
            raise InstructionRefusedError(RANGE_ERROR)
        if self.memory["moving"]:
            raise InstructionRefusedError(RESULT_FAIL)
        self._begin_turns()

    def reboot(self, now_s: float) -> None:
        """Restart: silent for a while, RAM, turns and hardware error forgotten."""
        self.memory.forget_ram()
        self._registered = None
        self._overloaded_s = 0.0
        self._silent_until_s = now_s + self._settings.reboot_s
        self._begin_turns()

    def fail(self, error_bits: int) -> None:
        """Show a hardware error; one that Shutdown names takes the torque away until a reboot."""
        self.memory["hardware_error_status"] |= error_bits
        if error_bits & self.memory["shutdown"]:
            self.memory["torque_enable"] = 0

    def step(self, dt_s: float, load_torque_Nm: float, now_s: float) -> None:
        """Move on by `dt_s` under a load that, when positive, pulls the horn towards smaller angles."""
        self.check_watchdog(now_s)
        self.motor.step(dt_s, self._drive(), load_torque_Nm)
        self._show_state()
        self.memory["realtime_tick"] = (int(now_s * 1e3) + self._began_ms) % 32768
        if self.motor.temperature_C > self.memory["temperature_limit"]:
            self.fail(OVERHEATED)
        overloaded = abs(self.motor.current_A) >= self._settings.motor.overload_current_A
        self._overloaded_s = self._overloaded_s + dt_s if overloaded else 0.0
        if self._overloaded_s > self._settings.motor.overload_s:
            self.fail(OVERLOADED)

    def _put(self, name: str, value: int) -> None:
        if name == "torque_enable" and value and not self.torque_enabled:
            self.motor.hold_here()
        self.memory[name] = value
        if name == "operating_mode":
            self._begin_turns()

    def _check_limits(self, name: str, value: int) -> None:
        memory = self.memory
        if memory["bus_watchdog"] == WATCHDOG_EXPIRED and (
            name in GOALS or (name == "bus_watchdog" and value)
        ):
            raise InstructionRefusedError(RANGE_ERROR)
        if name == "torque_enable" and value and memory["hardware_error_status"] & memory["shutdown"]:
            raise InstructionRefusedError(ACCESS_ERROR)
        if name == "operating_mode" and value not in tuple(Mode):
            raise InstructionRefusedError(RANGE_ERROR)
        if name in _LIMIT_OF_GOAL and abs(value) > memory[_LIMIT_OF_GOAL[name]]:
            raise InstructionRefusedError(LIMIT_ERROR)
        within_turn = memory["min_position_limit"] <= value <= memory["max_position_limit"]
        if name == "goal_position" and memory["operating_mode"] == Mode.POSITION and not within_turn:
            raise InstructionRefusedError(LIMIT_ERROR)

    def _drive(self) -> Drive:
        """What the registers ask of the motor now; a servo stopped by its watchdog asks it to stay."""
        memory = self.memory
        if not self.torque_enabled:
            return COASTING
        stopped = memory["bus_watchdog"] == WATCHDOG_EXPIRED
        limit_A = memory["current_limit"] * CURRENT_UNIT_A
        acceleration = memory["profile_acceleration"] * ACCELERATION_UNIT_RAD_S2 or math.inf
        mode = memory["operating_mode"]
        if mode == Mode.CURRENT:
            return Drive(
                goal_A=0.0 if stopped else memory["goal_current"] * CURRENT_UNIT_A, current_limit_A=limit_A
            )
        if mode == Mode.VELOCITY:
            return Drive(
                goal_rad_s=0.0 if stopped else memory["goal_velocity"] * VELOCITY_UNIT_RAD_S,
                current_limit_A=limit_A,
                profile_acceleration_rad_s2=math.inf if stopped else acceleration,
            )
        if mode == Mode.CURRENT_BASED_POSITION:
            limit_A = min(limit_A, abs(memory["goal_current"]) * CURRENT_UNIT_A)
        goal_rad = (memory["goal_position"] - self._ticks_at_zero()) * TICK_RAD
        velocity = memory["profile_velocity"] * VELOCITY_UNIT_RAD_S
        duty_per_rad = memory["position_p_gain"] / POSITION_GAIN_UNIT / FULL_PWM / TICK_RAD
        return Drive(
            goal_rad=self.motor.profile_rad if stopped else goal_rad,
            current_limit_A=limit_A,
            stiffness_V_per_rad=duty_per_rad * self._settings.motor.supply_V,
            profile_velocity_rad_s=velocity or math.inf,
            profile_acceleration_rad_s2=acceleration if velocity else math.inf,
        )

    def _ticks_at_zero(self) -> int:
        return HORN_AT_START_TICKS + self.memory["homing_offset"] - 4096 * self._turns_forgotten

    def stand_at(self, place_rad: float) -> None:
        """Power on here, counted from the horn's zero over turns."""
        self.motor.position_rad = place_rad
        self.motor.hold_here()
        self._begin_turns()

    def _begin_turns(self) -> None:
        """Count turns anew, and want to be where it is."""
        self._turns_forgotten = math.floor((self.motor.position_rad / TICK_RAD + HORN_AT_START_TICKS) / 4096)
        self._show_state()
        self.memory["goal_position"] = self.memory["present_position"]

    def _show_state(self) -> None:
        memory, motor = self.memory, self.motor
        memory["present_position"] = round(motor.position_rad / TICK_RAD) + self._ticks_at_zero()
        memory["present_velocity"] = round(motor.velocity_rad_s / VELOCITY_UNIT_RAD_S)
        memory["present_current"] = round(motor.current_A / CURRENT_UNIT_A)
        memory["present_pwm"] = round(motor.duty * FULL_PWM)
        memory["present_input_voltage"] = round(motor.volts * 10)
        memory["present_temperature"] = round(motor.temperature_C)
        memory["moving"] = int(abs(memory["present_velocity"]) > memory["moving_threshold"])
        memory["position_trajectory"] = round(motor.profile_rad / TICK_RAD) + self._ticks_at_zero()
        memory["velocity_trajectory"] = round(motor.profile_rad_s / VELOCITY_UNIT_RAD_S)
