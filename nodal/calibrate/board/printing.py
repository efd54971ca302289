"""A board is drawn, printed by a printer that may shrink it, and measured; the folder of the calibration remembers what was drawn."""

from pathlib import Path

import msgspec

from calibration.board import Board
from messaging.board import BoardSettings
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import BenchFile
from nodal.calibrate.board.drawing import described, draw_board
from nodal.calibrate.board.page import board_page
from nodal.calibration.folder import CAMERAS, calibration_folder, cameras_in, save_json
from nodal.errors import CalibrationError, CommandError

PRINTED = "board.json"
MOST_SCALE = 1.25
"""Printers that fit a page to their paper shrink it by a few per cent; what differs by more was measured elsewhere."""
DIGITS = 4


class PrintedBoard(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What was drawn: the board as it should be, and the ruler beside it."""

    board: BoardSettings
    ruler_mm: float


def print_board(bench: BenchFile, file: Path, paper: str) -> str:
    """Draw the bench's board; returns what to do with it.

    Raises CalibrationError, BoardError, CalibrationFileError, NodalError without matplotlib.
    """
    board = bench.settings.board
    Board(board)  # what no camera could read is refused before it is printed
    page = board_page(board, paper)
    draw_board(file, page, board)
    save_json(calibration_folder(bench) / PRINTED, PrintedBoard(board=board, ruler_mm=page.ruler_mm))
    return (
        f"{file}: {described(board)}, on {paper}\n"
        f"print it at 100 %, glue it onto something flat and stiff, and measure the ruler ({page.ruler_mm:g} mm), then:\n"
        f"    nodal calibrate board --config {bench.path} --measured MM"
    )


def correct_board(bench: BenchFile, measured_mm: float) -> str:
    """Write the size of the squares that follows from the ruler into the bench file; returns what became of it.

    It follows from the board as it was drawn, so that measuring again replaces what was measured before. Raises CommandError,
    CalibrationError, CalibrationFileError, BenchFileError.
    """
    printed = _remembered(bench)
    scale = measured_mm / printed.ruler_mm
    if not 1 / MOST_SCALE <= scale <= MOST_SCALE:
        raise CommandError(
            f"--measured {measured_mm:g}: the ruler was drawn {printed.ruler_mm:g} mm long; allowed are "
            f"{printed.ruler_mm / MOST_SCALE:g} to {printed.ruler_mm * MOST_SCALE:g} mm"
        )
    drawn = printed.board
    sizes = {"square_mm": round(drawn.square_mm * scale, DIGITS)}
    if drawn.kind == "charuco":
        sizes["marker_mm"] = round(drawn.marker_mm * scale, DIGITS)
    outdated = _outdated(bench, sizes["square_mm"])
    edit_bench_file(bench.path, {"board": sizes})
    what = ", ".join(f"{key} = {value:g}" for key, value in sizes.items())
    return f"{bench.path}: [board] {what}; it was drawn with {drawn.square_mm:g} mm and came out at {100 * scale:.2f} %{outdated}"


def _outdated(bench: BenchFile, square_mm: float) -> str:
    """What was calibrated with this board before it was known to be of this size; raises CalibrationFileError."""
    file = calibration_folder(bench) / CAMERAS
    board = cameras_in(file).board if file.exists() else None
    if board is None or board.square_mm == square_mm or _layout(board) != _layout(bench.settings.board):
        return ""
    off = 100 * (board.square_mm / square_mm - 1)
    return (
        f"\n{file} was calibrated with squares of {board.square_mm:g} mm: lengths in it, and in the rig that was made from it, are "
        f"{off:+.2f} % off until you run nodal calibrate cameras and nodal calibrate base again"
    )


def _remembered(bench: BenchFile) -> PrintedBoard:
    """What was drawn last; raises CalibrationError when that is not the bench's board."""
    file = calibration_folder(bench) / PRINTED
    try:
        printed = msgspec.json.decode(file.read_bytes(), type=PrintedBoard)
    except (OSError, msgspec.DecodeError) as error:
        raise CalibrationError(
            f"{bench.path}: which board was printed is not known, for there is no {file}; draw one with --out first"
        ) from error
    if _layout(printed.board) != _layout(bench.settings.board):
        raise CalibrationError(
            f"{bench.path}: the board that was drawn, {described(printed.board)}, is another one than that of [board] now"
        )
    return printed


def _layout(board: BoardSettings) -> tuple[object, ...]:
    return board.kind, board.squares, board.dictionary, board.legacy_pattern
