"""Frozen dataclasses whose arrays declare their shape: the values that the rooms hand to one another.

`array("node", 3)` declares an array: a number is a fixed size, a word is a size that every field of the same object
using that word must share. `items("node")` declares a tuple of strings counted by the same word.
"""

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from messaging.errors import InvalidMessageError

FloatArray = NDArray[np.float64]
Shape = tuple[str | int, ...]


def array(*shape: str | int) -> Any:
    """A field that holds a finite float64 array of this shape."""
    return dataclasses.field(metadata={"shape": shape})


def items(size: str) -> Any:
    """A field that holds a tuple of strings, one for each of the things that `size` counts."""
    return dataclasses.field(metadata={"shape": (size,)})


_KNOWN_FIELDS: dict[type, tuple[dataclasses.Field[Any], ...]] = {}


def fields_of(kind: type) -> tuple[dataclasses.Field[Any], ...]:
    """The fields of a dataclass, looked up once: messages are made hundreds of times a second."""
    if kind not in _KNOWN_FIELDS:
        _KNOWN_FIELDS[kind] = dataclasses.fields(kind)
    return _KNOWN_FIELDS[kind]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Checked:
    """Fields are checked once, when the object is made; arrays become read-only float64."""

    def __post_init__(self) -> None:
        """Check finiteness and shapes; raises InvalidMessageError."""
        sizes: dict[str, int] = {}
        for field in fields_of(type(self)):
            value = getattr(self, field.name)
            if shape := field.metadata.get("shape"):
                if field.type is FloatArray:
                    value = self._frozen_array(field.name, value)
                    object.__setattr__(self, field.name, value)
                self._check_shape(field.name, np.shape(value), shape, sizes)
            elif isinstance(value, float) and not math.isfinite(value):
                raise InvalidMessageError(f"{type(self).__name__}.{field.name} is {value}; it must be finite")

    def __eq__(self, other: object) -> bool:
        """Equal when every field is equal, arrays element by element."""
        if type(self) is not type(other):
            return NotImplemented
        return all(
            np.array_equal(getattr(self, field.name), getattr(other, field.name))
            for field in dataclasses.fields(self)
        )

    __hash__ = None  # type: ignore[assignment]

    def _frozen_array(self, name: str, value: object) -> FloatArray:
        try:
            frozen = np.array(value, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidMessageError(
                f"{type(self).__name__}.{name} is not an array of numbers: {error}"
            ) from error
        if not np.isfinite(frozen).all():
            raise InvalidMessageError(f"{type(self).__name__}.{name} holds a value that is not finite")
        frozen.flags.writeable = False
        return frozen

    def _check_shape(self, name: str, actual: tuple[int, ...], shape: Shape, sizes: dict[str, int]) -> None:
        expected = [size if isinstance(size, int) else sizes.get(size) for size in shape]
        if len(actual) != len(shape) or any(
            e not in (None, a) for e, a in zip(expected, actual, strict=True)
        ):
            raise InvalidMessageError(
                f"{type(self).__name__}.{name} has shape {actual}; it must be {shape}"
                + (f" with {sizes}" if sizes else "")
            )
        sizes.update({word: size for word, size in zip(shape, actual, strict=True) if isinstance(word, str)})
