"""Where calibration keeps what it finds: the folder of the bench file's calibration, and the files in it."""

import shutil
import sys
from collections.abc import Mapping
from pathlib import Path

import msgspec

from calibration.camera_set import CameraSet
from messaging.frames import CameraCalibration
from nodal.bench_file import SHIPPED, BenchFile, make_folder, read_bench, work_folder
from nodal.calibration_file import load_rig
from nodal.errors import CalibrationFileError
from nodal.toml_file import written
from nodal.whole_file import write_whole

CAMERAS = "cameras.json"
"""Cameras among one another; the calibration file that the bench file names holds them in the robot frame."""


def own_bench(config: str | Path) -> BenchFile:
    """The bench file that calibration may write to: this one, or, for one that comes with nodal, a copy of it in
    `runs/NAME`, which is made the first time and gone on with later. Raises BenchFileError.
    """
    bench = read_bench(config)
    if bench.path.parent != SHIPPED:
        return bench
    folder = make_folder(work_folder(bench.path), "runs")
    copy = folder / "bench.toml"
    if not copy.exists():
        make_folder(folder / "calibration", "runs")
        shutil.copy(bench.settings.calibration, folder / "calibration" / "rig.json")
        copy.write_text(_own_copy(bench, {"calibration": "calibration/rig.json"}), encoding="utf-8")
        print(
            f"{bench.path.name} comes with nodal and stays as it is; calibration works on its copy {copy}",
            file=sys.stderr,
        )
    return read_bench(copy)


def calibration_folder(bench: BenchFile) -> Path:
    """The folder of the calibration file, made if it is missing; raises BenchFileError."""
    return make_folder(Path(bench.settings.calibration).parent, "calibration")


def load_cameras(bench: BenchFile) -> CameraSet:
    """What `nodal calibrate cameras` found; failing that, the cameras of the calibration file. Raises CalibrationFileError."""
    file = calibration_folder(bench) / CAMERAS
    if file.exists():
        return cameras_in(file)
    if not Path(bench.settings.calibration).exists():
        raise CalibrationFileError(
            f"{bench.path}: its cameras are not calibrated: there is neither {file} nor {bench.settings.calibration}; "
            "begin with `nodal calibrate cameras`"
        )
    return CameraSet.of_rig(_in_order(bench, load_rig(Path(bench.settings.calibration))))


def cameras_in(file: Path) -> CameraSet:
    """The cameras in such a file; raises CalibrationFileError."""
    try:
        return msgspec.json.decode(file.read_bytes(), type=CameraSet)
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be read: {error.strerror}") from error
    except msgspec.DecodeError as error:
        raise CalibrationFileError(f"{file}: not a file of calibrated cameras: {error}") from error


def save_json(file: Path, found: msgspec.Struct) -> None:
    """Write what a step found, in place of what it found before; raises CalibrationFileError."""
    try:
        write_whole(file, msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n")
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be written: {error.strerror}") from error


def _in_order(bench: BenchFile, rig: tuple[CameraCalibration, ...]) -> list[CameraCalibration]:
    known = {camera.camera: camera for camera in rig}
    for name in bench.settings.cameras:
        if name not in known:
            raise CalibrationFileError(
                f"{bench.settings.calibration}: it has no camera {name}, only {', '.join(known)}"
            )
    return [known[name] for name in bench.settings.cameras]


def _own_copy(bench: BenchFile, changes: Mapping[str, str]) -> str:
    """The bench in a folder of its own, with its cameras where they really are."""
    table = msgspec.to_builtins(bench.settings) | changes
    table["simulation"]["rig"] = bench.settings.simulation and (
        bench.settings.simulation.rig or bench.settings.calibration
    )
    table["servos"]["port"] = table["simulation"]["servos"]["link"] = "servos"
    table["recorder"]["folder"] = "."
    return written(table)
