"""The registers of Dynamixel X servos that the driver uses, and the models it knows.

Source: ROBOTIS e-manual, control tables of XM430-W350, XM540-W270, XH430-W350, XH540-W270 and XC330/XL330.
"""

import dataclasses
import enum
import math

TICKS_PER_TURN = 4096
RAD_PER_TICK = 2 * math.pi / TICKS_PER_TURN
RAD_S_PER_VELOCITY = 0.229 * 2 * math.pi / 60
RAD_S2_PER_ACCELERATION = 214.577 * 2 * math.pi / 3600
VOLTS_PER_COUNT = 0.1
MAX_TURNS = 256
"""How far multi-turn positions reach, either way."""
BAUD_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""By the value of the register Baud Rate."""
WATCHDOG_UNIT_MS = 20
WATCHDOG_EXPIRED = -1


class Access(enum.Enum):
    """What a controller may do with a register."""

    READ = "R"
    READ_WRITE = "RW"


class Area(enum.Enum):
    """EEPROM is kept without power and locked while torque is on; RAM is forgotten at each start."""

    EEPROM = "EEPROM"
    RAM = "RAM"


@dataclasses.dataclass(frozen=True, slots=True)
class Register:
    """One value in the servo; `unit` is what one count stands for."""

    name: str
    address: int
    size: int
    unit: str
    access: Access = Access.READ_WRITE
    area: Area = Area.RAM
    signed: bool = False

    def to_bytes(self, value: int) -> bytes:
        """`value` as the servo keeps it; raises OverflowError when the register is too small for it."""
        return value.to_bytes(self.size, "little", signed=self.signed)

    def from_bytes(self, data: bytes) -> int:
        """The value that the servo sent."""
        return int.from_bytes(data, "little", signed=self.signed)


_R, _RW, _EEPROM = Access.READ, Access.READ_WRITE, Area.EEPROM

MODEL_NUMBER = Register("Model Number", 0, 2, "", _R, _EEPROM)
FIRMWARE_VERSION = Register("Firmware Version", 6, 1, "", _R, _EEPROM)
ID = Register("ID", 7, 1, "", _RW, _EEPROM)
BAUD_RATE = Register("Baud Rate", 8, 1, "place in BAUD_RATES", _RW, _EEPROM)
RETURN_DELAY_TIME = Register("Return Delay Time", 9, 1, "2 us", _RW, _EEPROM)
DRIVE_MODE = Register("Drive Mode", 10, 1, "bits", _RW, _EEPROM)
OPERATING_MODE = Register("Operating Mode", 11, 1, "", _RW, _EEPROM)
SECONDARY_ID = Register("Secondary ID", 12, 1, "", _RW, _EEPROM)
HOMING_OFFSET = Register("Homing Offset", 20, 4, "2 pi / 4096 rad", _RW, _EEPROM, signed=True)
TEMPERATURE_LIMIT = Register("Temperature Limit", 31, 1, "1 C", _RW, _EEPROM)
MAX_VOLTAGE_LIMIT = Register("Max Voltage Limit", 32, 2, "0.1 V", _RW, _EEPROM)
MIN_VOLTAGE_LIMIT = Register("Min Voltage Limit", 34, 2, "0.1 V", _RW, _EEPROM)
CURRENT_LIMIT = Register("Current Limit", 38, 2, "current_unit_ma", _RW, _EEPROM)
VELOCITY_LIMIT = Register("Velocity Limit", 44, 4, "0.229 rev/min", _RW, _EEPROM)
MAX_POSITION_LIMIT = Register("Max Position Limit", 48, 4, "2 pi / 4096 rad", _RW, _EEPROM, signed=True)
MIN_POSITION_LIMIT = Register("Min Position Limit", 52, 4, "2 pi / 4096 rad", _RW, _EEPROM, signed=True)
STARTUP_CONFIGURATION = Register("Startup Configuration", 60, 1, "bits", _RW, _EEPROM)
SHUTDOWN = Register("Shutdown", 63, 1, "bits of Hardware Error Status", _RW, _EEPROM)

TORQUE_ENABLE = Register("Torque Enable", 64, 1, "")
LED = Register("LED", 65, 1, "")
STATUS_RETURN_LEVEL = Register("Status Return Level", 68, 1, "")
HARDWARE_ERROR_STATUS = Register("Hardware Error Status", 70, 1, "bits", _R)
BUS_WATCHDOG = Register("Bus Watchdog", 98, 1, "20 ms", signed=True)
GOAL_CURRENT = Register("Goal Current", 102, 2, "current_unit_ma", signed=True)
GOAL_VELOCITY = Register("Goal Velocity", 104, 4, "0.229 rev/min", signed=True)
PROFILE_ACCELERATION = Register("Profile Acceleration", 108, 4, "214.577 rev/min^2")
PROFILE_VELOCITY = Register("Profile Velocity", 112, 4, "0.229 rev/min")
GOAL_POSITION = Register("Goal Position", 116, 4, "2 pi / 4096 rad", signed=True)
REALTIME_TICK = Register("Realtime Tick", 120, 2, "1 ms", _R)
MOVING = Register("Moving", 122, 1, "", _R)
PRESENT_CURRENT = Register("Present Current", 126, 2, "current_unit_ma", _R, signed=True)
PRESENT_VELOCITY = Register("Present Velocity", 128, 4, "0.229 rev/min", _R, signed=True)
PRESENT_POSITION = Register("Present Position", 132, 4, "2 pi / 4096 rad", _R, signed=True)
PRESENT_INPUT_VOLTAGE = Register("Present Input Voltage", 144, 2, "0.1 V", _R)
PRESENT_TEMPERATURE = Register("Present Temperature", 146, 1, "1 C", _R)

INDIRECT_ADDRESS_1 = 168
"""First of the words that say which byte appears in which place of the indirect data."""

CURRENT_BASED_POSITION_MODE = 5
"""Multi-turn position control whose current, and so the tendon's tension, never exceeds Goal Current."""

