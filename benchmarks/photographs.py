"""A folder of photographs with exact truth, as benchmarks read it.

It holds calibration.json, pairs/, truth/, sequence/ with truth/, and background/, laid out as the README.md beside them says.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.poses import Array
from messaging.frames import CameraCalibration
from nodal.calibration_file import rig_from_matrices


@dataclass(frozen=True)
class Photograph:
    """What the cameras saw of one pose: coded pictures with and without the robot by camera, and where it truly was.

    `truth_mm` (81, 3) has a point for each mm of arc length from base to tip, in the robot frame.
    """

    label: str
    pictures: dict[str, bytes]
    backgrounds: dict[str, bytes]
    truth_mm: Array


def photographed_rig(folder: Path) -> tuple[CameraCalibration, ...]:
    """The cameras as they truly are."""
    known = json.loads((folder / "calibration.json").read_text())
    cameras = known["cameras"]
    return rig_from_matrices(
        tuple(known["image_size"]),
        {name: camera["K"] for name, camera in cameras.items()},
        {name: camera["dist"] for name, camera in cameras.items()},
        {name: camera["camera_from_robot"] for name, camera in cameras.items()},
    )


def photographs(folder: Path) -> Iterator[Photograph]:
    """Every pose in the folder: static ones, then the sequence."""
    names = [camera.camera for camera in photographed_rig(folder)]
    for pictures, truth in (
        (folder / "pairs", folder / "truth"),
        (folder / "sequence", folder / "sequence" / "truth"),
    ):
        for exact in sorted(truth.glob("*.npz")):
            known = json.loads(exact.with_suffix(".json").read_text())
            with np.load(exact) as arrays:
                truth_mm = arrays["centreline"][::10]
            yield Photograph(
                label=f"{pictures.name}/{exact.stem} {known['shape']} {known['variant']}",
                pictures={name: (pictures / f"{exact.stem}_{name}.jpg").read_bytes() for name in names},
                backgrounds={
                    name: (folder / "background" / f"{known['variant']}_0_{name}.jpg").read_bytes()
                    for name in names
                },
                truth_mm=truth_mm,
            )
