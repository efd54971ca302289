"""Recorded messages as an Arrow table, one row a message; `.to_pandas()` makes a DataFrame of it."""

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from messaging.checked import FloatArray
from messaging.errors import NodalError
from messaging.topics import Topic
from messaging.views import View
from recordings.errors import UnknownTopicError
from recordings.reader import Recorded

if TYPE_CHECKING:
    import pyarrow as pa


def table_of(topic: Topic, recorded: Iterable[Recorded]) -> "pa.Table":
    """Columns `log_time` and `publish_time` (UTC, ns), `log_sequence`, `topic`, and each field of the messages.

    Arrays become nested lists, as long as they are in each message. What viewers draw is one column `json`. Messages of
    another type than this version has for the topic are left out. Raises NodalError without pyarrow, CodecError,
    InvalidMessageError.
    """
    try:
        import pyarrow as pa  # noqa: PLC0415  part of an extra
    except ImportError as error:
        raise NodalError("tables need pyarrow; install nodal with its extra `export`") from error
    time = pa.timestamp("ns", tz="UTC")
    schema = pa.schema(
        {
            "log_time": time,
            "publish_time": time,
            "log_sequence": pa.int64(),
            "topic": pa.string(),
            **_kinds(pa, topic),
        }
    )
    columns: list[list[Any]] = [[] for _ in schema]
    for one in recorded:
        try:
            message = one.message
        except UnknownTopicError:
            continue
        head = (one.log_time_ns, one.publish_time_ns, one.sequence, one.topic)
        for column, value in zip(columns, (*head, *_values(message)), strict=True):
            column.append(value)
    return pa.table(
        [pa.array(column, kind) for column, kind in zip(columns, schema.types, strict=True)], schema=schema
    )


def _kinds(pa: Any, topic: Topic) -> dict[str, Any]:
    if issubclass(topic.type, View):
        return {"json": pa.string()}
    plain: dict[Any, Any] = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), bytes: pa.binary()}
    kinds = {}
    for field in dataclasses.fields(topic.type):
        kind = plain.get(field.type, pa.string())
        if shape := field.metadata.get("shape"):
            kind = pa.float64() if field.type is FloatArray else pa.string()
            for _ in shape:
                kind = pa.list_(kind)
        kinds[field.name] = kind
    return kinds


def _values(message: Any) -> list[Any]:
    if isinstance(message, View):
        from google.protobuf.json_format import MessageToJson  # noqa: PLC0415  seldom wanted

        return [MessageToJson(message.wire, indent=None, preserving_proto_field_name=True)]
    values = (getattr(message, field.name) for field in dataclasses.fields(message))
    return [value.tolist() if hasattr(value, "tolist") else value for value in values]
