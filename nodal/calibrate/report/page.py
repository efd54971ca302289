"""Writes the calibration report."""

import importlib
from pathlib import Path

from nodal.bench_file import BenchFile
from nodal.calibrate.cameras.verdict import Grade, judgements, overall
from nodal.calibrate.cameras.words import SUMMARIES
from nodal.calibrate.report import SECTIONS
from nodal.calibrate.report.levels import LEVELS
from nodal.calibrate.report.material import Material, material
from nodal.errors import ReportError
from nodal.report.page.markup import Content, element, section
from nodal.report.page.numbers import NOTHING, with_unit
from nodal.report.page.writing import page_text

REPORT = "report.html"
MADE_BY = "Made by nodal calibration report. Everything is in this file."


def write_report(bench: BenchFile, file: Path | None = None) -> Path:
    """The page, in the folder of the calibration unless `file` says where; returns where it is.

    Raises CalibrationFileError, ReportError, or NodalError without matplotlib.
    """
    known = material(bench)
    modules = [importlib.import_module(f"nodal.calibrate.report.{name}") for name in SECTIONS]
    parts = [
        section(module.__name__.rpartition(".")[2], module.TITLE, content)
        for module in modules
        if (content := module.content(known)) is not None
    ]
    text = page_text(f"Calibration of {bench.settings.name}", _heading(known), parts, MADE_BY)
    file = file or known.folder / REPORT
    try:
        file.write_text(text, encoding="utf-8", errors="replace")
    except OSError as error:
        raise ReportError(f"{file}: the page cannot be written: {error.strerror}") from error
    return file


def _heading(known: Material) -> Content:
    """Which bench, the verdict, and the figures that say most."""
    found = judgements(known.cameras)
    grade = overall(found)
    objections = [f"{one.what}: {one.why}; {one.advice}." for one in found if one.grade is not Grade.GOOD]
    made = (
        f"cameras calibrated {known.cameras.made_at}"
        if known.cameras.made_at
        else "cameras of a calibration file"
    )
    return [
        element("h1", f"Calibration of {known.bench.settings.name}"),
        element("p", made, class_="when"),
        element(
            "div",
            element("strong", str(grade)),
            element("p", SUMMARIES[grade].partition(": ")[2].capitalize() + "."),
            [element("p", objection) for objection in objections],
            class_=f"verdict {LEVELS[grade]}",
        ),
        element(
            "ul",
            [element("li", element("b", value), element("span", label)) for value, label in _tiles(known)],
            class_="tiles",
        ),
    ]


def _tiles(known: Material) -> list[tuple[str, str]]:
    cameras, figures = known.cameras, known.figures
    views = f"views used, {len(cameras.views_rejected)} rejected"
    board_mm = with_unit(figures.board_error_mm, "mm")
    tiles = (
        (str(cameras.views_used or NOTHING), views),
        *(
            (with_unit(camera.held_out_rms_px, "px"), f"{camera.name}: error in held-out views, RMS")
            for camera in cameras.cameras
        ),
        (board_mm, "error of a square's side in 3-D, RMS"),
        *(
            (with_unit(pair.depth_mm, "mm"), f"depth that 0.1 px is, {' and '.join(pair.names)}")
            for pair in figures.pairs
        ),
    )
    return [(value, label) for value, label in tiles if value != NOTHING]
