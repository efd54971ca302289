"""This project's own files: cameras among one another (cameras.json), or in the robot frame (rig.json)."""

import json
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from calibration.camera_set import CameraSet
from nodal.calibration.folder import cameras_in, save_json
from nodal.calibration.formats.calibration import Calibration, Choices, text_of
from nodal.calibration_file import load_rig, save_rig
from nodal.errors import CalibrationFileError


def read(files: Sequence[Path], choices: Choices) -> Calibration:
    """Either of the two; raises CalibrationFileError."""
    (file,) = files
    if is_rig(file):
        rig = load_rig(file)
        found = Calibration(cameras=CameraSet.of_rig(rig), rig_from_robot=rig[0].camera_from_robot)
    else:
        found = Calibration(cameras=cameras_in(file))
    return found if not choices.names else _renamed(str(file), found, choices.names)


def is_rig(file: Path) -> bool:
    """Whether a JSON file holds cameras in the robot frame; raises CalibrationFileError."""
    try:
        content = json.loads(text_of(file))
    except json.JSONDecodeError as error:
        raise CalibrationFileError(f"{file}: not JSON: {error}") from error
    return isinstance(content, dict) and "format" in content


def write_rig(out: Path, calibration: Calibration) -> Calibration:
    """rig.json; raises CalibrationFileError where the robot frame is not known."""
    if calibration.rig_from_robot is None:
        raise CalibrationFileError(
            f"{out}: where the robot stands is not known, so it cannot be a rig file; convert to cameras, then find the robot "
            "with `nodal calibrate base`"
        )
    save_rig(out, calibration.cameras.in_robot_frame(calibration.rig_from_robot))
    return calibration


def write_cameras(out: Path, calibration: Calibration) -> Calibration:
    """cameras.json, made now if nothing else is known: a robot frame holds for the cameras of one time. Raises CalibrationFileError."""
    made_at = calibration.cameras.made_at or datetime.now(UTC).isoformat(timespec="seconds")
    save_json(out, msgspec.structs.replace(calibration.cameras, made_at=made_at))
    if calibration.rig_from_robot is None:
        return calibration
    return replace(calibration, notes=(*calibration.notes, "the robot frame is left out"))


def _renamed(source: str, calibration: Calibration, names: tuple[str, ...]) -> Calibration:
    cameras = calibration.cameras.cameras
    if len(names) != len(cameras) or len(set(names)) != len(names):
        raise CalibrationFileError(
            f"{source}: it holds {len(cameras)} cameras, which cannot be called {', '.join(names)}"
        )
    renamed = tuple(
        msgspec.structs.replace(camera, name=name) for camera, name in zip(cameras, names, strict=True)
    )
    return replace(calibration, cameras=msgspec.structs.replace(calibration.cameras, cameras=renamed))
