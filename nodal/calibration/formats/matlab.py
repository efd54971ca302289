"""MATLAB: `toStruct` of a stereoParameters object, saved as a variable in a .mat file up to version 7.

Source: MathWorks, Computer Vision Toolbox: stereoParameters, cameraParameters, stereoParametersToOpenCV. A point is a row there:
`x_2 = x_1 @ RotationOfCamera2 + TranslationOfCamera2`, and IntrinsicMatrix is the transpose of K; since R2022b there are K, and
PoseCamera2 (rigidtform3d) for points as columns. The first pixel's centre is at (1, 1), so OpenCV's principal point is less by 1
both ways. ImageSize is [rows, columns], RadialDistortion k1, k2 and maybe k3, TangentialDistortion p1, p2 as in OpenCV.
"""

import io
import pickle
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat
from scipy.io.matlab import MatReadError, matfile_version

from calibration.camera_set import CalibratedCamera, CameraSet
from nodal.calibration.formats.calibration import (
    Array,
    Calibration,
    Choices,
    camera,
    named,
    numbers,
    pose,
    two_cameras,
)
from nodal.errors import CalibrationFileError

WORLD_UNITS_MM = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 1.0),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 10.0),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1000.0),
    **dict.fromkeys(("in", "inch", "inches"), 25.4),
}
CAMERAS = "CameraParameters1", "CameraParameters2"
FIRST_PIXEL = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
"""How much further K's principal point is in MATLAB."""
HDF_VERSION = 2
"""scipy's number for version 7.3."""
LOADING = (
    "import io, pickle, sys; from scipy.io import loadmat; "
    "pickle.dump(loadmat(io.BytesIO(sys.stdin.buffer.read()), simplify_cells=True), sys.stdout.buffer)"
)
AS_STRUCT = "in MATLAB: s = toStruct(stereoParams); save('stereo.mat', 's', '-v7')"

Fields = Mapping[str, Any]


def read(files: Sequence[Path], choices: Choices) -> Calibration:
    """The stereo pair in the file; raises CalibrationFileError."""
    (file,) = files
    source = str(file)
    fields = _stereo_struct(file)
    names = named(source, choices, ("camera1", "camera2"))
    second_from_first = _pose(source, fields)
    unit_mm, note = _unit(source, fields, choices)
    second_from_first[:3, 3] *= unit_mm
    cameras = tuple(
        _camera(
            f"{source}: CameraParameters{number}",
            name,
            _part(source, fields, f"CameraParameters{number}"),
            where,
        )
        for number, (name, where) in enumerate(
            zip(names, (np.eye(4), second_from_first), strict=True), start=1
        )
    )
    return Calibration(cameras=CameraSet(cameras=cameras), notes=(note,))


def write(out: Path, calibration: Calibration, choices: Choices) -> Calibration:
    """The variable `stereoParams`, of which `stereoParameters(stereoParams)` makes the object; raises CalibrationFileError."""
    first, second = two_cameras("matlab", calibration)
    unit_mm = choices.mm_per_unit or 1.0
    step = np.array(second.camera_from_rig) @ np.linalg.inv(first.camera_from_rig)
    words = {1.0: "millimeters", 10.0: "centimeters", 1000.0: "meters"}[unit_mm]
    content = {
        "CameraParameters1": _struct(first, words),
        "CameraParameters2": _struct(second, words),
        "RotationOfCamera2": step[:3, :3].T,
        "TranslationOfCamera2": step[None, :3, 3] / unit_mm,
        "Version": _version(),
        "RectificationParams": {
            "Initialized": False,
            "H1": np.eye(3),
            "H2": np.eye(3),
            "R1": np.eye(3),
            "R2": np.eye(3),
            "CameraMatrix1": np.eye(4, 3),
            "CameraMatrix2": np.eye(4, 3),
            "Q": np.eye(4),
            "XBounds": np.zeros((1, 2)),
            "YBounds": np.zeros((1, 2)),
            "OriginalImageSize": np.zeros((1, 2)),
            "OutputView": "valid",
        },
    }
    try:
        savemat(out, {"stereoParams": content}, long_field_names=True, oned_as="row", appendmat=False)
    except OSError as error:
        raise CalibrationFileError(f"{out}: cannot be written: {error.strerror}") from error
    lost = () if calibration.rig_from_robot is None else ("the robot frame is left out",)
    return replace(
        calibration,
        notes=(*calibration.notes, *lost, f"the cameras {first.name} and {second.name} are 1 and 2 there"),
    )


def _stereo_struct(file: Path) -> Fields:
    content = _content(file)
    for candidate in (content, *content.values()):
        if isinstance(candidate, dict) and all(isinstance(candidate.get(part), dict) for part in CAMERAS):
            return candidate
    held = ", ".join(name for name in content if not name.startswith("__")) or "nothing that can be read"
    raise CalibrationFileError(
        f"{file}: no struct with CameraParameters1 and CameraParameters2 in it, but {held}; an object has to be made a struct, {AS_STRUCT}"
    )


