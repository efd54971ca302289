"""A path from a CSV file."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from messaging.control import Target
from nodal.errors import CommandError
from nodal.targets.held import weights_of

AXES = ("x", "y", "z")


def path(file: Path, weights: Mapping[str, float], *, repeat: bool) -> Target:
    """A path from a CSV file whose columns are time_s and, for each nodal point NAME, NAME.x, NAME.y and NAME.z in mm.

    Raises CommandError naming the file, line and column; InvalidMessageError when nothing could follow the path.
    """
    try:
        with file.open(newline="", encoding="utf-8") as lines:
            header, *rows = csv.reader(lines)
    except OSError as error:
        raise CommandError(f"{file}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise CommandError(f"{file}: not a CSV file with a header line: {error}") from error
    names = tuple(dict.fromkeys(column.rpartition(".")[0] for column in header[1:]))
    expected = ["time_s", *(f"{name}.{axis}" for name in names for axis in AXES)]
    if header != expected or not names:
        raise CommandError(
            f"{file}: columns are {', '.join(header)}; they must be time_s, NAME.x, NAME.y, NAME.z, ..."
        )
    table = np.array([_numbers(file, line, row, header) for line, row in enumerate(rows, start=2)])
    table = table.reshape(len(rows), len(header))
    return Target(
        name=file.stem,
        node_names=names,
        weights=weights_of(names, weights),
        time_s=table[:, 0],
        position_mm=table[:, 1:].reshape(len(rows), len(names), 3),
        repeat=repeat,
    )


def _numbers(file: Path, line: int, row: Sequence[str], header: Sequence[str]) -> list[float]:
    if len(row) != len(header):
        raise CommandError(f"{file}: line {line} has {len(row)} values; the header names {len(header)}")
    numbers = []
    for column, text in zip(header, row, strict=True):
        try:
            numbers.append(float(text))
        except ValueError as error:
            raise CommandError(f"{file}: line {line}: {column} is {text!r}, which is not a number") from error
    return numbers
