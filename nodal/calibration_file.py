"""The calibration file: every camera of the rig, in JSON. docs/calibration-file.md says what each key means."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from messaging.errors import InvalidMessageError
from messaging.frames import CameraCalibration
from nodal.errors import CalibrationFileError
from nodal.whole_file import write_whole

NUMBERS = re.compile(r"\[[-+.,\deE\s]+\]")

Row = list[float]
Matrix = list[list[float]]


class _Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    width_px: int
    height_px: int
    intrinsics: Matrix
    distortion: Row
    camera_from_robot: Matrix


class _Rig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    format: Literal["nodal-rig/1"]
    units: Literal["mm"]
    cameras: Annotated[dict[str, dict[str, Any]], msgspec.Meta(min_length=2)]


def load_rig(path: Path) -> tuple[CameraCalibration, ...]:
    """The cameras in a calibration file, in its order; raises CalibrationFileError naming file, camera and key."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CalibrationFileError(f"{path}: cannot be read: {error.strerror}") from error
    return rig_in(data, str(path))


def rig_in(data: bytes, source: str) -> tuple[CameraCalibration, ...]:
    """The cameras in a calibration file's bytes; raises CalibrationFileError, which begins with `source`."""
    try:
        rig = msgspec.json.decode(data, type=_Rig)
    except msgspec.DecodeError as error:
        raise CalibrationFileError(f"{source}: not a calibration file: {error}") from error
    return tuple(_camera(source, name, values) for name, values in rig.cameras.items())


def save_rig(path: Path, cameras: Sequence[CameraCalibration]) -> None:
    """Write cameras as a calibration file that `load_rig` reads back exactly; raises CalibrationFileError."""
    try:
        write_whole(path, rig_text(cameras).encode())
    except OSError as error:
        raise CalibrationFileError(f"{path}: cannot be written: {error.strerror}") from error


def rig_text(cameras: Sequence[CameraCalibration]) -> str:
    """The calibration file of these cameras."""
    rig = {
        "format": "nodal-rig/1",
        "units": "mm",
        "cameras": {
            camera.camera: {
                "width_px": camera.width_px,
                "height_px": camera.height_px,
                "intrinsics": camera.intrinsics.tolist(),
                "distortion": camera.distortion.tolist(),
                "camera_from_robot": camera.camera_from_robot.tolist(),
            }
            for camera in cameras
        },
    }
    return NUMBERS.sub(_on_one_line, json.dumps(rig, indent=1)) + "\n"


def rig_from_matrices(
    size_px: tuple[int, int],
    intrinsics: Mapping[str, ArrayLike],
    distortion: Mapping[str, ArrayLike],
    camera_from_robot: Mapping[str, ArrayLike],
) -> tuple[CameraCalibration, ...]:
    """Cameras of one size (width, height) from matrices by camera name, as another calibration tool hands them out.

    `intrinsics` K (3, 3) in px; `distortion` in OpenCV's order k1, k2, p1, p2, k3, where missing ones at the end are 0;
    `camera_from_robot` (4, 4) with `x_camera = camera_from_robot @ x_robot` in mm. Raises CalibrationFileError when the
    three do not name the same cameras or a distortion has more than five terms, InvalidMessageError for a matrix that
    no camera can have.
    """
    names = list(intrinsics)
    for what, matrices in (("distortion", distortion), ("camera_from_robot", camera_from_robot)):
        if set(matrices) != set(names):
            raise CalibrationFileError(
                f"{what} is given for {sorted(matrices)}; intrinsics for {sorted(names)}"
            )
    return tuple(
        CameraCalibration(
            camera=name,
            width_px=size_px[0],
            height_px=size_px[1],
            intrinsics=np.asarray(intrinsics[name], np.float64),
            distortion=_five_terms(name, distortion[name]),
            camera_from_robot=np.asarray(camera_from_robot[name], np.float64),
        )
        for name in names
    )


def _on_one_line(numbers: re.Match[str]) -> str:
    return "[" + " ".join(numbers[0].strip("[]").split()) + "]"


def _five_terms(name: str, distortion: ArrayLike) -> Any:
    terms = np.asarray(distortion, np.float64).ravel()
    if terms.size > 5:
        raise CalibrationFileError(
            f"camera {name}: distortion has {terms.size} terms; at most 5 are known: k1, k2, p1, p2, k3"
        )
    return np.pad(terms, (0, 5 - terms.size))


def _camera(source: str, name: str, values: dict[str, Any]) -> CameraCalibration:
    try:
        camera = msgspec.convert(values, _Camera)
        return CameraCalibration(camera=name, **msgspec.structs.asdict(camera))
    except msgspec.ValidationError as error:
        raise CalibrationFileError(f"{source}: camera {name}: {error}") from error
    except InvalidMessageError as error:
        raise CalibrationFileError(f"{source}: {error}") from error