def _content(file: Path) -> dict[str, Any]:
    """The variables of a .mat file by name, loaded by a process of its own: damaged files bring scipy's loader down with it."""
    try:
        data = file.read_bytes()
        version, _ = matfile_version(io.BytesIO(data))
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be read: {error.strerror}") from error
    except (MatReadError, ValueError) as error:
        raise CalibrationFileError(f"{file}: not a .mat file: {error}") from error
    if version == HDF_VERSION:
        raise CalibrationFileError(
            f"{file}: saved as version 7.3, which is not read here; save it as version 7, {AS_STRUCT}"
        )
    loaded = subprocess.run(  # noqa: S603  our own words alone
        [sys.executable, "-P", "-c", LOADING], input=data, capture_output=True, check=False
    )
    if loaded.returncode:
        reason = loaded.stderr.decode(errors="replace").strip().splitlines()
        raise CalibrationFileError(
            f"{file}: a damaged .mat file: {reason[-1] if reason else 'it brings the loader down'}"
        )
    content: dict[str, Any] = pickle.loads(loaded.stdout)  # noqa: S301  what our own process made
    return content


def _part(source: str, fields: Fields, key: str) -> Any:
    if key not in fields:
        raise CalibrationFileError(f"{source}: {key} is missing; it holds {', '.join(fields)}")
    return fields[key]


def _pose(source: str, fields: Fields) -> Array:
    """`second_from_first` (4, 4), in the file's units."""
    if "RotationOfCamera2" in fields:
        rotation = numbers(source, "RotationOfCamera2", fields["RotationOfCamera2"], (3, 3))
        along = numbers(source, "TranslationOfCamera2", _part(source, fields, "TranslationOfCamera2"), (3,))
        return pose(rotation.T, along)
    found = _part(source, fields, "PoseCamera2")
    if isinstance(found, dict):
        if "R" in found and "Translation" in found:
            rotation = numbers(source, "PoseCamera2.R", found["R"], (3, 3))
            return pose(rotation, numbers(source, "PoseCamera2.Translation", found["Translation"], (3,)))
        found = found.get("A")
    return numbers(source, "PoseCamera2", found, (4, 4)).copy()


def _unit(source: str, fields: Fields, choices: Choices) -> tuple[float, str]:
    said = str(_part(source, fields, "CameraParameters1").get("WorldUnits", "")).strip().lower()
    if choices.mm_per_unit is not None:
        return choices.mm_per_unit, f"lengths are in units of {choices.mm_per_unit:g} mm, as --units says"
    if said not in WORLD_UNITS_MM:
        raise CalibrationFileError(f"{source}: WorldUnits are {said!r}; say with --units what they are")
    return WORLD_UNITS_MM[said], f"lengths are in {said}, as WorldUnits says"


def _camera(source: str, name: str, fields: Fields, where: Array) -> CalibratedCamera:
    if "K" in fields:
        intrinsics = numbers(source, "K", fields["K"], (3, 3))
    else:
        intrinsics = numbers(source, "IntrinsicMatrix", _part(source, fields, "IntrinsicMatrix"), (3, 3)).T
    radial = numbers(source, "RadialDistortion", _part(source, fields, "RadialDistortion"), None).ravel()
    if radial.size not in (2, 3):
        raise CalibrationFileError(
            f"{source}: {radial.size} coefficients of RadialDistortion; sensing knows k1, k2 and k3: calibrate with 2 or 3"
        )
    tangential = numbers(source, "TangentialDistortion", _part(source, fields, "TangentialDistortion"), (2,))
    rows, columns = numbers(source, "ImageSize", _part(source, fields, "ImageSize"), (2,))
    terms = [*radial[:2], *tangential, *radial[2:]]
    return camera(source, name, (columns, rows), intrinsics - FIRST_PIXEL, terms, where)


def _struct(one: CalibratedCamera, units: str) -> dict[str, Any]:
    """A camera as cameraParameters' toStruct lays it out: K for R2022b and later, IntrinsicMatrix for earlier ones."""
    k1, k2, p1, p2, k3 = one.distortion
    intrinsics = np.array(one.intrinsics) + FIRST_PIXEL
    return {
        "RadialDistortion": np.array([[k1, k2, k3]]),
        "TangentialDistortion": np.array([[p1, p2]]),
        "ImageSize": np.array([[one.height_px, one.width_px]], dtype=np.float64),
        "WorldPoints": np.zeros((0, 2)),
        "WorldUnits": units,
        "EstimateSkew": False,
        "NumRadialDistortionCoefficients": 3.0,
        "EstimateTangentialDistortion": True,
        "RotationVectors": np.zeros((0, 3)),
        "TranslationVectors": np.zeros((0, 3)),
        "ReprojectionErrors": np.zeros((0, 2, 0)),
        "DetectedKeypoints": np.zeros((0, 0), dtype=bool),
        "K": intrinsics,
        "IntrinsicMatrix": intrinsics.T,
        "Version": _version(),
    }


def _version() -> dict[str, str]:
    return {"Name": "", "Version": "", "Release": "", "Date": ""}
