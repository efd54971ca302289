"""Columns whose elements have names: an array over rows, with a label for every place along its further axes. Pure."""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Labels = tuple[str, ...]
Array = NDArray[Any]

AXES: Labels = ("x", "y", "z")


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """`values` (rows, *sizes), and for each size as many labels."""

    name: str
    values: Array
    labels: tuple[Labels, ...] = ()

    def flat(self) -> dict[str, Array]:
        """One array (rows,) for each element: `node_mm.tip.x`, `node_covariance_mm2.tip.xy`, `log_time_s`."""
        words = list(itertools.product(*self.labels))
        elements = self.values.reshape(len(self.values), len(words)).T
        return dict(zip(map(self._element, words), elements, strict=True))

    def _element(self, words: Labels) -> str:
        if self.labels[-2:] == (AXES, AXES):
            words = (*words[:-2], "".join(words[-2:]))
        return ".".join((self.name, *words))


def joined(parts: Sequence[Column]) -> Column:
    """One column of parts that follow one another; a label that a part lacks is empty (NaN) in its rows.

    Labels stand in the order in which they first appear.
    """
    axes = zip(*(part.labels for part in parts), strict=True)
    labels = tuple(tuple(dict.fromkeys(itertools.chain.from_iterable(along))) for along in axes)
    if all(part.labels == labels for part in parts):
        values = np.concatenate([part.values for part in parts])
        return Column(name=parts[0].name, values=values, labels=labels)
    rows = sum(len(part.values) for part in parts)
    values = np.full((rows, *(len(along) for along in labels)), np.nan)
    begin = 0
    for part in parts:
        end = begin + len(part.values)
        places = [
            [along.index(label) for label in own] for along, own in zip(labels, part.labels, strict=True)
        ]
        values[np.ix_(range(begin, end), *places)] = part.values
        begin = end
    return Column(name=parts[0].name, values=values, labels=labels)
