"""What a replay found: message by message, field by field, how much was the same and where it was not. Pure.

A message is the same when every bit of its fields is, but for those that only tell how long something took (`IGNORED`). Counts of parts of a log, or of many logs, add up.
"""

from typing import Any

import msgspec
import numpy as np

from messaging.checked import fields_of
from messaging.control import ControllerState, TendonCommand
from messaging.message import Message
from messaging.shape import ShapeEstimate

IGNORED: dict[type[Message], tuple[str, ...]] = {
    ShapeEstimate: ("capture_to_publish_ns", "stage_s"),
    TendonCommand: ("capture_to_command_ns",),
    ControllerState: ("lateness_s", "busy_s", "overruns"),
}
"""Fields that a clock fills in while the bench runs."""

LONGEST_SHOWN = 160


class Difference(msgspec.Struct, frozen=True, kw_only=True):
    """How one field differs: how often, by how much at most (None: not in numbers), and where it did first."""

    count: int
    largest: float | None
    first_time_ns: int
    first_logged: str
    first_replayed: str

    def __add__(self, later: "Difference") -> "Difference":
        """Both; the other one's came later in the log."""
        return msgspec.structs.replace(
            self,
            count=self.count + later.count,
            largest=max(
                (value for value in (self.largest, later.largest) if value is not None), default=None
            ),
        )


class Tally(msgspec.Struct, frozen=True, kw_only=True):
    """One topic: messages that were compared, those that differ, and the differences by field."""

    compared: int
    different: int
    fields: dict[str, Difference]

    def __add__(self, later: "Tally") -> "Tally":
        """Both."""
        fields = dict(self.fields)
        for name, difference in later.fields.items():
            fields[name] = fields[name] + difference if name in fields else difference
        return Tally(
            compared=self.compared + later.compared,
            different=self.different + later.different,
            fields=fields,
        )


class Comparison(msgspec.Struct, frozen=True, kw_only=True):
    """Tallies by topic, and by topic and reason how many messages could not be replayed."""

    topics: dict[str, Tally] = {}
    skipped: dict[str, dict[str, int]] = {}

    @property
    def compared(self) -> int:
        """Messages that were compared."""
        return sum(tally.compared for tally in self.topics.values())

    @property
    def different(self) -> int:
        """Messages that differ."""
        return sum(tally.different for tally in self.topics.values())

    def __add__(self, later: "Comparison") -> "Comparison":
        """Both; the other one's came later in the log, or from a later log."""
        topics = dict(self.topics)
        for key, tally in later.topics.items():
            topics[key] = topics[key] + tally if key in topics else tally
        skipped = {key: dict(reasons) for key, reasons in self.skipped.items()}
        for key, reasons in later.skipped.items():
            mine = skipped.setdefault(key, {})
            for reason, count in reasons.items():
                mine[reason] = mine.get(reason, 0) + count
        return Comparison(topics=topics, skipped=skipped)


def compared(key: str, time_ns: int, logged: Message, replayed: Message) -> Comparison:
    """One message of this topic against its replay, field by field and bit by bit."""
    ignored = IGNORED.get(type(logged), ())
    fields = {}
    for field in fields_of(type(logged)):
        pair = getattr(logged, field.name), getattr(replayed, field.name)
        if field.name not in ignored and _bits(pair[0]) != _bits(pair[1]):
            fields[field.name] = _difference(*pair, time_ns)
    return _one(key, fields)


def compared_bytes(key: str, time_ns: int, logged: bytes, replayed: bytes) -> Comparison:
    """The same for what has no fields of its own."""
    return _one(key, {} if logged == replayed else {"content": _difference(logged, replayed, time_ns)})


def skipped(key: str, reason: str) -> Comparison:
    """One message of this topic that could not be replayed."""
    return Comparison(skipped={key: {reason: 1}})


def _one(key: str, fields: dict[str, Difference]) -> Comparison:
    return Comparison(topics={key: Tally(compared=1, different=int(bool(fields)), fields=fields)})


def _bits(value: Any) -> Any:
    if isinstance(value, float | np.ndarray):
        return np.shape(value), np.asarray(value).tobytes()
    return value


def _difference(logged: Any, replayed: Any, time_ns: int) -> Difference:
    largest = None
    if isinstance(logged, int | float | np.ndarray) and np.shape(logged) == np.shape(replayed):
        gap = np.asarray(logged, np.float64) - np.asarray(replayed, np.float64)
        largest = float(np.abs(gap).max(initial=0))
    return Difference(
        count=1,
        largest=largest,
        first_time_ns=time_ns,
        first_logged=_shown(logged),
        first_replayed=_shown(replayed),
    )


def _shown(value: object) -> str:
    text = f"{len(value)} bytes" if isinstance(value, bytes) else " ".join(str(value).split())
    return text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 1] + "…"
