"""The control table of an X servo and its rules of access (e-manual, XM430-W350).

Kept apart from the real driver's table, so that no mistake can hide on both sides.
"""

import dataclasses
from collections.abc import Callable

RESULT_FAIL, INSTRUCTION_ERROR, CRC_ERROR, RANGE_ERROR, LENGTH_ERROR, LIMIT_ERROR, ACCESS_ERROR = range(1, 8)

BAUD_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""By the value of their register."""
EEPROM_END = 64
TABLE_END = 662
INDIRECT = tuple((168 + 2 * n, 224 + n) for n in range(28)) + tuple((578 + 2 * n, 634 + n) for n in range(28))
"""Pairs of the indirect address word and the indirect data byte that shows what it points to."""


class InstructionRefusedError(Exception):
    """The servo answers with error number `number`."""

    def __init__(self, number: int) -> None:
        """Keep the number for the answer."""
        super().__init__(number)
        self.number = number


@dataclasses.dataclass(frozen=True, slots=True)
class Item:
    """One register: where, how wide, its value at start, and what may be written (nothing when `low` is None)."""

    name: str
    address: int
    size: int
    initial: int = 0
    low: int | None = None
    high: int = 0


_GAIN = (0, 16383)
_WORD = (-32768, 32767)
_MULTI_TURN = 1_048_575

ITEMS = (
    Item("model_number", 0, 2),
    Item("model_information", 2, 4),
    Item("firmware_version", 6, 1),
    Item("id", 7, 1, 1, 0, 252),
    Item("baud_rate", 8, 1, 3, 0, 7),
    Item("return_delay_time", 9, 1, 250, 0, 254),
    Item("drive_mode", 10, 1, 0, 0, 13),
    Item("operating_mode", 11, 1, 3, 0, 16),
    Item("secondary_id", 12, 1, 255, 0, 255),
    Item("protocol_type", 13, 1, 2, 1, 2),
    Item("homing_offset", 20, 4, 0, -1_044_479, 1_044_479),
    Item("moving_threshold", 24, 4, 10, 0, 1023),
    Item("temperature_limit", 31, 1, 80, 0, 100),
    Item("max_voltage_limit", 32, 2, 160, 95, 160),
    Item("min_voltage_limit", 34, 2, 95, 95, 160),
    Item("pwm_limit", 36, 2, 885, 0, 885),
    Item("current_limit", 38, 2, 1193, 0, 1193),
    Item("acceleration_limit", 40, 4, 32767, 0, 32767),
    Item("velocity_limit", 44, 4, 350, 0, 1023),
    Item("max_position_limit", 48, 4, 4095, 0, 4095),
    Item("min_position_limit", 52, 4, 0, 0, 4095),
    Item("startup_configuration", 60, 1, 0, 0, 3),
    Item("shutdown", 63, 1, 52, 0, 63),
    Item("torque_enable", 64, 1, 0, 0, 1),
    Item("led", 65, 1, 0, 0, 1),
    Item("status_return_level", 68, 1, 2, 0, 2),
    Item("registered_instruction", 69, 1),
    Item("hardware_error_status", 70, 1),
    Item("velocity_i_gain", 76, 2, 1920, *_GAIN),
    Item("velocity_p_gain", 78, 2, 100, *_GAIN),
    Item("position_d_gain", 80, 2, 0, *_GAIN),
    Item("position_i_gain", 82, 2, 0, *_GAIN),
    Item("position_p_gain", 84, 2, 800, *_GAIN),
    Item("feedforward_2nd_gain", 88, 2, 0, *_GAIN),
    Item("feedforward_1st_gain", 90, 2, 0, *_GAIN),
    Item("bus_watchdog", 98, 1, 0, 0, 127),
    Item("goal_pwm", 100, 2, 885, *_WORD),
    Item("goal_current", 102, 2, 1193, *_WORD),
    Item("goal_velocity", 104, 4, 350, *_WORD),
    Item("profile_acceleration", 108, 4, 0, 0, 32767),
    Item("profile_velocity", 112, 4, 0, 0, 32767),
    Item("goal_position", 116, 4, 0, -_MULTI_TURN, _MULTI_TURN),
    Item("realtime_tick", 120, 2),
    Item("moving", 122, 1),
    Item("moving_status", 123, 1),
    Item("present_pwm", 124, 2),
    Item("present_current", 126, 2),
    Item("present_velocity", 128, 4),
    Item("present_position", 132, 4),
    Item("velocity_trajectory", 136, 4),
    Item("position_trajectory", 140, 4),
    Item("present_input_voltage", 144, 2, 120),
    Item("present_temperature", 146, 1, 28),
    *(
        Item(f"indirect_address_{n}", address, 2, data, 64, TABLE_END - 1)
        for n, (address, data) in enumerate(INDIRECT, start=1)
    ),
    *(Item(f"indirect_data_{n}", data, 1, 0, 0, 255) for n, (_, data) in enumerate(INDIRECT, start=1)),
)
BY_NAME = {item.name: item for item in ITEMS}
_BY_ADDRESS = {item.address: item for item in ITEMS}
GOALS = ("goal_pwm", "goal_current", "goal_velocity", "goal_position")
_SIGNED = {
    *(item.name for item in ITEMS if item.low is not None and item.low < 0),
    *("bus_watchdog", "present_pwm", "present_current", "present_velocity", "present_position"),
    *("velocity_trajectory", "position_trajectory"),
}
_ADDRESS_OF_DATA = {data: address for address, data in INDIRECT}


class Memory:
    """Bytes of the control table. `limits` says what may be written beyond the table's own ranges."""

    def __init__(self, eeprom: dict[str, int], limits: Callable[[str, int], None]) -> None:
        """Fresh from power-on, with `eeprom` values instead of the factory's; `limits` may refuse a value."""
        self._bytes = bytearray(TABLE_END)
        self._values: dict[str, int] = {}
        self._limits = limits
        for item in ITEMS:
            self[item.name] = eeprom.get(item.name, item.initial)

    def __getitem__(self, name: str) -> int:
        """A register's value."""
        return self._values[name]

    def __setitem__(self, name: str, value: int) -> None:
        """Set a register from inside the servo, past all rules; a value too large wraps as in the servo's own memory."""
        if self._values.get(name) == value:
            return
        item = BY_NAME[name]
        data = (value % (1 << 8 * item.size)).to_bytes(item.size, "little")
        self._bytes[item.address : item.address + item.size] = data
        self._values[name] = _value(item, data)

    def forget_ram(self) -> None:
        """What a restart leaves: EEPROM stays, RAM is as from the factory."""
        for item in ITEMS:
            if item.address >= EEPROM_END:
                self[item.name] = item.initial

    def read(self, address: int, size: int) -> bytes:
        """What a controller reads; raises InstructionRefusedError outside the table."""
        if size < 1 or address + size > TABLE_END:
            raise InstructionRefusedError(ACCESS_ERROR if size else LENGTH_ERROR)
        return bytes(self._bytes[self._target(place)] for place in range(address, address + size))

    def check_write(self, address: int, data: bytes) -> list[tuple[Item, int]]:
        """The registers and values that a controller's write means; raises InstructionRefusedError, nothing written."""
        if not data:
            raise InstructionRefusedError(LENGTH_ERROR)
        changes = []
        while data:
            item = _BY_ADDRESS.get(self._target(address))
            if item is None or item.low is None or (item.address < EEPROM_END and self["torque_enable"]):
                raise InstructionRefusedError(ACCESS_ERROR)
            if len(data) < item.size:
                raise InstructionRefusedError(LENGTH_ERROR)
            value = _value(item, data[: item.size])
            if not item.low <= value <= item.high:
                raise InstructionRefusedError(RANGE_ERROR)
            self._limits(item.name, value)
            changes.append((item, value))
            address, data = address + item.size, data[item.size :]
        return changes

    def _target(self, place: int) -> int:
        word = _ADDRESS_OF_DATA.get(place)
        return place if word is None else self._bytes[word] | self._bytes[word + 1] << 8


def _value(item: Item, data: bytes) -> int:
    return int.from_bytes(data, "little", signed=item.name in _SIGNED)
