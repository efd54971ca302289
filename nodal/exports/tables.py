"""From a recording to one table a topic."""

import dataclasses
from collections import Counter
from collections.abc import Iterable

import numpy as np

from messaging.checked import Checked
from messaging.errors import NodalError
from messaging.topics import TOPICS
from messaging.views import LogLine, View
from nodal.exports.columns import Column, joined
from nodal.exports.rows import columns_of, in_seconds, label_fields, layout_of, record_of, row_counts
from recordings.reader import Recorded

BLOCK = 1000
"""Messages that are turned into arrays at once: a long recording's as objects would not fit into memory."""

TABULAR = tuple(topic for topic in TOPICS if topic.logged and not issubclass(topic.type, View)) + tuple(
    topic for topic in TOPICS if topic.type is LogLine
)
"""Topics that tables are made of; the others repeat them in the schemas that viewers know."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Table:
    """The publications of one key, in order of recording; `names` are the fields whose names label the columns."""

    key: str
    columns: tuple[Column, ...]
    names: dict[str, tuple[str, ...]]

    @property
    def rows(self) -> int:
        """How many."""
        return len(self.columns[0].values)


class Tables:
    """Fills tables from publications. What cannot be read is counted in `unreadable`, by key and reason."""

    def __init__(self, beginning_ns: int) -> None:
        """Seconds are counted from this Unix time."""
        self._beginning_ns = beginning_ns
        self._builders: dict[str, _Builder] = {}
        self.unreadable: Counter[tuple[str, str]] = Counter()

    def hear(self, publications: Iterable[Recorded]) -> None:
        """Take these in."""
        for recorded in publications:
            try:
                record = record_of(recorded.message)
            except NodalError as error:
                self.unreadable[recorded.topic, str(error)] += 1
                continue
            builder = self._builders.setdefault(recorded.topic, _Builder(self._beginning_ns))
            builder.add(recorded, record)

    def finished(self) -> list[Table]:
        """One for each key that was heard of, by key."""
        return [self._builders[key].table(key) for key in sorted(self._builders)]


class _Builder:
    def __init__(self, beginning_ns: int) -> None:
        self._beginning_ns = beginning_ns
        self._layout: tuple[object, ...] = ()
        self._publications: list[Recorded] = []
        self._records: list[Checked] = []
        self._blocks: list[list[Column]] = []
        self._names: dict[str, dict[str, None]] = {}

    def add(self, recorded: Recorded, record: Checked) -> None:
        layout = layout_of(record)
        if layout != self._layout or len(self._records) == BLOCK:
            self._settle()
            self._layout = layout
        self._publications.append(recorded)
        self._records.append(record)

    def table(self, key: str) -> Table:
        self._settle()
        columns = tuple(joined(parts) for parts in zip(*self._blocks, strict=True))
        names = {field: tuple(known) for field, known in self._names.items()}
        return Table(key=key, columns=columns, names=names)

    def _settle(self) -> None:
        if not self._records:
            return
        for field in label_fields(type(self._records[0])).values():
            self._names.setdefault(field, {}).update(dict.fromkeys(getattr(self._records[0], field)))
        counts = row_counts(self._records)
        log_time, sequence = (
            Column(name=name, values=np.repeat(np.array(numbers, np.int64), counts))
            for name, numbers in (
                ("log_time_ns", [one.log_time_ns for one in self._publications]),
                ("log_sequence", [one.sequence for one in self._publications]),
            )
        )
        head = [in_seconds(log_time, self._beginning_ns), log_time, sequence]
        self._blocks.append(head + columns_of(self._records, self._beginning_ns))
        self._publications.clear()
        self._records.clear()
