"""Tables as files: CSV, NPZ and Parquet."""

import csv
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from messaging.errors import NodalError
from nodal.exports.columns import Array
from nodal.exports.output import new_file, new_folder
from nodal.exports.tables import BLOCK, Table


def write_csv(tables: Sequence[Table], path: Path) -> list[str]:
    """A folder with one file a key; returns lines that say what was written. What a row lacks is left empty."""
    with new_folder(path) as folder:
        for table in tables:
            with (folder / file_name(table.key, ".csv")).open("w", newline="", encoding="utf-8") as file:
                columns = flat(table)
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(columns)
                for begin in range(0, table.rows, BLOCK):
                    block = slice(begin, begin + BLOCK)
                    writer.writerows(
                        zip(*(_cells(values[block]) for values in columns.values()), strict=True)
                    )
    return _told(tables, path, ".csv")


def write_parquet(tables: Sequence[Table], path: Path) -> list[str]:
    """A folder with one file a key, with the columns of the CSV files; raises NodalError without pyarrow."""
    try:
        import pyarrow as pa  # noqa: PLC0415  slow, and part of an extra
        from pyarrow import parquet  # noqa: PLC0415
    except ImportError as error:
        raise NodalError("Parquet needs pyarrow; install nodal with its extra `export`") from error
    with new_folder(path) as folder:
        for table in tables:
            # what a row lacks is null rather than NaN, as in any other column
            arrays = {name: pa.array(values, from_pandas=True) for name, values in flat(table).items()}
            parquet.write_table(pa.table(arrays), folder / file_name(table.key, ".parquet"))
    return _told(tables, path, ".parquet")


def write_npz(tables: Sequence[Table], path: Path) -> list[str]:
    """One file with arrays `KEY/FIELD` over rows, and the names that label them; plain NumPy reads it, without pickle."""
    arrays: dict[str, Array] = {}
    for table in tables:
        arrays |= {f"{table.key}/{column.name}": column.values for column in table.columns}
        arrays |= {f"{table.key}/{field}": np.array(names, np.str_) for field, names in table.names.items()}
    with new_file(path) as draft, draft.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    return [f"{path}: {len(arrays)} arrays of {len(tables)} topics"]


WRITERS: Mapping[str, Callable[[Sequence[Table], Path], list[str]]] = {
    "csv": write_csv,
    "npz": write_npz,
    "parquet": write_parquet,
}


def flat(table: Table) -> dict[str, Array]:
    """Every element of the table's columns as a column of its own."""
    return {name: values for column in table.columns for name, values in column.flat().items()}


def file_name(key: str, suffix: str) -> str:
    """`controller/state` -> `controller_state.csv`."""
    return key.replace("/", "_") + suffix


def _cells(values: Array) -> list[Any]:
    cells = values.astype(object)
    if values.dtype.kind == "f":
        cells[np.isnan(values)] = None
    return list(cells)


def _told(tables: Sequence[Table], path: Path, suffix: str) -> list[str]:
    return [f"{path / file_name(table.key, suffix)}: {table.rows} rows" for table in tables]
