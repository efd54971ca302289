"""What `nodal calibrate background` is worth: node errors without it, with its pictures, and with its work area too.

`python -m benchmarks.background [--photographs FOLDER] [--poses N]`: random poses of the simulated robot, and photographs with
exact truth if there are any; every pose is estimated without a prior.
"""

import argparse
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.photographs import photographed_rig, photographs
from benchmarks.poses import LENGTH_MM, Array, centreline, photograph, random_bends, renderers
from benchmarks.scoring import Score
from drivers.simulated.cameras.rig import default_cameras
from messaging.frames import CameraCalibration
from nodal.calibrate.background.area import Reach
from nodal.calibrate.background.judging import judged
from nodal.calibrate.background.keeping import coded
from nodal.calibrate.background.statistics import Pictures
from sensing.geometry.camera import Camera
from sensing.method import METHODS
from sensing.pictures.picture import Picture
from sensing.scene import Scene
from sensing.settings import HOLDER_RADIUS_MM, MethodName

PICTURES = 30
REACH = Reach(length_mm=LENGTH_MM, travel_mm=(0.0, 0.0), holder_radius_mm=HOLDER_RADIUS_MM)


@dataclass(frozen=True, eq=False)
class Pose:
    """Coded pictures of the robot, pictures without it, and the true centreline (81, 3)."""

    pictures: Mapping[str, bytes]
    empty: Mapping[str, list[bytes]]
    truth_mm: Array


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--photographs", type=Path, help="a folder of photographs with exact truth")
    parser.add_argument(
        "--poses", type=int, default=20, help="random poses of the simulated robot (default 20)"
    )
    arguments = parser.parse_args()
    print(f"{'pictures':<14}{'background':<26}{'estimated':>10}{'mean mm':>9}{'95 % mm':>9}{'tip mm':>8}")
    _table("simulated", default_cameras(), list(_simulated(arguments.poses)))
    if arguments.photographs:
        _table(
            "photographs", photographed_rig(arguments.photographs), list(_photographed(arguments.photographs))
        )


def _simulated(poses: int) -> Iterator[Pose]:
    cameras, random = renderers(default_cameras()), np.random.default_rng(1)
    empty = {name: [one.render_empty(np.zeros(3)) for _ in range(PICTURES)] for name, one in cameras.items()}
    for _ in range(poses):
        points_mm = centreline(random_bends(random))
        yield Pose(photograph(cameras, points_mm), empty, points_mm)


def _photographed(folder: Path) -> Iterator[Pose]:
    for one in photographs(folder):
        empty = {name: [picture] for name, picture in one.backgrounds.items()}
        yield Pose(one.pictures, empty, one.truth_mm)


def _table(label: str, rig: tuple[CameraCalibration, ...], poses: list[Pose]) -> None:
    for what, with_picture, with_area in (
        ("none", False, False),
        ("pictures", True, False),
        ("pictures and work area", True, True),
    ):
        score = Score()
        for pose in poses:
            scene = _scene(rig, pose, with_picture=with_picture, with_area=with_area)
            pictures = {name: scene.picture(name, data) for name, data in pose.pictures.items()}
            method = METHODS[MethodName.REFINED](scene)
            score.add(lambda: method.estimate(pictures, 0.0, None, time.perf_counter), pose.truth_mm)  # noqa: B023
        error = score.error_mm
        print(
            f"{label:<14}{what:<26}{f'{len(score.trusted)}/{len(poses)}':>10}{error.mean():9.4f}"
            f"{np.quantile(error, 0.95):9.4f}{error[:, -1].mean():8.4f}"
        )


def _scene(rig: tuple[CameraCalibration, ...], pose: Pose, *, with_picture: bool, with_area: bool) -> Scene:
    backgrounds, areas = {}, {}
    for calibration in rig if with_picture else ():
        name, camera, pictures = calibration.camera, Camera(calibration), Pictures()
        for data in pose.empty[name]:
            pictures.add(Picture(name, data, camera.size_px).colour)
        statistics = pictures.statistics()
        backgrounds[name] = coded(statistics.mean)
        area = judged(name, statistics, camera, REACH, 0.0).work_area
        if with_area and area is not None:
            areas[name] = np.array(area)
    return Scene.of(rig, backgrounds=backgrounds, length_mm=LENGTH_MM, work_areas=areas)


if __name__ == "__main__":
    main()
