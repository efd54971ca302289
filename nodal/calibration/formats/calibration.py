"""What every format is read into and written from, and what no format may hide."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from calibration.camera_set import CalibratedCamera, CameraSet
from messaging.errors import InvalidMessageError
from messaging.frames import CameraCalibration
from nodal.errors import CalibrationFileError

Array = NDArray[np.float64]

TERMS = 5
"""k1, k2, p1, p2, k3."""
LARGER_MODELS = {8: "rational", 12: "thin prism", 14: "tilted sensor"}
"""OpenCV's models by how many terms they have, beyond the one that sensing uses."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Cameras among one another, and where the robot stands in their frame, (4, 4) in mm, if that is known.

    `notes` say what was assumed in reading, or could not be written.
    """

    cameras: CameraSet
    rig_from_robot: Array | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What a file does not say itself.

    `names` are the cameras', in the file's order; `mm_per_unit` is the unit of its lengths; `size_px` the pictures' width and
    height; `poses` tells where the cameras stand; `drop_k3` lets a format without k3 leave it out.
    """

    names: tuple[str, ...] = ()
    mm_per_unit: float | None = None
    size_px: tuple[int, int] | None = None
    poses: CameraSet | None = None
    drop_k3: bool = False


class Format(Protocol):
    """A module of this package."""

    def read(self, files: Sequence[Path], choices: Choices) -> Calibration:
        """The cameras in these files; raises CalibrationFileError."""
        ...

    def write(self, out: Path, calibration: Calibration, choices: Choices) -> Calibration:
        """Write them; what is handed back carries notes of what was left out. Raises CalibrationFileError."""
        ...


def camera(
    source: str, name: str, size_px: Sequence[float], intrinsics: Any, distortion: Any, camera_from_rig: Any
) -> CalibratedCamera:
    """A camera as a file describes it; raises CalibrationFileError beginning with `source` for what cannot be."""
    width, height = (int(side) for side in size_px)
    try:
        known = CameraCalibration(
            camera=name,
            width_px=width,
            height_px=height,
            intrinsics=numbers(source, f"camera {name}: intrinsics", intrinsics, (3, 3)),
            distortion=five_terms(source, name, distortion),
            camera_from_robot=numbers(source, f"camera {name}: pose", camera_from_rig, (4, 4)),
        )
    except InvalidMessageError as error:
        raise CalibrationFileError(f"{source}: {error}") from error
    if known.intrinsics[0, 1]:
        raise CalibrationFileError(
            f"{source}: camera {name} has a skew of {known.intrinsics[0, 1]:g} px, which sensing does not know; "
            "calibrate without estimating skew"
        )
    return CalibratedCamera.of(known, known.camera_from_robot)


def five_terms(source: str, name: str, distortion: Any) -> Array:
    """OpenCV's [k1, k2, p1, p2, k3]; terms of larger models must be zero. Raises CalibrationFileError."""
    terms = numbers(source, f"camera {name}: distortion", distortion, None).ravel()
    beyond = terms[TERMS:]
    if beyond.any():
        model = next((name for count, name in LARGER_MODELS.items() if terms.size <= count), "larger")
        raise CalibrationFileError(
            f"{source}: camera {name} has {terms.size} distortion terms, OpenCV's {model} model; sensing knows k1, k2, p1, p2 "
            "and k3: calibrate with these alone"
        )
    return np.concatenate([terms[:TERMS], np.zeros(max(TERMS - terms.size, 0))])


def numbers(source: str, what: str, values: Any, shape: tuple[int, ...] | None) -> Array:
    """Finite numbers of this shape; raises CalibrationFileError."""
    wanted = "numbers" if shape is None else f"{' x '.join(map(str, shape))} numbers"
    try:
        array = np.asarray(values, dtype=np.float64)
        array = array if shape is None else array.reshape(shape)
    except (TypeError, ValueError) as error:
        raise CalibrationFileError(f"{source}: {what} should be {wanted}: {error}") from error
    if not np.isfinite(array).all():
        raise CalibrationFileError(f"{source}: {what} should be {wanted}; not all of them are finite")
    return array


def pose(rotation: Array, translation_mm: Array) -> Array:
    """(4, 4) of a rotation (3, 3) and a translation of three numbers."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, np.ravel(translation_mm)
    return matrix


def placed(source: str, choices: Choices, names: Sequence[str]) -> list[Array]:
    """`camera_from_rig` of each of these cameras, out of the poses that were given apart; raises CalibrationFileError.

    The first of the cameras makes the rig frame.
    """
    if choices.poses is None:
        raise CalibrationFileError(
            f"{source}: it does not say where the cameras {', '.join(names)} stand among one another; give a calibration "
            "that does with --poses FILE, or begin with `nodal calibrate cameras`"
        )
    known = {camera.name: np.array(camera.camera_from_rig) for camera in choices.poses.cameras}
    if missing := [name for name in names if name not in known]:
        raise CalibrationFileError(
            f"{source}: --poses has no camera {', '.join(missing)}, only {', '.join(known)}; --names names them"
        )
    rig_from_first = np.linalg.inv(known[names[0]])
    return [known[name] @ rig_from_first for name in names]


def named(source: str, choices: Choices, own: Sequence[str]) -> tuple[str, ...]:
    """The cameras' names: those that were given, or the file's own. Raises CalibrationFileError."""
    names = choices.names or tuple(own)
    if len(names) != len(own) or len(set(names)) != len(names):
        raise CalibrationFileError(
            f"{source}: it holds {len(own)} cameras, which cannot be called {', '.join(names)}"
        )
    return names


def two_cameras(form: str, calibration: Calibration) -> tuple[CalibratedCamera, CalibratedCamera]:
    """Both; raises CalibrationFileError where a format's pair cannot hold them."""
    cameras = calibration.cameras.cameras
    if len(cameras) != 2:
        raise CalibrationFileError(
            f"a calibration of {len(cameras)} cameras does not fit into the format {form}, which holds two; kalibr holds any number"
        )
    return cameras[0], cameras[1]


def text_of(file: Path) -> str:
    """The file's text; raises CalibrationFileError."""
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise CalibrationFileError(f"{file}: not a text file: {error}") from error


def write_text(file: Path, text: str) -> None:
    """Write it; raises CalibrationFileError."""
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be written: {error.strerror}") from error
