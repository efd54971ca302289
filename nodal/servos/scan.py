"""Who answers on a servo bus, and whether each is alone with its id."""

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence

from drivers.dynamixel import control_table as table
from drivers.dynamixel import protocol
from drivers.dynamixel.bus import DynamixelBus, Identity
from drivers.dynamixel.control_table import MODELS, Register
from drivers.dynamixel.protocol import Dropped, StatusPacket
from nodal.servos.port import Buses

EVERY_ID = range(protocol.MAX_ID + 1)
READINGS = (
    table.OPERATING_MODE,
    table.TORQUE_ENABLE,
    table.HARDWARE_ERROR_STATUS,
    table.BUS_WATCHDOG,
    table.PRESENT_POSITION,
    table.PRESENT_INPUT_VOLTAGE,
    table.PRESENT_TEMPERATURE,
)

ANSWER_S = 0.003
"""How long a ping is waited for when many ids are asked; what an adapter delivers later is heard with the next one, for
answers name their servo."""
LISTEN_S = 0.03
"""How long one of a few is listened to: a loaded computer is late too, and a second servo with its id is heard after it."""
FEW, LOOKS = 16, 3
_LIVE_BLOCK = (
    table.REALTIME_TICK.address,
    table.PRESENT_TEMPERATURE.address + 1 - table.REALTIME_TICK.address,
)
"""Registers in which no two servos agree for long: their clocks, positions and voltages."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class FoundServo:
    """Somebody who answers to `id` at `baud_rate`; when it is not alone with that id, nothing more is known."""

    id: int
    baud_rate: int
    identity: Identity | None
    readings: Mapping[Register, int]

    @property
    def alone(self) -> bool:
        """False when several servos answer to this id, or something else garbles all that they say."""
        return self.identity is not None

    @property
    def model_name(self) -> str:
        """What ROBOTIS calls it, or its number."""
        if self.identity is None:
            return "?"
        model = MODELS.get(self.identity.model_number)
        return model.name if model else f"model {self.identity.model_number}"


def scan(buses: Buses, rates: Iterable[int], ids: Sequence[int]) -> Iterator[FoundServo]:
    """Everybody who answers a ping, rate by rate; raises PortError."""
    for rate in rates:
        with buses(rate) as bus:
            for servo in sorted(_heard(bus, ids)):
                found = _look_at(bus, servo, rate)
                if found is not None:
                    yield found


def find(buses: Buses, rates: Sequence[int], ids: Sequence[int]) -> list[FoundServo]:
    """Like `scan`, and once more for those that were not heard: an answer may be lost, or a loaded computer miss it."""
    found = list(scan(buses, rates, ids))
    missing = sorted(set(ids) - {servo.id for servo in found})
    return found + list(scan(buses, rates, missing) if missing else ())


def _heard(bus: DynamixelBus, ids: Sequence[int]) -> set[int]:
    """Ids that answered, and those whose ping was followed by rubbish."""
    heard = set()
    wait_s = LISTEN_S if len(ids) <= FEW else ANSWER_S
    for servo in ids:
        for packet in bus.overhear(protocol.ping(servo), wait_s):
            if isinstance(packet, StatusPacket):
                heard.add(packet.id)
            elif isinstance(packet, Dropped):
                heard.add(servo)
    return heard


def _look_at(bus: DynamixelBus, servo: int, rate: int) -> FoundServo | None:
    """None when nobody is there after all: what was heard was noise."""
    clean = _answers_cleanly(bus, protocol.ping(servo))
    if clean is None:
        return None
    if not (clean and _answers_cleanly(bus, protocol.read(servo, *_LIVE_BLOCK))):
        return FoundServo(id=servo, baud_rate=rate, identity=None, readings={})
    return FoundServo(
        id=servo,
        baud_rate=rate,
        identity=bus.ping(servo),
        readings={register: bus.read(servo, register) for register in READINGS},
    )


def _answers_cleanly(bus: DynamixelBus, instruction: protocol.Instruction) -> bool | None:
    """Whether one of a few attempts was followed by one answer and nothing else; None when nothing came at all."""
    silent = True
    for _ in range(LOOKS):
        packets = bus.overhear(instruction, LISTEN_S)
        if len(packets) == 1 and isinstance(packets[0], StatusPacket):
            return True
        silent = silent and not packets
    return None if silent else False
