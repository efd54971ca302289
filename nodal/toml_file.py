"""TOML in, settings out, and back: every complaint names the file, the key, its value and what is allowed."""

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from nodal.errors import BenchFileError

T = TypeVar("T")
Table = dict[str, Any]
Key = tuple[str | int, ...]

COMPLAINT = re.compile(r"(?P<what>.*?)(?: - at `\$(?P<path>.*)`)?", re.DOTALL)
FIELD = re.compile(r"Object (?P<fault>missing required|contains unknown) field `(?P<field>.*)`")
STEP = re.compile(r"\.(?P<name>[^.\[]+)|\[(?P<item>\d+|\.\.\.)\]")


def read_table(path: Path) -> Table:
    """The file's tables, all numbers finite; raises BenchFileError."""
    try:
        return table_in(path.read_bytes(), str(path))
    except FileNotFoundError as error:
        raise BenchFileError(f"{path}: no such file") from error
    except OSError as error:
        raise BenchFileError(f"{path}: cannot be read: {error.strerror}") from error


def table_in(data: bytes, source: str) -> Table:
    """The tables in a TOML file's bytes, all numbers finite; raises BenchFileError, which begins with `source`."""
    try:
        table = tomllib.loads(data.decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BenchFileError(f"{source}: not TOML: {error}") from error
    for key, value in _leaves(table):
        if isinstance(value, float) and not math.isfinite(value):
            raise BenchFileError(f"{source}: {dotted(key)} = {value}: it must be a finite number")
    return table


def settings_from(table: Table, kind: type[T], source: str) -> T:
    """The table as a settings struct; raises BenchFileError for whatever the struct does not allow."""
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        raise BenchFileError(f"{source}: {_explained(error, table, kind)}") from error


def merged(table: Table, changes: Table) -> Table:
    """The table with the values of `changes` in place of its own; tables are merged, everything else is replaced."""
    return table | {
        key: merged(table[key], value)
        if isinstance(value, dict) and isinstance(table.get(key), dict)
        else value
        for key, value in changes.items()
    }


def dotted(key: Key) -> str:
    """A key as people write it: `cameras.left.port`, `sections[0].length_mm`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in key)
    return text.removeprefix(".")


def written(table: Mapping[str, Any]) -> str:
    """The table as TOML text; None means that a key is left out."""
    return "\n".join(_lines(table, ())) + "\n"


def _explained(error: msgspec.ValidationError, table: Table, kind: Any) -> str:
    complaint = COMPLAINT.fullmatch(str(error))
    what, path = (complaint["what"], complaint["path"] or "") if complaint else (str(error), "")
    key = _exact_key(path, what, table, kind)
    if field := FIELD.fullmatch(what):
        inside = f"[{dotted(key)}]" if key else "the file"
        known = ", ".join(_known_keys(kind, key))
        if field["fault"] == "missing required":
            return f"{dotted((*key, field['field']))} is missing; {inside} takes {known}"
        return f"{dotted((*key, field['field']))} is unknown; {inside} takes {known}"
    value = _at(table, key)
    shown = "" if isinstance(value, dict | list) else f" = {value!r}"
    return f"{dotted(key)}{shown}: {what[:1].lower()}{what[1:]}"


def _exact_key(path: str, what: str, table: Table, kind: Any) -> Key:
    """The place of a complaint. msgspec writes `[...]` for any key of a table; the one at fault is found by trying each."""
    key: Key = ()
    for step in STEP.finditer(path):
        if step["item"] == "...":
            key = (*key, _entry_at_fault(table, key, what, kind))
        else:
            key = (*key, step["name"] if step["name"] is not None else int(step["item"]))
    return key


def _entry_at_fault(table: Table, key: Key, what: str, kind: Any) -> str:
    entries = _at(table, key)
    for name in entries:
        try:
            # in the place of every other one, since a table may need several
            msgspec.convert(_replaced(table, key, dict.fromkeys(entries, entries[name])), kind)
        except msgspec.ValidationError as error:
            if str(error).startswith(what):
                return str(name)
    return "..."


def _known_keys(kind: Any, key: Key) -> Iterator[str]:
    """The keys that the struct at this place of the settings takes."""
    pending = [(msgspec.inspect.type_info(kind), key)]
    while pending:
        info, rest = pending.pop()
        if isinstance(info, msgspec.inspect.Metadata):
            pending.append((info.type, rest))
        elif isinstance(info, msgspec.inspect.UnionType):
            pending.extend((option, rest) for option in info.types)
        elif isinstance(info, msgspec.inspect.StructType):
            if not rest:
                yield from (field.encode_name for field in info.fields)
            pending.extend(
                (field.type, rest[1:]) for field in info.fields if (field.encode_name,) == rest[:1]
            )
        elif isinstance(info, msgspec.inspect.DictType):
            pending.append((info.value_type, rest[1:]))
        elif isinstance(info, msgspec.inspect.VarTupleType | msgspec.inspect.ListType):
            pending.append((info.item_type, rest[1:]))


def _at(table: Any, key: Key) -> Any:
    for step in key:
        table = table[step]
    return table


def _replaced(table: Any, key: Key, value: object) -> Any:
    if not key:
        return value
    changed = table.copy()
    changed[key[0]] = _replaced(table[key[0]], key[1:], value)
    return changed


def _leaves(value: Any, key: Key = ()) -> Iterator[tuple[Key, Any]]:
    if isinstance(value, dict | list):
        for step, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _leaves(inner, (*key, step))
    else:
        yield key, value


def _lines(table: Mapping[str, Any], key: tuple[str, ...]) -> Iterator[str]:
    tables = {name: value for name, value in table.items() if isinstance(value, Mapping)}
    for name, value in table.items():
        if name not in tables and value is not None:
            yield f"{_word(name)} = {_value(value)}"
    for name, value in tables.items():
        yield f"\n[{'.'.join(map(_word, (*key, name)))}]"
        yield from _lines(value, (*key, name))


def _word(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        pairs = (f"{_word(name)} = {_value(inner)}" for name, inner in value.items() if inner is not None)
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    # strings, numbers and truth values are written alike in TOML and JSON
    return json.dumps(value, ensure_ascii=False)
