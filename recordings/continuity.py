"""How many publications a damaged stretch took, as far as the sequence numbers on both its sides tell."""

from dataclasses import dataclass, field

from recordings.damage import Damage
from recordings.streams import Streams

NUMBERS = 2**32
"""Sequence numbers of MCAP begin anew after so many."""


@dataclass
class Numbers:
    """The first and the last sequence number of each channel in a chunk."""

    first: dict[int, int] = field(default_factory=dict)
    last: dict[int, int] = field(default_factory=dict)


class Continuity:
    """Hears the chunks of a file in order; fills `missing` of the damage between them."""

    def __init__(self, streams: Streams) -> None:
        self._streams = streams
        self._last: dict[int, int] = {}
        self._broken: dict[int, tuple[Damage, int]] = {}

    def breaks(self, damage: Damage) -> None:
        """Something is missing here."""
        for channel, sequence in self._last.items():
            self._broken.setdefault(channel, (damage, sequence))

    def hear(self, numbers: Numbers) -> None:
        """The next chunk that could be read."""
        for channel in self._broken.keys() & numbers.first.keys():
            damage, before = self._broken.pop(channel)
            missing = (numbers.first[channel] - before - 1) % NUMBERS
            stream = self._streams.of(channel)
            # numbers that fall back began anew, with a new life of the publisher
            if 0 < missing < NUMBERS // 2 and stream is not None:
                damage.missing[stream.topic] = missing
        self._last |= numbers.last