OPERATING_MODES = {
    0: "current",
    1: "velocity",
    3: "position",
    4: "extended position",
    5: "current-based position",
    16: "PWM",
}
HARDWARE_ERRORS = {
    0x01: "input voltage",
    0x04: "overheating",
    0x08: "motor encoder",
    0x10: "electrical shock",
    0x20: "overload",
}


def hardware_error_names(bits: int) -> str:
    """The errors that Hardware Error Status `bits` stand for, in words."""
    return ", ".join(HARDWARE_ERRORS.get(1 << n, f"bit {n}") for n in range(8) if bits >> n & 1)


@dataclasses.dataclass(frozen=True, slots=True)
class Model:
    """What differs between the models: one count of current, where indirect data begins, fast sync read's firmware."""

    name: str
    current_unit_ma: float
    indirect_data_1: int
    fast_sync_read_firmware: int


def _x430_x540(name: str) -> Model:
    return Model(name, current_unit_ma=2.69, indirect_data_1=224, fast_sync_read_firmware=45)


def _x330(name: str) -> Model:
    return Model(name, current_unit_ma=1.0, indirect_data_1=208, fast_sync_read_firmware=46)


MODELS = {
    1000: _x430_x540("XH430-W350"),
    1010: _x430_x540("XH430-W210"),
    1020: _x430_x540("XM430-W350"),
    1030: _x430_x540("XM430-W210"),
    1100: _x430_x540("XH540-W270"),
    1110: _x430_x540("XH540-W150"),
    1120: _x430_x540("XM540-W270"),
    1130: _x430_x540("XM540-W150"),
    1190: _x330("XL330-M077"),
    1200: _x330("XL330-M288"),
    1210: _x330("XC330-M181"),
    1220: _x330("XC330-M288"),
    1230: _x330("XC330-T181"),
    1240: _x330("XC330-T288"),
}
"""Models by Model Number. All measure their current; XL430 and XC430 do not, so tendon tension could not be watched."""
