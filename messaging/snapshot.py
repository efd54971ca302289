"""Values of a process as bytes and back, exactly: frozen dataclasses, enums, tuples, dicts, arrays and plain values.

A snapshot names the classes in it. It is read back without running anything that stands in it: only dataclasses and
enums of the modules that the reader allows are made, by their own constructors. Layout: MessagePack.
"""

import dataclasses
import importlib
from collections.abc import Collection
from enum import Enum
from typing import Any

import msgspec
import numpy as np

from messaging.errors import CodecError

KIND = "kind"
ARRAY, MAPPING = "array", "mapping"
NUMBERS = "fiub"
"""Kinds of NumPy types that an array may hold: floats, integers, truth values."""


def freeze(value: object) -> bytes:
    """The bytes of a value; raises CodecError naming the type of what cannot be kept."""
    return msgspec.msgpack.encode(_plain(value))


def thaw(data: bytes, packages: Collection[str]) -> Any:
    """The value in these bytes; classes may come from these top-level packages. Raises CodecError."""
    try:
        plain = msgspec.msgpack.decode(data)
    except msgspec.DecodeError as error:
        raise CodecError(f"{len(data)} bytes are not a snapshot: {error}") from error
    return _living(plain, packages)


def _plain(value: object) -> object:
    if isinstance(value, Enum):
        return {KIND: _name(type(value)), "value": value.value}
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str | bytes):
        return value
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return _kinded(value)


def _kinded(value: object) -> dict[str, object]:
    if isinstance(value, dict):
        return {KIND: MAPPING, "items": [[key, _plain(item)] for key, item in value.items()]}
    if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS:
        return {KIND: ARRAY, "type": value.dtype.str, "shape": value.shape, "data": value.tobytes()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
        return {KIND: _name(type(value)), "fields": fields}
    raise CodecError(f"a snapshot cannot keep a {type(value).__name__}: {value!r}")


def _living(plain: Any, packages: Collection[str]) -> Any:
    if isinstance(plain, list):
        return tuple(_living(item, packages) for item in plain)
    if not isinstance(plain, dict):
        return plain
    try:
        kind = plain[KIND]
        if kind == MAPPING:
            return {key: _living(item, packages) for key, item in plain["items"]}
        if kind == ARRAY:
            return _array(plain["type"], plain["shape"], plain["data"])
        known = _class(kind, packages)
        if issubclass(known, Enum):
            return known(plain["value"])
        return known(**{name: _living(item, packages) for name, item in plain["fields"].items()})
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CodecError(f"a snapshot does not fit this version: {error}") from error


def _array(type_name: str, shape: list[int], data: bytes) -> Any:
    kind = np.dtype(type_name)
    if kind.kind not in NUMBERS:
        raise ValueError(f"arrays of {type_name} are not kept")
    values = np.frombuffer(data, kind).reshape(shape)
    values.flags.writeable = False
    return values


def _name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _class(name: str, packages: Collection[str]) -> type[Any]:
    module, _, qualified = name.partition(":")
    if module.partition(".")[0] not in packages:
        raise ValueError(f"it holds a {name}; allowed are classes of {', '.join(packages)}")
    try:
        found = getattr(importlib.import_module(module), qualified)
    except ImportError as error:
        raise ValueError(f"there is no {name}: {error}") from error
    if not (isinstance(found, type) and (dataclasses.is_dataclass(found) or issubclass(found, Enum))):
        raise ValueError(f"{name} is neither a dataclass nor an enum")
    return found
