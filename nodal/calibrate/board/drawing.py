"""The printable board: vectors true to scale, in PDF or SVG."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from messaging.board import BoardSettings
from nodal.calibrate.board.page import BoardPage
from nodal.calibrate.board.pattern import black_rectangles_mm
from nodal.errors import CalibrationError
from nodal.report.pictures.paper import paper

Array = NDArray[np.float64]

FORMATS = ("pdf", "svg")
MM_PER_INCH = 25.4
TICKS_MM = ((10, 4.0), (5, 3.0), (1, 2.0))
"""Every so many mm of the ruler, a tick so long."""
LINE_PT, TITLE_PT, TEXT_PT = 0.5, 9.0, 7.5
LINE_MM = 4.2


def draw_board(file: Path, page: BoardPage, board: BoardSettings) -> None:
    """Write the sheet in the format that the file's name asks for; raises CalibrationError, NodalError without matplotlib."""
    try:
        with paper(
            file, page.width_mm / MM_PER_INCH, page.height_mm / MM_PER_INCH, [file.suffix[1:].lower()], []
        ) as figure:
            figure.set_layout_engine("none")
            axes = figure.add_axes((0, 0, 1, 1))
            axes.set(xlim=(0, page.width_mm), ylim=(page.height_mm, 0))
            axes.set_axis_off()
            _fill(axes, black_rectangles_mm(board) + np.tile(page.board_corner_mm, 2))
            _rule(axes, page)
            _say(axes, page, board)
    except OSError as error:
        raise CalibrationError(f"{file}: the board cannot be written: {error.strerror}") from error


def words(page: BoardPage, board: BoardSettings) -> tuple[str, ...]:
    """What is written below the ruler."""
    return (
        f"nodal: {described(board)}",
        (
            "Print at 100 %, not fitted to the page, and glue it onto something flat and stiff. "
            f"The ruler should be {page.ruler_mm:g} mm long."
        ),
        "Then say what you measured: nodal calibrate board --config BENCH --measured MM, which writes [board] square_mm.",
    )


def described(board: BoardSettings) -> str:
    """Which board it is, in words."""
    columns, rows = board.squares
    squares = f"{columns} x {rows} squares of {board.square_mm:g} mm"
    if board.kind == "chessboard":
        return f"chessboard, {squares}"
    legacy = ", legacy pattern" if board.legacy_pattern else ""
    return f"ChArUco board, {squares}, markers of {board.marker_mm:g} mm from {board.dictionary}{legacy}"


def _fill(axes: Any, rectangles_mm: Array) -> None:
    """All of them as one shape, so that no renderer leaves a seam between two that touch."""
    from matplotlib.patches import PathPatch  # noqa: PLC0415  part of an extra, which `paper` has found
    from matplotlib.path import Path as Outline  # noqa: PLC0415

    x0, y0, x1, y1 = rectangles_mm.T
    corners = np.stack([x0, y0, x1, y0, x1, y1, x0, y1, x0, y0], axis=1).reshape(-1, 2)
    codes = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    outline = Outline(corners, codes * len(rectangles_mm))
    axes.add_patch(PathPatch(outline, facecolor="black", linewidth=0, clip_on=False, gid="board"))


def _rule(axes: Any, page: BoardPage) -> None:
    x, y = page.ruler_start_mm
    from matplotlib.collections import LineCollection  # noqa: PLC0415  part of an extra, which `paper` has found

    ticks = [
        np.array([(x + at, y), (x + at, y + next(long for step, long in TICKS_MM if at % step == 0))])
        for at in range(round(page.ruler_mm) + 1)
    ]
    lines = [np.array([(x, y), (x + page.ruler_mm, y)]), *ticks]
    axes.add_collection(
        LineCollection(lines, colors="black", linewidths=LINE_PT, clip_on=False, gid="ruler"), autolim=False
    )
    for at in range(0, round(page.ruler_mm) + 1, TICKS_MM[0][0]):
        axes.text(x + at, y + TICKS_MM[0][1] + 0.8, f"{at}", fontsize=TEXT_PT, ha="center", va="top")
    axes.text(x + page.ruler_mm + 4, y + TICKS_MM[0][1] + 0.8, "mm", fontsize=TEXT_PT, va="top")


def _say(axes: Any, page: BoardPage, board: BoardSettings) -> None:
    middle_mm = page.width_mm / 2
    axes.text(
        middle_mm, page.board_corner_mm[1] - 8, "\u25b2 top", fontsize=TITLE_PT, ha="center", va="bottom"
    )
    below_mm = page.ruler_start_mm[1] + 12
    for number, line in enumerate(words(page, board)):
        axes.text(
            middle_mm,
            below_mm + number * LINE_MM,
            line,
            fontsize=TEXT_PT,
            ha="center",
            va="top",
            parse_math=False,
        )
