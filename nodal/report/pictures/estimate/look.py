"""What the pictures of an estimate have in common: how they are saved, their heading and caption, halos."""

import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nodal.report.pictures.paper import paper
from nodal.report.pictures.style import DESIRED, INK, NODE

FORMATS = ("png", "pdf")
DPI = 200
LETTERS_PER_IN = 17.8
HEADING_PT, CAPTION_PT, SMALL_PT = 8.5, 7, 6.5
SEEN, HALO = "#58c8ff", "white"


@contextmanager
def page(path: Path, width_in: float, height_in: float, written: list[Path]) -> Iterator[Any]:
    """A figure with small type, saved as PNG and PDF."""
    with paper(path, width_in, height_in, FORMATS, written, DPI) as figure:
        import matplotlib as mpl  # noqa: PLC0415  part of an extra, which `paper` has found

        mpl.rcParams.update(
            {
                "axes.titlesize": 8,
                "axes.labelsize": 7.5,
                "xtick.labelsize": 7,
                "ytick.labelsize": 7,
                "legend.fontsize": 7,
            }
        )
        figure.get_layout_engine().set(w_pad=0.03, h_pad=0.03)
        yield figure


def heading(figure: Any, text: str, *, bad: bool) -> None:
    """Above everything, on the left; in red where it says that something is wrong."""
    figure.suptitle(
        _wrapped(figure, text, HEADING_PT),
        x=0.01,
        ha="left",
        fontsize=HEADING_PT,
        fontweight="bold",
        color=NODE if bad else INK,
    )


def caption(figure: Any, text: str) -> None:
    """Below everything, on the left."""
    figure.supxlabel(
        _wrapped(figure, text, CAPTION_PT), x=0.01, ha="left", fontsize=CAPTION_PT, color=DESIRED
    )


def halo(width: float = 1.6) -> list[Any]:
    """A light rim around lines and words, so that they are seen on any backdrop."""
    from matplotlib.patheffects import withStroke  # noqa: PLC0415  part of an extra

    return [withStroke(linewidth=width, foreground=HALO, alpha=0.85)]


def _wrapped(figure: Any, text: str, size_pt: float) -> str:
    letters = int(figure.get_figwidth() * LETTERS_PER_IN * CAPTION_PT / size_pt)
    lines = (
        textwrap.wrap(line, letters, break_long_words=False, break_on_hyphens=False)
        for line in text.split("\n")
    )
    return "\n".join(piece for line in lines for piece in line)
