"""docs/bench-file.md's reference out of the settings structs: `python -m nodal.settings_reference docs/bench-file.md`.

The text above the line MARK is written by hand and kept; everything below it is made here.
"""

import ast
import importlib
import inspect
import itertools
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
from msgspec import inspect as types

from controller.laws import law_names
from nodal.bench_settings import BenchSettings

MARK = "<!-- below: python -m nodal.settings_reference -->"

BOUNDS = (("gt", "above"), ("ge", "at least"), ("lt", "below"), ("le", "at most"))
SIZES = (("min_length", "at least"), ("max_length", "at most"))


def with_reference(document: str) -> str:
    """The document with its generated part made anew."""
    written, _, _ = document.partition(MARK)
    sections = itertools.chain(_sections(BenchSettings, ""), *map(_tuning, law_names()))
    return written + MARK + "\n" + "\n".join(sections) + "\n"


def _tuning(law: str) -> Iterator[str]:
    """The settings of one law."""
    module = importlib.import_module(f"controller.laws.{law}")
    return _sections(module.Tuning, "controller.tuning")


def _sections(struct: type[msgspec.Struct], name: str) -> Iterator[str]:
    """A section for this struct, then one for each struct in it."""
    yield f"\n### {f'`[{name}]`' if name else 'Top level'}\n"
    yield inspect.cleandoc(struct.__doc__ or "") + "\n"
    yield "| key | value | default | |"
    yield "|---|---|---|---|"
    if (config := struct.__struct_config__).tag_field is not None:
        yield f"| `{config.tag_field}` | `{msgspec.json.encode(config.tag).decode()}` | **needed** | |"
    meanings = _meanings(struct)
    inner = []
    for field in msgspec.structs.fields(struct):
        info = types.type_info(field.type)
        key = f"{name}.{field.encode_name}".removeprefix(".")
        yield f"| `{field.encode_name}` | {_said(info)} | {_default(field)} | {meanings.get(field.name, '')} |"
        inner += [(key + suffix, found) for suffix, found in _structs(info)]
    for key, found in inner:
        yield from _sections(found, key)


def _structs(info: Any) -> Iterator[tuple[str, type[msgspec.Struct]]]:
    """The structs in a type, with what follows the key that leads to them."""
    match info:
        case types.StructType():
            yield "", info.cls
        case types.Metadata():
            yield from _structs(info.type)
        case types.UnionType():
            for option in info.types:
                yield from _structs(option)
        case types.DictType():
            yield from ((".NAME" + suffix, found) for suffix, found in _structs(info.value_type))
        case types.VarTupleType():
            yield from (("[]" + suffix, found) for suffix, found in _structs(info.item_type))


def _said(info: Any) -> str:  # noqa: C901, PLR0911  one line for each kind of type
    match info:
        case types.FloatType():
            return _with("number", _bounds(info, BOUNDS))
        case types.IntType():
            return _with("integer", _bounds(info, BOUNDS))
        case types.StrType():
            return _with("text", [f"matching `{info.pattern}`".replace("|", "\\|")] if info.pattern else [])
        case types.LiteralType():
            return " or ".join(f"`{msgspec.json.encode(value).decode()}`" for value in info.values)
        case types.VarTupleType() | types.FrozenSetType():
            return _with(
                f"list of {_said(info.item_type)}", [f"{word} long" for word in _bounds(info, SIZES)]
            )
        case types.TupleType():
            return "list: " + "; ".join(map(_said, info.item_types))
        case types.UnionType():
            said = (_said(option) for option in info.types if not isinstance(option, types.NoneType))
            return " or ".join(dict.fromkeys(said))
        case types.DictType():
            return f"table of {_said(info.value_type)}"
        case types.Metadata():
            return _said(info.type)
        case types.BoolType():
            return "`true` or `false`"
    return "table"


def _bounds(info: Any, words: tuple[tuple[str, str], ...]) -> list[str]:
    found = ((word, getattr(info, name)) for name, word in words)
    return [f"{word} {value:.10g}" for word, value in found if value is not None]


def _with(word: str, bounds: list[str]) -> str:
    return ", ".join([word, *bounds])


def _default(field: msgspec.structs.FieldInfo) -> str:
    default = field.default if field.default is not msgspec.NODEFAULT else field.default_factory
    if default is msgspec.NODEFAULT:
        return "**needed**"
    value = msgspec.to_builtins(default() if callable(default) else default)
    if isinstance(value, dict) or (isinstance(value, list | tuple) and value and isinstance(value[0], dict)):
        return "see below" if value else ""
    return "" if value is None else f"`{msgspec.json.encode(value).decode()}`"


def _meanings(struct: type[msgspec.Struct]) -> dict[str, str]:
    """What stands below each field in the source."""
    (cls,) = ast.parse(textwrap.dedent(inspect.getsource(struct))).body
    body = cls.body if isinstance(cls, ast.ClassDef) else []
    return {
        field.target.id: " ".join(text.value.value.split())
        for field, text in itertools.pairwise(body)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }


if __name__ == "__main__":
    document = Path(sys.argv[1])
    document.write_text(with_reference(document.read_text(encoding="utf-8")), encoding="utf-8")
