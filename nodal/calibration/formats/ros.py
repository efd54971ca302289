"""ROS camera_info files, YAML, one a camera.

Source: sensor_msgs/CameraInfo, and the files that camera_calibration and camera_calibration_parsers write: image_width, image_height,
camera_name, camera_matrix, distortion_model (plumb_bob is OpenCV's k1, k2, p1, p2, k3), distortion_coefficients, rectification_matrix,
projection_matrix. Where cameras stand is not in such a file; but the two of a rectified stereo pair say it together: with R and
P = [K' | (-fx' b, ..., 0)] of each, `R_2 @ x_2 = R_1 @ x_1 + (P_2[:2, 3] - P_1[:2, 3]) / fx'`, in m.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from calibration.camera_set import CalibratedCamera, CameraSet
from nodal.calibration.formats.calibration import (
    Array,
    Calibration,
    Choices,
    camera,
    named,
    numbers,
    placed,
    pose,
    write_text,
)
from nodal.calibration.formats.yaml_file import dumped, entry, mapping_in
from nodal.errors import CalibrationFileError

MM_PER_M = 1000.0


def read(files: Sequence[Path], choices: Choices) -> Calibration:
    """A camera a file; two of a rectified pair, or any with poses given apart. Raises CalibrationFileError."""
    source = ", ".join(map(str, files))
    contents = [mapping_in(file) for file in files]
    if len(files) < 2:
        raise CalibrationFileError(f"{source}: it holds one camera; name the other cameras' files beside it")
    names = named(
        source,
        choices,
        [str(content.get("camera_name") or file.stem) for content, file in zip(contents, files, strict=True)],
    )
    second_from_first = _of_pair(source, contents) if len(files) == 2 and choices.poses is None else None
    places = placed(source, choices, names) if second_from_first is None else [np.eye(4), second_from_first]
    cameras = tuple(
        _camera(str(file), name, content, where)
        for file, name, content, where in zip(files, names, contents, places, strict=True)
    )
    note = (
        "where the cameras stand is of --poses"
        if second_from_first is None
        else "where the cameras stand follows from the pair's rectification; lengths are in m, as ROS has them"
    )
    return Calibration(cameras=CameraSet(cameras=cameras), notes=(note,))


def write(out: Path, calibration: Calibration, _: Choices) -> Calibration:
    """NAME.yaml for each camera into the folder `out`; two cameras as a rectified pair. Raises CalibrationFileError."""
    cameras = calibration.cameras.cameras
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CalibrationFileError(
            f"{out}: cannot be made: {error.strerror}; it is to be a folder"
        ) from error
    pair = len(cameras) == 2
    rectified = _rectified(*cameras) if pair else [_alone(one) for one in cameras]
    for one, (rotation, projection) in zip(cameras, rectified, strict=True):
        content = {
            "image_width": one.width_px,
            "image_height": one.height_px,
            "camera_name": one.name,
            "camera_matrix": _matrix(np.array(one.intrinsics)),
            "distortion_model": "plumb_bob",
            "distortion_coefficients": _matrix(np.array([one.distortion])),
            "rectification_matrix": _matrix(rotation),
            "projection_matrix": _matrix(projection),
        }
        write_text(out / f"{one.name}.yaml", dumped(content))
    notes = [*calibration.notes]
    if not pair:
        notes.append(
            "where the cameras stand is left out: ROS has it in tf, or in the rectification of a pair"
        )
    if calibration.rig_from_robot is not None:
        notes.append("the robot frame is left out")
    return replace(calibration, notes=tuple(notes))


def _camera(source: str, name: str, content: dict[str, Any], where: Array) -> CalibratedCamera:
    model = entry(source, content, "distortion_model")
    if model != "plumb_bob":
        raise CalibrationFileError(
            f"{source}: distortion_model {model}; sensing knows plumb_bob (k1, k2, p1, p2, k3) alone"
        )
    size = entry(source, content, "image_width"), entry(source, content, "image_height")
    return camera(
        source,
        name,
        numbers(source, "image_width and image_height", size, (2,)).tolist(),
        _data(source, content, "camera_matrix"),
        _data(source, content, "distortion_coefficients"),
        where,
    )


def _of_pair(source: str, contents: Sequence[dict[str, Any]]) -> Array | None:
    """`second_from_first` (4, 4) in mm of a rectified pair, None when the files are not one."""
    if not all("rectification_matrix" in one and "projection_matrix" in one for one in contents):
        return None
    rotations = [
        numbers(source, "rectification_matrix", _data(source, one, "rectification_matrix"), (3, 3))
        for one in contents
    ]
    projections = [
        numbers(source, "projection_matrix", _data(source, one, "projection_matrix"), (3, 4))
        for one in contents
    ]
    if not all(projection[0, 0] for projection in projections):
        raise CalibrationFileError(f"{source}: projection_matrix has a focal length of 0")
    baselines = [projection[:, 3] / projection[0, 0] for projection in projections]
    across = MM_PER_M * (baselines[1] - baselines[0])
    if not across.any():
        return None
    first, second = rotations
    return pose(second.T @ first, second.T @ across)


def _rectified(first: CalibratedCamera, second: CalibratedCamera) -> list[tuple[Array, Array]]:
    """R (3, 3) and P (3, 4) in px and m of each camera of a pair (cv2.stereoRectify: Bouguet's way)."""
    step = np.array(second.camera_from_rig) @ np.linalg.inv(first.camera_from_rig)
    found = cv2.stereoRectify(
        np.array(first.intrinsics),
        np.array(first.distortion),
        np.array(second.intrinsics),
        np.array(second.distortion),
        (first.width_px, first.height_px),
        step[:3, :3],
        step[:3, 3:] / MM_PER_M,
    )
    return [(np.asarray(found[0]), np.asarray(found[2])), (np.asarray(found[1]), np.asarray(found[3]))]


def _alone(one: CalibratedCamera) -> tuple[Array, Array]:
    return np.eye(3), np.hstack([np.array(one.intrinsics), np.zeros((3, 1))])


def _matrix(values: Array) -> dict[str, Any]:
    rows, cols = values.shape
    return {"rows": rows, "cols": cols, "data": values.ravel().tolist()}


def _data(source: str, content: dict[str, Any], key: str) -> Any:
    return entry(f"{source}: {key}", entry(source, content, key), "data")
