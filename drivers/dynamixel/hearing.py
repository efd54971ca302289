"""What is heard in answer to one question: bytes in, the answers that belong to it out. Pure."""

from collections.abc import Sequence

from drivers.dynamixel import protocol
from drivers.dynamixel.protocol import Dropped, FastStatusPacket, Packet, PacketParser, StatusPacket


class Hearing:
    """The answers of `servos`, of `size` parameters each, as they come.

    Answers come in the order of the questions, so what comes `one_by_one` while a common answer is awaited is late, and older.
    """

    def __init__(self, servos: Sequence[int], size: int, *, one_by_one: bool) -> None:
        """Nothing was heard yet."""
        self.answers: dict[int, StatusPacket] = {}
        self.received = b""
        self.rubbish = b""
        """What belongs to no packet."""
        self._servos, self._size, self._one_by_one = servos, size, one_by_one
        longest = len(servos) * (protocol.EMPTY_STATUS_SIZE + size)
        self._parser = PacketParser(max_length=2 * longest)  # stuffing lengthens a packet by a third at most

    @property
    def complete(self) -> bool:
        """Whether all have answered."""
        return len(self.answers) == len(self._servos)

    def receive(self, data: bytes) -> None:
        """Take in some bytes."""
        self.received += data
        self._take(self._parser.receive(data))

    def end(self) -> None:
        """No more will come: what is whole of a packet that was cut short still counts."""
        self._take(self._parser.give_up_waiting())
        self._take_common(protocol.salvage_fast_status(self.received, self._size))

    def _take(self, packets: Sequence[Packet]) -> None:
        for packet in packets:
            match packet:
                case StatusPacket(id=servo, error=error, parameters=parameters):
                    if (
                        self._one_by_one
                        and servo in self._servos
                        and (error or len(parameters) == self._size)
                    ):
                        self.answers[servo] = packet
                case FastStatusPacket(raw):
                    self._take_common(raw)
                case Dropped(data):
                    self.rubbish += data

    def _take_common(self, raw: bytes) -> None:
        """The parts of a common answer, unless it answers another question."""
        parts = {part.id: part for part in protocol.split_fast_status(raw, self._size)}
        if [*parts] == [*self._servos][: len(parts)]:
            self.answers |= parts
