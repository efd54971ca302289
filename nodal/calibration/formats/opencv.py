"""OpenCV's FileStorage, YAML or XML, as its samples write calibrations.

Two cameras as samples/cpp/stereo_calib.cpp and its kin do: M1, D1, M2, D2 (or K1, K2, cameraMatrix1, distCoeffs1 and so on) with
R and T, `x_2 = R @ x_1 + T`, in one file or in two (intrinsics.yml and extrinsics.yml). One camera a file as
samples/cpp/tutorial_code/calib3d/camera_calibration does: camera_matrix, distortion_coefficients, image_width, image_height.
The unit of T is whatever the board's squares were given in; the sample's files say no size of pictures.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from calibration.camera_set import CameraSet
from nodal.calibration.formats.calibration import (
    Calibration,
    Choices,
    camera,
    named,
    numbers,
    placed,
    pose,
    text_of,
    two_cameras,
)
from nodal.errors import CalibrationFileError

INTRINSICS = ("K{}", "M{}", "cameraMatrix{}", "camera_matrix_{}", "camera_matrix{}")
DISTORTION = ("D{}", "distCoeffs{}", "dist_coeffs_{}", "distortion_coefficients{}")
SIZES = ("image_size", "imageSize", "size", "img_size")
NAMES = "camera_names"
"""A key of our own, which keeps the names; OpenCV's readers pass over it."""

Entries = Mapping[str, Any]


def read(files: Sequence[Path], choices: Choices) -> Calibration:
    """A stereo pair, or one camera a file; raises CalibrationFileError."""
    contents = [_entries(file) for file in files]
    together = {key: value for content in contents for key, value in content.items()}
    source = ", ".join(map(str, files))
    if together.get("fisheye_model"):
        raise CalibrationFileError(f"{source}: a fisheye model, which sensing does not know")
    if _first(together, INTRINSICS, 1) is not None:
        return _pair(source, together, choices)
    return _singles(source, [str(file) for file in files], contents, choices)


def write(out: Path, calibration: Calibration, choices: Choices) -> Calibration:
    """A stereo pair in one file; raises CalibrationFileError."""
    first, second = two_cameras("opencv", calibration)
    if out.suffix.lower() not in (".yml", ".yaml", ".xml"):
        raise CalibrationFileError(f"{out}: OpenCV's files end in .yml, .yaml or .xml")
    unit_mm = choices.mm_per_unit or 1.0
    second_from_first = np.array(second.camera_from_rig) @ np.linalg.inv(first.camera_from_rig)
    storage = cv2.FileStorage(str(out), cv2.FILE_STORAGE_WRITE)
    if not storage.isOpened():
        raise CalibrationFileError(f"{out}: cannot be written")
    for number, one in ((1, first), (2, second)):
        storage.write(f"M{number}", np.array(one.intrinsics))
        storage.write(f"D{number}", np.array([one.distortion]))
    storage.write("R", second_from_first[:3, :3])
    storage.write("T", second_from_first[:3, 3:] / unit_mm)
    if (first.width_px, first.height_px) == (second.width_px, second.height_px):
        storage.write("image_width", first.width_px)
        storage.write("image_height", first.height_px)
    else:
        for number, one in ((1, first), (2, second)):
            storage.write(f"image_size{number}", np.array([[one.width_px, one.height_px]], dtype=np.int32))
    storage.startWriteStruct(NAMES, cv2.FileNode_SEQ)
    for one in (first, second):
        storage.write("", one.name)
    storage.endWriteStruct()
    storage.release()
    lost = () if calibration.rig_from_robot is None else ("the robot frame is left out",)
    return replace(calibration, notes=(*calibration.notes, *lost, f"T is in units of {unit_mm:g} mm"))


def _pair(source: str, entries: Entries, choices: Choices) -> Calibration:
    unit_mm = choices.mm_per_unit or 1.0
    names = named(source, choices, entries.get(NAMES) or ("camera1", "camera2"))
    rotation, translation = entries.get("R"), entries.get("T")
    if rotation is None or translation is None:
        poses = placed(source, choices, names)
        notes: tuple[str, ...] = ()
    else:
        turn = numbers(source, "R", rotation, None)
        matrix = numbers(source, "R", cv2.Rodrigues(turn)[0] if turn.size == 3 else turn, (3, 3))
        poses = [np.eye(4), pose(matrix, unit_mm * numbers(source, "T", translation, (3,)))]
        notes = () if choices.mm_per_unit else ("T is taken to be in mm; --units says otherwise",)
    cameras = tuple(
        camera(
            source,
            name,
            _size(source, entries, number, choices),
            _wanted(source, entries, INTRINSICS, number),
            _wanted(source, entries, DISTORTION, number),
            where,
        )
        for number, (name, where) in enumerate(zip(names, poses, strict=True), start=1)
    )
    return Calibration(cameras=CameraSet(cameras=cameras), notes=notes)


def _singles(source: str, files: Sequence[str], contents: Sequence[Entries], choices: Choices) -> Calibration:
    for file, content in zip(files, contents, strict=True):
        if "camera_matrix" not in content or "distortion_coefficients" not in content:
            raise CalibrationFileError(
                f"{file}: neither a stereo pair (M1, D1, M2, D2, R, T) nor one camera (camera_matrix, distortion_coefficients); "
                f"it holds {', '.join(content) or 'nothing'}"
            )
    names = named(source, choices, [Path(file).stem for file in files])
    cameras = tuple(
        camera(
            file,
            name,
            _size(file, content, 1, choices),
            content["camera_matrix"],
            content["distortion_coefficients"],
            where,
        )
        for file, name, content, where in zip(
            files, names, contents, placed(source, choices, names), strict=True
        )
    )
    return Calibration(cameras=CameraSet(cameras=cameras), notes=("where the cameras stand is of --poses",))


def _entries(file: Path) -> dict[str, Any]:
    text = text_of(file)
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        root = storage.root()
        return {key: _value(root.getNode(key)) for key in root.keys()}  # noqa: SIM118  a FileNode is no mapping
    except (cv2.error, SystemError) as error:
        raise CalibrationFileError(f"{file}: not a file of OpenCV's FileStorage: {error}") from error


def _value(node: cv2.FileNode) -> Any:
    if node.isMap():
        return node.mat() if "data" in node.keys() else None  # noqa: SIM118
    if node.isSeq():
        return [_value(node.at(index)) for index in range(int(node.size()))]
    return node.string() if node.isString() else node.real()


def _first(entries: Entries, patterns: Sequence[str], number: int) -> Any:
    found = (entries.get(pattern.format(number)) for pattern in patterns)
    return next((value for value in found if value is not None), None)


def _wanted(source: str, entries: Entries, patterns: Sequence[str], number: int) -> Any:
    value = _first(entries, patterns, number)
    if value is None:
        names = " or ".join(pattern.format(number) for pattern in patterns)
        raise CalibrationFileError(f"{source}: there is no {names}, only {', '.join(entries)}")
    return value


def _size(source: str, entries: Entries, number: int, choices: Choices) -> Sequence[float]:
    sizes = [entries.get(key) for key in (f"image_size{number}", *SIZES)]
    sizes.append([entries[key] for key in ("image_width", "image_height") if key in entries] or None)
    sizes.append(choices.size_px)
    size = next((size for size in sizes if size is not None), None)
    if size is None:
        raise CalibrationFileError(
            f"{source}: the size of the pictures is not in it; give it with --size 1920x1080"
        )
    width, height = numbers(source, "the pictures' size", size, (2,))
    return width, height
