"""Kalibr's camchain: cam0, cam1, and so on, each placed from the one before it.

Source: https://github.com/ethz-asl/kalibr/wiki/yaml-formats and .../wiki/supported-models. `pinhole` has [fu, fv, pu, pv], `radtan`
[k1, k2, p1, p2] as OpenCV has them; T_cn_cnm1 takes coordinates of camera n-1 to camera n, with lengths in m.
"""

from collections.abc import Iterator, Sequence
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
    pose,
    write_text,
)
from nodal.calibration.formats.yaml_file import dumped, entry, mapping_in
from nodal.errors import CalibrationFileError

MM_PER_M = 1000.0


def read(files: Sequence[Path], choices: Choices) -> Calibration:
    """A chain of two cameras or more; raises CalibrationFileError."""
    (file,) = files
    content = mapping_in(file)
    chain = [content[f"cam{number}"] for number in range(len(content)) if f"cam{number}" in content]
    if len(chain) < 2:
        raise CalibrationFileError(f"{file}: a camchain of two cameras or more has cam0, cam1, ...")
    names = named(str(file), choices, [f"cam{number}" for number in range(len(chain))])
    cameras = tuple(
        _camera(f"{file}: cam{number}", name, one, where)
        for number, (name, one, where) in enumerate(zip(names, chain, _places(str(file), chain), strict=True))
    )
    return Calibration(cameras=CameraSet(cameras=cameras), notes=("lengths are in m, as Kalibr has them",))


def write(out: Path, calibration: Calibration, choices: Choices) -> Calibration:
    """A chain; raises CalibrationFileError for a k3, which it cannot hold, unless that may be dropped."""
    content: dict[str, Any] = {}
    notes = list(calibration.notes)
    before: Array | None = None
    for number, one in enumerate(calibration.cameras.cameras):
        notes.extend(_without_k3(out, one, choices))
        (fx, _, cx), (_, fy, cy), _ = one.intrinsics
        chain: dict[str, Any] = {}
        where = np.array(one.camera_from_rig)
        if before is not None:
            step = where @ np.linalg.inv(before)
            chain["T_cn_cnm1"] = pose(step[:3, :3], step[:3, 3] / MM_PER_M).tolist()
        before = where
        content[f"cam{number}"] = chain | {
            "camera_model": "pinhole",
            "distortion_coeffs": list(one.distortion[:4]),
            "distortion_model": "radtan",
            "intrinsics": [fx, fy, cx, cy],
            "resolution": [one.width_px, one.height_px],
            "rostopic": f"/{one.name}/image_raw",
        }
    write_text(out, dumped(content))
    if calibration.rig_from_robot is not None:
        notes.append("the robot frame is left out")
    return replace(calibration, notes=tuple(notes))


def _places(source: str, chain: Sequence[Any]) -> Iterator[Array]:
    where = np.eye(4)
    yield where
    for number, one in enumerate(chain[1:], start=1):
        label = f"{source}: cam{number}"
        step = numbers(label, "T_cn_cnm1", entry(label, one, "T_cn_cnm1"), (4, 4))
        where = pose(step[:3, :3], MM_PER_M * step[:3, 3]) @ where
        yield where


def _camera(source: str, name: str, one: Any, where: Array) -> CalibratedCamera:
    model, lens = entry(source, one, "camera_model"), entry(source, one, "distortion_model")
    if model != "pinhole" or lens not in ("radtan", "none"):
        raise CalibrationFileError(
            f"{source}: camera_model {model} with distortion_model {lens}; sensing knows pinhole with radtan alone"
        )
    fx, fy, cx, cy = numbers(source, "intrinsics", entry(source, one, "intrinsics"), (4,))
    terms = [0.0] * 4 if lens == "none" else entry(source, one, "distortion_coeffs")
    size = numbers(source, "resolution", entry(source, one, "resolution"), (2,))
    return camera(source, name, size.tolist(), [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], terms, where)


def _without_k3(out: Path, one: CalibratedCamera, choices: Choices) -> Iterator[str]:
    if not one.distortion[4]:
        return
    intrinsics = np.array(one.intrinsics)
    corner = np.array([0.0, 0.0]) - intrinsics[:2, 2]
    ideal = np.array([[*(corner / intrinsics[[0, 1], [0, 1]]), 1.0]])
    with_k3, without = (
        cv2.projectPoints(ideal, np.zeros(3), np.zeros(3), intrinsics, np.array(terms))[0]
        for terms in (one.distortion, one.distortion[:4])
    )
    costs = f"{float(np.linalg.norm(with_k3 - without)):.2g} px in the picture's corner"
    if not choices.drop_k3:
        raise CalibrationFileError(
            f"{out}: camera {one.name} has k3 = {one.distortion[4]:g}, which Kalibr's radtan cannot hold; leaving it out, which "
            f"--drop-k3 allows, costs {costs}. Better calibrate without k3"
        )
    yield f"camera {one.name}: k3 is left out, which costs {costs}"
