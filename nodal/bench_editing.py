"""Changes to a bench file that leave its comments and its order as they are."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AbstractTable

from nodal.errors import BenchFileError
from nodal.toml_file import Table, read_table, table_in
from nodal.whole_file import write_whole


def edit_bench_file(path: Path, changes: Table) -> None:
    """Put these values in place of the file's own, or add them; tables are merged, so are the tables of a list for
    which a mapping says what to change by their places; everything else is replaced.

    The old file stays beside it as `NAME~`. What the file is afterwards must still be TOML with finite numbers. Raises BenchFileError.
    """
    read_table(path)  # a file that is not a bench file is refused as everywhere
    try:
        document = tomlkit.parse(path.read_text(encoding="utf-8"))
        _merge(document, changes)
        changed = tomlkit.dumps(document).encode()
        table_in(changed, f"{path} as it would be")
        shutil.copy(path, path.with_name(path.name + "~"))
        write_whole(path, changed)
    except OSError as error:
        raise BenchFileError(f"{path}: cannot be written: {error.strerror}") from error
    except TOMLKitError as error:
        raise BenchFileError(f"{path}: cannot be changed: {error}") from error


def _merge(table: Any, changes: Mapping[str, Any]) -> None:
    for key, value in changes.items():
        if isinstance(value, Mapping) and isinstance(table.get(key), AbstractTable | dict):
            _merge(table[key], value)
        elif isinstance(value, Mapping) and isinstance(table.get(key), list):
            for place, change in value.items():
                _merge(table[key][place], change)
        elif value is None:
            table.pop(key, None)
        elif isinstance(value, Mapping):
            added = tomlkit.table()
            added.update(value)
            added.add(tomlkit.nl())  # so that the table after it stands apart
            table[key] = added
        else:
            table[key] = value
