"""Messages of one type as columns. Pure.

A message is a row, but a Target, which is one for each moment of its path. Along the axes of a column stand: for nodal
points and stages the names that the message itself gives, for places in space x, y and z, for anything else numbers, as
in `point17` and `servo1`, counted from 1.
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from google.protobuf.json_format import MessageToJson

from messaging.checked import Checked, FloatArray, fields_of
from messaging.history import Asked
from messaging.message import Message, parse
from messaging.topics import SERVICES
from messaging.views import LogLine
from nodal.exports.columns import AXES, Array, Column

ROW_WORD = "moment"
"""What an array's first axis counts when each place along it has a row of its own."""

TIME_NS, TIME_S = "time_ns", "time_s"
TEXTS = tuple[str, ...]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class LogText(Checked):
    """A line of the log: its Unix time, Foxglove's level (1 debug to 5 fatal), who said it, and what."""

    time_ns: int
    level: int
    process: str
    text: str


def record_of(message: Message) -> Checked:
    """What has fields to make columns of: the message itself, or what stands in a log line."""
    if isinstance(message, LogLine):
        wire = message.wire
        time_ns = wire.timestamp.ToNanoseconds()
        return LogText(time_ns=time_ns, level=wire.level, process=wire.name, text=wire.message)
    return message


def label_fields(kind: type[Checked]) -> dict[str, str]:
    """For each word that counts something with a name, the field that holds the names: `node` -> `node_names`."""
    counted = {
        word for field in fields_of(kind) if field.type is FloatArray for word in field.metadata["shape"]
    }
    return {
        field.metadata["shape"][0]: field.name
        for field in fields_of(kind)
        if field.type == TEXTS and field.metadata["shape"][0] in counted
    }


def layout_of(record: Checked) -> tuple[object, ...]:
    """What records must have in common for one array: the names they give, and the sizes of their arrays."""
    names = label_fields(type(record)).values()
    return tuple(
        np.shape(getattr(record, field.name))[_in_rows(field) :]
        if field.type is FloatArray
        else getattr(record, field.name)
        for field in fields_of(type(record))
        if field.type is FloatArray or field.name in names
    )


def row_counts(records: Sequence[Checked]) -> list[int]:
    """How many rows each record has."""
    first = next((field.name for field in fields_of(type(records[0])) if _in_rows(field)), None)
    return [len(getattr(record, first)) if first else 1 for record in records]


def columns_of(records: Sequence[Checked], beginning_ns: int) -> list[Column]:
    """Columns of records of one type and of one layout.

    Beside each Unix time in ns stands the same in seconds from the recording's beginning.
    """
    kind, counts = type(records[0]), row_counts(records)
    names = label_fields(kind)
    columns = []
    for field in fields_of(kind):
        if field.name in names.values():
            continue
        cells = [getattr(record, field.name) for record in records]
        if field.type is FloatArray:
            columns.append(_array_column(field, cells, counts, names, records[0]))
            continue
        name, values = _plain_column(field, cells, records)
        columns.append(Column(name=name, values=np.repeat(values, counts, axis=0)))
        if name.endswith(TIME_NS):
            columns.append(in_seconds(columns[-1], beginning_ns))
    return columns


def in_seconds(column: Column, beginning_ns: int) -> Column:
    """A column of Unix times in ns, in seconds from the beginning."""
    name = column.name.removesuffix(TIME_NS) + TIME_S
    return Column(name=name, values=(column.values - beginning_ns) / 1e9)


def _array_column(
    field: dataclasses.Field[Any],
    cells: list[Array],
    counts: list[int],
    names: dict[str, str],
    first: Checked,
) -> Column:
    in_rows = _in_rows(field)
    values = np.concatenate(cells) if in_rows else np.repeat(np.array(cells), counts, axis=0)
    labels = []
    for word, size in zip(field.metadata["shape"][in_rows:], values.shape[1:], strict=True):
        if word in names:
            labels.append(getattr(first, names[word]))
        elif word == len(AXES):
            labels.append(AXES)
        else:
            labels.append(tuple(f"{word}{number}" for number in range(1, size + 1)))
    return Column(name=field.name, values=values, labels=tuple(labels))


def _plain_column(
    field: dataclasses.Field[Any], cells: list[Any], records: Sequence[Checked]
) -> tuple[str, Array]:
    if isinstance(records[0], Asked) and field.name == "request":
        return field.name, np.array([_request_text(record) for record in records], np.str_)
    convert: dict[Any, tuple[str, Callable[[Any], Any], Any]] = {
        int: ("", int, np.int64),
        float: ("", float, np.float64),
        bool: ("", bool, np.bool_),
        bytes: ("_bytes", len, np.int64),
        TEXTS: ("", " ".join, np.str_),
    }
    suffix, function, kind = convert.get(field.type, ("", str, np.str_))
    return field.name + suffix, np.array([function(cell) for cell in cells], kind)


def _request_text(record: Any) -> str:
    request = next((service.request for service in SERVICES if service.key == record.service), None)
    if request is None:
        return f"{len(record.request)} bytes"
    wire = parse(request.protobuf, record.request)
    return MessageToJson(wire, preserving_proto_field_name=True, indent=None)


def _in_rows(field: dataclasses.Field[Any]) -> bool:
    return field.type is FloatArray and field.metadata["shape"][0] == ROW_WORD
