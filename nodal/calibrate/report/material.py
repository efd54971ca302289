"""What a calibration report is made of: all that lies in the folder of the calibration."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.camera_set import CameraSet
from nodal.bench_file import BenchFile
from nodal.calibrate.kept_views import KeptViews, kept_pictures, kept_views
from nodal.calibration.folder import calibration_folder, load_cameras
from nodal.calibration.formats.calibration import Calibration
from nodal.calibration.show import of_bench
from nodal.calibration.show_figures import Figures, figures
from nodal.report.pictures.views import decoded


@dataclasses.dataclass(frozen=True, kw_only=True)
class Material:
    """`calibration` knows the robot frame if it was found for these very cameras; `pictures` are files by view and camera."""

    bench: BenchFile
    folder: Path
    calibration: Calibration
    figures: Figures
    kept: KeptViews
    pictures: Mapping[str, Mapping[str, Path]]

    @property
    def cameras(self) -> CameraSet:
        """The cameras among one another."""
        return self.calibration.cameras

    def picture(self, view: str, camera: str) -> NDArray[np.uint8]:
        """(H, W, 3) in RGB; raises ReportError."""
        return decoded(camera, self.pictures[view][camera].read_bytes())


def material(bench: BenchFile) -> Material:
    """Read it; raises CalibrationFileError when there are no cameras, or for a file that is none of ours."""
    folder, cameras = calibration_folder(bench), load_cameras(bench)
    known = of_bench(bench)
    calibration = known if known.cameras == cameras else Calibration(cameras=cameras)
    return Material(
        bench=bench,
        folder=folder,
        calibration=calibration,
        figures=figures(calibration, bench.settings.robot.length_mm),
        kept=kept_views(folder),
        pictures=kept_pictures(folder, (camera.name for camera in cameras.cameras)),
    )
