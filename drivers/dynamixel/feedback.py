"""What is read from every servo in each cycle, gathered into one block by the servo's indirect addresses.

Scattered registers - torque, hardware error, watchdog, current, velocity, position, voltage, temperature - appear side by
side, so that one exchange of 16 bytes a servo tells everything the controller must know.
"""

import dataclasses
import struct

from drivers.dynamixel import control_table as table

_REGISTERS = (
    table.TORQUE_ENABLE,
    table.HARDWARE_ERROR_STATUS,
    table.BUS_WATCHDOG,
    table.PRESENT_CURRENT,
    table.PRESENT_VELOCITY,
    table.PRESENT_POSITION,
    table.PRESENT_INPUT_VOLTAGE,
    table.PRESENT_TEMPERATURE,
)
_LAYOUT = struct.Struct("<?BbhiiHB")
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

    torque: bool
    hardware_error: int
    watchdog: int
    current: int
    velocity: int
    position: int
    voltage: int
    temperature: int


def decode(block: bytes) -> Feedback:
    """Take the SIZE bytes of the block apart."""
    return Feedback(*_LAYOUT.unpack(block))
