"""What `nodal calibrate background` leaves: pictures and background.json in the calibration folder, keys in the bench file."""

import os
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

import cv2
import msgspec
import numpy as np

from nodal.bench_editing import edit_bench_file
from nodal.bench_file import Bench, BenchFile
from nodal.calibrate.background.judging import CameraBackground
from nodal.calibrate.background.robot import RobotSeen
from nodal.calibration.folder import calibration_folder, save_json
from nodal.errors import CalibrationFileError
from nodal.whole_file import write_whole
from sensing.pictures.light import Image

FILE = "background.json"
QUALITY = 98
"""Of the JPEG, with a colour for every pixel: it adds less than the camera's noise over a second of pictures."""


class BackgroundFound(msgspec.Struct, frozen=True, kw_only=True):
    """background.json: when the pictures were taken, where the stage stood, what they tell, and what the robot looks like before them."""

    made_at: str
    """ISO 8601, UTC."""
    insertion_mm: float
    insertion_known: bool
    cameras: tuple[CameraBackground, ...]
    robot: RobotSeen | None = None


def keep(bench: BenchFile, found: BackgroundFound, pictures: Mapping[str, Image]) -> list[Path]:
    """Write the pictures (h, w, 3) by camera, the figures, and into the bench file where they are; returns the pictures' files.

    Raises CalibrationFileError, BenchFileError.
    """
    folder = calibration_folder(bench)
    files = {name: folder / f"background-{name}.jpg" for name in pictures}
    for name, picture in pictures.items():
        write_picture(files[name], picture)
    save_json(folder / FILE, found)
    relative = {name: os.path.relpath(file, bench.path.parent) for name, file in files.items()}
    known = bench.settings.sensing.work_area
    areas = {
        camera.camera: camera.work_area and [list(corner) for corner in camera.work_area]
        for camera in found.cameras
        if camera.work_area or camera.camera in known
    }
    edit_bench_file(
        bench.path, {"sensing": {"background": relative} | ({"work_area": areas} if areas else {})}
    )
    return list(files.values())


def write_picture(file: Path, picture: Image) -> None:
    """As JPEG of high quality; raises CalibrationFileError."""
    try:
        write_whole(file, coded(picture))
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be written: {error.strerror}") from error


def coded(picture: Image) -> bytes:
    """The picture (h, w, 3) as JPEG of high quality."""
    whole = cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
    _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY, *whole])
    return np.asarray(data).tobytes()


def stage_of(bench: Bench) -> float:
    """Where the stage stood, in mm, for the background pictures of a bench; 0 where that was not noted. Raises CalibrationFileError."""
    file = Path(bench.settings.calibration).parent / FILE
    if not file.exists():
        return 0.0
    try:
        return msgspec.json.decode(file.read_bytes(), type=BackgroundFound).insertion_mm
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be read: {error.strerror}") from error
    except msgspec.DecodeError as error:
        raise CalibrationFileError(
            f"{file}: not what `nodal calibrate background` writes: {error}"
        ) from error


def now() -> str:
    """For `made_at`."""
    return datetime.now(UTC).isoformat(timespec="seconds")
