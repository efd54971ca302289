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
"""How long a ping is waited for; what an adapter delivers later is heard with the next one, for answers name their servo."""
LISTEN_S = 0.02
"""How long one servo is listened to, so that a second one with its id is heard after it."""
LOOKS = 3
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


def _heard(bus: DynamixelBus, ids: Sequence[int]) -> set[int]:
    """Ids that answered, and those whose ping was followed by rubbish."""
    heard = set()
    for servo in ids:
        for packet in bus.overhear(protocol.ping(servo), ANSWER_S):
            if isinstance(packet, StatusPacket):
                heard.add(packet.id)
            elif isinstance(packet, Dropped):
                heard.add(servo)
    return heard


def _look_at(bus: DynamixelBus, servo: int, rate: int) -> FoundServo | None:
    """None when nobody is there after all: what was heard was noise."""
    garbled = FoundServo(id=servo, baud_rate=rate, identity=None, readings={})
    pings = [bus.overhear(protocol.ping(servo), LISTEN_S) for _ in range(LOOKS)]
    if not any(pings):
        return None
    blocks = [bus.overhear(protocol.read(servo, *_LIVE_BLOCK), LISTEN_S) for _ in range(LOOKS)]
    if not (any(map(_clean, pings)) and any(map(_clean, blocks))):
        return garbled
    return FoundServo(
        id=servo,
        baud_rate=rate,
        identity=bus.ping(servo),
        readings={register: bus.read(servo, register) for register in READINGS},
    )


def _clean(packets: Sequence[protocol.Packet]) -> bool:
    """One answer, and nothing else."""
    return len(packets) == 1 and isinstance(packets[0], StatusPacket)
