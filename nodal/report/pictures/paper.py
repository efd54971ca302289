"""Figures for a paper: of a page's or a column's width, in type that journals can embed, in several formats."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nodal.report.pictures.style import drawing

PAGE_IN, COLUMN_IN = 7.2, 3.5
PNG_DPI = 300
RULES: dict[Any, Any] = {
    "font.size": 8,
    "axes.titlesize": 9,
    "legend.fontsize": 7.5,
    "legend.handlelength": 1.6,
    "lines.linewidth": 1.2,
    # journals ask for TrueType outlines, and an SVG of paths looks alike where our font is missing
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
}


@contextmanager
def paper(
    path: Path,
    width_in: float,
    height_in: float,
    formats: Iterable[str],
    written: list[Path],
    dpi: int = PNG_DPI,
) -> Iterator[Any]:
    """A drawing that is saved in every format when the block ends, as `path` with the format as suffix; adds to `written`."""
    with drawing(width_in, height_in, path.name) as figure:
        import matplotlib as mpl  # noqa: PLC0415  part of an extra, which `drawing` has found

        mpl.rcParams.update(RULES)
        yield figure
        for kind in formats:
            file = path.with_suffix(f".{kind}")
            # without a date, the same input gives the same bytes
            metadata = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
            figure.savefig(file, dpi=dpi, metadata=metadata)
            written.append(file)
