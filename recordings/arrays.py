"""Fields of recorded messages as NumPy arrays, one row a message."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields as dataclass_fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from messaging.message import Message
from messaging.topics import Topic
from messaging.views import View
from recordings.errors import FieldError, UnknownTopicError
from recordings.reader import Recorded

Arrays = dict[str, NDArray[Any]]


def arrays_of(
    path: Path,
    topic: Topic,
    fields: Sequence[str],
    recorded: Iterable[Recorded],
    select: Callable[[Any], bool] | None = None,
) -> Arrays:
    """The fields by name, and with them `log_time_ns`, `publish_time_ns`, `log_sequence` and, for a topic of several
    cameras, `topic`; all as long as there are messages for which `select` is true (None: all that this version can read).

    A field that has another shape in some messages (nodal points were renamed, a shape was refused) is never filled up:
    that raises FieldError, which says when, and `select` decides. FieldError is raised for an unknown field too, and
    CodecError or InvalidMessageError for a message that cannot be decoded.
    """
    known = field_names(topic)
    if unknown := [name for name in fields if name not in known]:
        raise FieldError(path, f"topic {topic.key!r} has no field {unknown[0]!r}; it has {', '.join(known)}")
    heads: list[tuple[int, int, int]] = []
    keys: list[str] = []
    columns: dict[str, list[Any]] = {name: [] for name in fields}
    for one in recorded:
        try:
            message = one.message
        except UnknownTopicError:
            continue
        if select is None or select(message):
            heads.append((one.log_time_ns, one.publish_time_ns, one.sequence))
            keys.append(one.topic)
            for name, values in columns.items():
                values.append(field_of(message, name))
    times = np.array(heads, np.int64).reshape(-1, 3)
    arrays: Arrays = {"log_time_ns": times[:, 0], "publish_time_ns": times[:, 1], "log_sequence": times[:, 2]}
    if "*" in topic.key:
        arrays["topic"] = np.array(keys, np.str_)
    return arrays | {name: _stacked(path, topic, name, values) for name, values in columns.items()}


def field_names(topic: Topic) -> list[str]:
    """The fields of the topic's messages; of a viewer's schema, those of its protobuf message."""
    if issubclass(topic.type, View):
        return [field.name for field in topic.type.protobuf.DESCRIPTOR.fields]
    return [field.name for field in dataclass_fields(topic.type)]


def field_of(message: Message, name: str) -> Any:
    """A field's value by the name that `field_names` gives it."""
    return getattr(message.wire if isinstance(message, View) else message, name)


def _stacked(path: Path, topic: Topic, name: str, values: list[Any]) -> NDArray[Any]:
    if values and not isinstance(values[0], str | int | float | tuple | np.ndarray):
        # bytes would lose zeros at their end, and what else there is has no form
        stacked = np.empty(len(values), object)
        stacked[:] = values
        return stacked
    shapes = Counter(np.shape(value) for value in values)
    if len(shapes) > 1:
        usual = shapes.most_common(1)[0][0]
        other = next(number for number, value in enumerate(values) if np.shape(value) != usual)
        counted = ", ".join(f"{shape} in {count}" for shape, count in shapes.most_common())
        raise FieldError(
            path,
            f"{topic.key} {name} does not have one shape in all {len(values)} messages: {counted}; "
            f"message {other} is the first of another; choose with select=",
        )
    return np.array(values)
