"""Targets as an operator asks for them: points, a circle, or a path from a file. Positions in mm in the robot frame."""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from messaging.control import Target
from nodal.errors import CommandError

CIRCLE_POINTS = 120
AXES = ("x", "y", "z")


def points(positions_mm: Mapping[str, Sequence[float]], weights: Mapping[str, float]) -> Target:
    """Named nodal points held at fixed places; a weight not given is 1. Raises InvalidMessageError, CommandError."""
    names = tuple(positions_mm)
    return Target(
        name="point",
        node_names=names,
        weights=_weights(names, weights),
        time_s=np.zeros(1),
        position_mm=np.array([[positions_mm[name] for name in names]], dtype=np.float64),
        repeat=False,
    )


def circle(
    node: str, *, radius_mm: float, period_s: float, height_mm: float, centre_mm: tuple[float, float]
) -> Target:
    """One nodal point on a level circle, again and again, from +X towards +Y; raises CommandError, InvalidMessageError."""
    if not period_s > 0:
        raise CommandError(f"a circle's period is {period_s:g} s; it must be above 0")
    time_s = np.linspace(0, period_s, CIRCLE_POINTS + 1)
    return Target(
        name="circle",
        node_names=(node,),
        weights=np.ones(1),
        time_s=time_s,
        position_mm=on_circle(
            time_s / period_s, radius_mm=radius_mm, height_mm=height_mm, centre_mm=centre_mm
        )[:, np.newaxis],
        repeat=True,
    )


def on_circle(
    turns: NDArray[np.float64],
    *,
    radius_mm: float,
    height_mm: float,
    centre_mm: tuple[float, float] = (0.0, 0.0),
) -> NDArray[np.float64]:
    """Places (N, 3) in mm after these many turns (N,) of a level circle that begins on the side of +X."""
    angle_rad = 2 * math.pi * turns
    return np.column_stack(
        [
            centre_mm[0] + radius_mm * np.cos(angle_rad),
            centre_mm[1] + radius_mm * np.sin(angle_rad),
            np.full_like(angle_rad, height_mm),
        ]
    )


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
        weights=_weights(names, weights),
        time_s=table[:, 0],
        position_mm=table[:, 1:].reshape(len(rows), len(names), 3),
        repeat=repeat,
    )


def _weights(names: Sequence[str], weights: Mapping[str, float]) -> NDArray[np.float64]:
    if unknown := sorted(set(weights) - set(names)):
        raise CommandError(
            f"weight given for {', '.join(unknown)}; the target's points are {', '.join(names)}"
        )
    return np.array([weights.get(name, 1.0) for name in names], dtype=np.float64)


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
