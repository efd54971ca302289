"""The base of every message: checked fields and protobuf bytes.

The protobuf message carries the fields of the dataclass by the same names, arrays flattened in C order. The declared
shapes let the receiver give arrays their form back, so a payload that does not add up is refused rather than guessed at.
"""

import dataclasses
import math
from enum import StrEnum
from typing import Any, ClassVar, Self

import numpy as np
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage

from messaging.checked import Checked, FloatArray, Shape, fields_of
from messaging.errors import CodecError


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Message(Checked):
    """A message of the bench. Subclasses name the protobuf class that carries them in `protobuf`."""

    protobuf: ClassVar[type[ProtobufMessage]]

    def to_bytes(self) -> bytes:
        """The protobuf bytes that go on the wire and, unchanged, into the log."""
        wire = self.protobuf()
        for field in fields_of(type(self)):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                getattr(wire, field.name).extend(value.ravel())
            elif isinstance(value, tuple):
                getattr(wire, field.name).extend(value)
            else:
                setattr(wire, field.name, value)
        return wire.SerializeToString(deterministic=True)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """The message in these protobuf bytes; raises CodecError or InvalidMessageError."""
        wire = parse(cls.protobuf, data)
        values: dict[str, Any] = {}
        sizes: dict[str, int] = {}
        for field in fields_of(cls):
            value = getattr(wire, field.name)
            if field.type is FloatArray:
                numbers = np.fromiter(value, np.float64, len(value))
                value = numbers.reshape(
                    cls._solve_shape(field.name, numbers.size, field.metadata["shape"], sizes)
                )
            elif shape := field.metadata.get("shape"):
                value = tuple(value)
                sizes[shape[0]] = len(value)
            elif isinstance(field.type, type) and issubclass(field.type, StrEnum):
                value = cls._member(field.name, field.type, value)
            values[field.name] = value
        return cls(**values)

    @classmethod
    def _solve_shape(cls, name: str, count: int, shape: Shape, sizes: dict[str, int]) -> tuple[int, ...]:
        known = [size if isinstance(size, int) else sizes.get(size) for size in shape]
        product = math.prod(size for size in known if size is not None)
        unknown = [word for word, size in zip(shape, known, strict=True) if size is None]
        if len(unknown) == 1 and product and count % product == 0:
            sizes[str(unknown[0])] = count // product
        elif unknown or count != product:
            raise CodecError(
                f"{cls.__name__}.{name} carries {count} numbers, which do not fill the shape {shape}"
            )
        return tuple(size if isinstance(size, int) else sizes[size] for size in shape)

    @classmethod
    def _member(cls, name: str, kind: type[StrEnum], value: str) -> StrEnum:
        try:
            return kind(value)
        except ValueError as error:
            raise CodecError(f"{cls.__name__}.{name} is {value!r}; known are {', '.join(kind)}") from error


def parse(protobuf: type[ProtobufMessage], data: bytes) -> Any:
    """The protobuf message in these bytes; raises CodecError."""
    wire = protobuf()
    try:
        wire.ParseFromString(data)
    except DecodeError as error:
        raise CodecError(f"{len(data)} bytes are not a {protobuf.DESCRIPTOR.full_name}: {error}") from error
    return wire
