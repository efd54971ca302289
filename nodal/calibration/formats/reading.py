"""Which format a file is in, and reading and writing each."""

import importlib
from collections.abc import Sequence
from pathlib import Path

from nodal.calibration.formats import own
from nodal.calibration.formats.calibration import Calibration, Choices, Format
from nodal.calibration.formats.names import CAMERAS, KALIBR, MATLAB, OPENCV, RIG, ROS
from nodal.errors import CalibrationFileError, CommandError

SUFFIXES = {".mat": MATLAB, ".xml": OPENCV}
SEVERAL = (OPENCV, ROS)
"""Formats that may lie in several files."""


def read_calibration(files: Sequence[Path], form: str | None, choices: Choices) -> Calibration:
    """The cameras in these files, in the format `form` or in whichever it turns out to be; raises CalibrationFileError."""
    form = form or recognised(files[0])
    if len(files) > 1 and form not in SEVERAL:
        raise CalibrationFileError(
            f"{', '.join(map(str, files))}: a calibration in the format {form} is one file"
        )
    return own.read(files, choices) if form in (RIG, CAMERAS) else _module(form).read(files, choices)


def write_calibration(
    out: Path, form: str | None, calibration: Calibration, choices: Choices
) -> tuple[str, Calibration]:
    """Write it in the format `form`, or in the one that the name `out` implies: which, and with notes of what was left out.

    Raises CalibrationFileError, CommandError.
    """
    form = form or _implied(out, calibration)
    if form == RIG:
        return form, own.write_rig(out, calibration)
    if form == CAMERAS:
        return form, own.write_cameras(out, calibration)
    return form, _module(form).write(out, calibration, choices)


def recognised(file: Path) -> str:
    """The format of a file by what is in it; raises CalibrationFileError."""
    try:
        head = file.read_bytes()
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be read: {error.strerror}") from error
    if head.startswith((b"MATLAB", b"\x89HDF")) or file.suffix == ".mat":
        return MATLAB
    if head.lstrip().startswith(b"{"):
        return CAMERAS
    if b"opencv-matrix" in head or b"opencv_storage" in head:
        return OPENCV
    if b"cam0:" in head:
        return KALIBR
    if b"camera_matrix:" in head and b"distortion_model:" in head:
        return ROS
    raise CalibrationFileError(
        f"{file}: not a calibration that is known here; if it is one after all, say which with --from"
    )


def _implied(out: Path, calibration: Calibration) -> str:
    if out.suffix == ".json":
        return CAMERAS if calibration.rig_from_robot is None else RIG
    if out.suffix not in SUFFIXES:
        raise CommandError(
            f"{out}: several formats could have this name; say with --to which: {OPENCV}, {ROS} or {KALIBR}"
        )
    return SUFFIXES[out.suffix]


def _module(form: str) -> Format:
    # each brings a library of its own, of which only one is needed
    module: Format = importlib.import_module(f"nodal.calibration.formats.{form}")
    return module
