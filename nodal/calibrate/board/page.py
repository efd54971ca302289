"""Where the board, its ruler and its words lie on a sheet of paper. Pure: mm from the sheet's top left, x right, y down."""

import dataclasses
from collections.abc import Iterable

import msgspec
import numpy as np

from messaging.board import BoardSettings
from nodal.errors import CalibrationError

PAPERS_MM = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "letter": (215.9, 279.4)}
"""Width and height, upright."""

EDGE_MM = 10.0
"""What printers leave white."""
HEAD_MM, FOOT_MM = 6.0, 26.0
"""For the words above the board, and for the ruler and the words below it."""
LEAST_WHITE_MM = 5.0
LONGEST_RULER_MM, RULER_STEP_MM = 100.0, 10.0
SIZES_MM = np.arange(0.5, 100.5, 0.5)
"""Squares that are offered instead of those that do not fit."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class BoardPage:
    """A sheet with a board on it; corners are top left ones."""

    paper: str
    width_mm: float
    height_mm: float
    board_corner_mm: tuple[float, float]
    ruler_start_mm: tuple[float, float]
    ruler_mm: float
    """How long the ruler is when it was printed true to scale."""


def board_page(board: BoardSettings, paper: str) -> BoardPage:
    """The board on this paper, upright where it fits so; raises CalibrationError with the sizes that would fit."""
    found = _upright_or_across(board, paper)
    if found is None:
        raise CalibrationError(_what_would_fit(board, paper))
    return found


def size_mm(board: BoardSettings) -> tuple[float, float]:
    """Width and height of the squares together."""
    columns, rows = board.squares
    return columns * board.square_mm, rows * board.square_mm


def _upright_or_across(board: BoardSettings, paper: str) -> BoardPage | None:
    width_mm, height_mm = PAPERS_MM[paper]
    return _laid_out(board, paper, width_mm, height_mm) or _laid_out(board, paper, height_mm, width_mm)


def _laid_out(board: BoardSettings, paper: str, width_mm: float, height_mm: float) -> BoardPage | None:
    across_mm, down_mm = size_mm(board)
    # detectors need white around the outermost squares: half a square is more than a marker's own border
    white_mm = max(board.square_mm / 2, LEAST_WHITE_MM)
    top_mm = EDGE_MM + HEAD_MM + white_mm
    bottom_mm = top_mm + down_mm + white_mm
    if across_mm + 2 * max(EDGE_MM, white_mm) > width_mm or bottom_mm + FOOT_MM + EDGE_MM > height_mm:
        return None
    ruler_mm = min(LONGEST_RULER_MM, (width_mm - 2 * EDGE_MM) // RULER_STEP_MM * RULER_STEP_MM)
    return BoardPage(
        paper=paper,
        width_mm=width_mm,
        height_mm=height_mm,
        board_corner_mm=((width_mm - across_mm) / 2, top_mm),
        ruler_start_mm=((width_mm - ruler_mm) / 2, bottom_mm + 2.0),
        ruler_mm=ruler_mm,
    )


def _what_would_fit(board: BoardSettings, paper: str) -> str:
    across_mm, down_mm = size_mm(board)
    columns, rows = board.squares
    papers = [other for other in PAPERS_MM if _upright_or_across(board, other)]
    squares_mm = [size for size in SIZES_MM if _upright_or_across(_with_squares(board, size), paper)]
    advice = [f"it fits {_either(papers)}"] if papers else []
    if squares_mm:
        advice.append(f"{paper} takes squares of up to {max(squares_mm):g} mm")
    return (
        f"a board of {columns} x {rows} squares of {board.square_mm:g} mm ({across_mm:g} x {down_mm:g} mm) with its ruler does "
        f"not fit {paper}: {'; '.join(advice) or 'no paper takes so many squares'}"
    )


def _with_squares(board: BoardSettings, square_mm: float) -> BoardSettings:
    scale = float(square_mm) / board.square_mm
    return msgspec.structs.replace(
        board, square_mm=board.square_mm * scale, marker_mm=board.marker_mm * scale
    )


def _either(names: Iterable[str]) -> str:
    return " or ".join(names)
