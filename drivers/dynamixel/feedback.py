"""What is read from every servo in each cycle, gathered into one block by the servo's indirect addresses.

Scattered registers - torque, hardware error, watchdog, current, velocity, position, voltage, temperature - appear side by
side, so that one exchange of SIZE bytes a servo tells everything the controller must know. Status Return Level stands in
front because it is known, and not 0: a servo that restarted, by a dip of its supply, has forgotten its indirect addresses
and shows zeros there, which must not be taken for readings.
"""

import dataclasses
import struct

from drivers.dynamixel import control_table as table

ANSWER_EVERYTHING = 2
"""The Status Return Level that the driver sets."""

_REGISTERS = (
    table.STATUS_RETURN_LEVEL,
    table.TORQUE_ENABLE,
    table.HARDWARE_ERROR_STATUS,
    table.BUS_WATCHDOG,
    table.PRESENT_CURRENT,
    table.PRESENT_VELOCITY,
    table.PRESENT_POSITION,
    table.PRESENT_INPUT_VOLTAGE,
    table.PRESENT_TEMPERATURE,
)
_LAYOUT = struct.Struct("<B?BbhiiHB")
SIZE = _LAYOUT.size

INDIRECT_ADDRESSES = b"".join(
    (register.address + offset).to_bytes(2, "little")
    for register in _REGISTERS
    for offset in range(register.size)
)
"""To be written from INDIRECT_ADDRESS_1; the block then stands at the model's `indirect_data_1`."""


@dataclasses.dataclass(frozen=True, slots=True)
class Feedback:
    """One servo's block, in the servo's own units."""

    status_return_level: int
    torque: bool
    hardware_error: int
    watchdog: int
    current: int
    velocity: int
    position: int
    voltage: int
    temperature: int

    @property
    def is_genuine(self) -> bool:
        """False when the servo has restarted since it was configured: nothing in the block means anything."""
        return self.status_return_level == ANSWER_EVERYTHING


def decode(block: bytes) -> Feedback:
    """Take the SIZE bytes of the block apart."""
    return Feedback(*_LAYOUT.unpack(block))
