"""docs/messages.md out of the table of topics and the message types: `python -m nodal.message_reference > docs/messages.md`."""

import dataclasses
import inspect
from collections.abc import Iterable, Iterator

from messaging.checked import FloatArray
from messaging.message import Message
from messaging.topics import SERVICES, SIGNALS, TOPICS
from messaging.views import View

HEADER = """# Messages

Made from the table of topics (`messaging/topics.py`) by `python -m nodal.message_reference`; a test keeps it in step.
Keys stand below `nodal/<bench name>/`; `*` is a camera's name. The bytes on the wire are protobuf
(`messaging/proto/nodal.proto`, and Foxglove's schemas), and the same bytes stand in the recording.
Lengths are in mm, angles in rad, times in ns on the wire where a name ends in `_ns` and in s where it ends in `_s`;
arrays travel flattened in C order. What is dropped on its way is counted by the gap in its sequence numbers.
"""


def reference() -> str:
    """The whole text."""
    return "\n".join((HEADER, *_topics(), *_services(), *_signals(), *_types())) + "\n"


def _topics() -> Iterator[str]:
    yield "## Topics\n"
    yield "| key | type | said by | rate, Hz | stale after, s | logged | what |"
    yield "|---|---|---|---|---|---|---|"
    for topic in TOPICS:
        rate = "now and then" if topic.rate_hz is None else f"{topic.rate_hz:g}"
        stale = "" if topic.maximum_age_s is None else f"{topic.maximum_age_s:g}"
        logged = "yes" if topic.logged else "no"
        yield (
            f"| `{topic.key}` | {_link(topic.type)} | {topic.said_by} | {rate} | {stale} | "
            f"{logged} | {topic.meaning} |"
        )


def _services() -> Iterator[str]:
    yield "\n## Services\n"
    yield "Queries that are answered with a `Reply`.\n"
    yield "| key | request | answered by | what |"
    yield "|---|---|---|---|"
    for service in SERVICES:
        yield (f"| `{service.key}` | {_link(service.request)} | {service.answered_by} | {service.meaning} |")


def _signals() -> Iterator[str]:
    yield "\n## Signals\n"
    yield "Plain keys: any publication counts, whatever it holds. `zenoh put` or a button box can give one.\n"
    yield "| key | said by | what |"
    yield "|---|---|---|"
    for signal in SIGNALS:
        yield f"| `{signal.key}` | {signal.said_by} | {signal.meaning} |"


def _types() -> Iterator[str]:
    yield "\n## Types"
    kinds = (*(topic.type for topic in TOPICS), *(service.request for service in SERVICES), SERVICES[0].reply)
    for kind in dict.fromkeys(kinds):
        yield f"\n### {kind.__name__}\n"
        yield f"`{kind.protobuf.DESCRIPTOR.full_name}`: {inspect.cleandoc(kind.__doc__ or '')}\n"
        if not issubclass(kind, View):
            yield "| field | type | shape |"
            yield "|---|---|---|"
            yield from _fields(kind)


def _fields(kind: type[Message]) -> Iterable[str]:
    for field in dataclasses.fields(kind):
        shape = ", ".join(str(size) for size in field.metadata.get("shape", ()))
        yield f"| `{field.name}` | {_type_name(field)} | {f'({shape})' if shape else ''} |"


def _type_name(field: dataclasses.Field[object]) -> str:
    if "shape" not in field.metadata:
        return field.type if isinstance(field.type, str) else getattr(field.type, "__name__", str(field.type))
    return "float64" if field.type is FloatArray else "texts"


def _link(kind: type[Message]) -> str:
    return f"[{kind.__name__}](#{kind.__name__.lower()})"


if __name__ == "__main__":
    print(reference(), end="")
