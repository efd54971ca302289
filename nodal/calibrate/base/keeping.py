"""What `nodal calibrate base` leaves in the calibration folder: base.json, the rig, and pictures with the frame drawn over them."""

import shutil
from datetime import UTC, datetime
from pathlib import Path

import cv2
import msgspec
import numpy as np

from calibration.base import Base, BasesFound, Way
from calibration.camera_set import CameraSet
from messaging.frames import CameraCalibration
from nodal.bench_file import BenchFile
from nodal.calibrate.looking import Jpegs
from nodal.calibration.folder import calibration_folder, save_json
from nodal.calibration_file import save_rig
from nodal.errors import CalibrationFileError
from sensing.geometry.camera import Camera

BASE = "base.json"
AXIS_MM = 20.0
TICKS_MM = 5.0
COLOURS = {"X": (60, 60, 230), "Y": (60, 200, 60), "Z": (240, 120, 40)}
"""B, G, R."""
SHIFT = 4


def kept_bases(bench: BenchFile, cameras: CameraSet) -> dict[Way, Base]:
    """The results so far that hold for these cameras; raises CalibrationFileError for a file that holds something else."""
    file = calibration_folder(bench) / BASE
    if not file.exists():
        return {}
    try:
        kept = msgspec.json.decode(file.read_bytes(), type=BasesFound)
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be read: {error.strerror}") from error
    except msgspec.DecodeError as error:
        raise CalibrationFileError(f"{file}: not a file of robot frames: {error}") from error
    known: dict[Way, Base | None] = {"board": kept.board, "robot": kept.robot}
    return {way: base for way, base in known.items() if base and base.cameras_made_at == cameras.made_at}


def keep(
    bench: BenchFile, cameras: CameraSet, bases: dict[Way, Base], used: Way, pictures: Jpegs
) -> tuple[CameraCalibration, ...]:
    """Write base.json, the rig with the robot frame that is used, and base-CAMERA.jpg; returns the rig.

    The rig that was there before stays beside it as `NAME~`. Raises CalibrationFileError.
    """
    folder, file = calibration_folder(bench), Path(bench.settings.calibration)
    rig = cameras.in_robot_frame(bases[used].matrix)
    found = BasesFound(used=used, board=bases.get("board"), robot=bases.get("robot"))
    save_json(folder / BASE, found)
    try:
        for calibration in rig:
            (folder / f"base-{calibration.camera}.jpg").write_bytes(
                drawn(calibration, pictures[calibration.camera])
            )
        if file.exists():
            shutil.copy(file, before(file))
    except OSError as error:
        raise CalibrationFileError(f"{folder}: cannot be written: {error.strerror}") from error
    save_rig(file, rig)
    return rig


def before(rig: Path) -> Path:
    """Where the rig is kept that this one replaced."""
    return rig.with_name(rig.name + "~")


def dated(base: Base, cameras: CameraSet) -> Base:
    """With the time of now, and the cameras that it holds for."""
    made_at = datetime.now(UTC).isoformat(timespec="seconds")
    return msgspec.structs.replace(base, made_at=made_at, cameras_made_at=cameras.made_at)


def drawn(calibration: CameraCalibration, jpeg: bytes) -> bytes:
    """The camera's picture, coded, with the robot frame's axes at the base, marked every few millimetres."""
    picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if picture is None:
        raise CalibrationFileError(f"camera {calibration.camera}: its picture cannot be decoded")
    camera = Camera(calibration)
    along = np.arange(0.0, AXIS_MM + TICKS_MM / 2, TICKS_MM)
    for axis, (name, colour) in enumerate(COLOURS.items()):
        places = camera.project(np.outer(along, np.eye(3)[axis]))
        ends = np.rint(places * (1 << SHIFT)).astype(int)
        for line, width in (((255, 255, 255), 5), (colour, 2)):
            cv2.line(picture, ends[0].tolist(), ends[-1].tolist(), line, width, cv2.LINE_AA, SHIFT)
        for mark in ends[1:]:
            cv2.circle(picture, mark.tolist(), 4 << SHIFT, colour, -1, cv2.LINE_AA, SHIFT)
        beyond = places[-1] + 22 * (places[-1] - places[0]) / max(
            float(np.linalg.norm(places[-1] - places[0])), 1.0
        )
        at = (beyond - (8, -8)).round().astype(int).tolist()
        for line, width in (((255, 255, 255), 5), (colour, 2)):
            cv2.putText(picture, name, at, cv2.FONT_HERSHEY_SIMPLEX, 0.8, line, width, cv2.LINE_AA)
    _, coded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 90])
    return coded.tobytes()
