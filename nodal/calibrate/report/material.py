"""What a calibration report is made of: all that lies in the folder of the calibration."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar
from xml.etree.ElementTree import Element

import msgspec
import numpy as np
from numpy.typing import NDArray

from calibration.camera_set import CameraSet
from nodal.bench_file import BenchFile
from nodal.calibrate.cameras.kept_views import KeptViews, kept_pictures, kept_views
from nodal.calibration.folder import calibration_folder, load_cameras
from nodal.calibration.formats.calibration import Calibration
from nodal.calibration.show import of_bench
from nodal.calibration.show.figures import Figures, figures
from nodal.errors import CalibrationFileError
from nodal.report.page.markup import figure
from nodal.report.page.overlaid import picture_svg
from nodal.report.pictures.views import decoded

T = TypeVar("T")
HIGHEST_PX = 480


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

    def found(self, name: str, kind: type[T]) -> T | None:
        """What a step left in this file of the folder; None where there is none. Raises CalibrationFileError."""
        file = self.folder / name
        if not file.exists():
            return None
        try:
            return msgspec.json.decode(file.read_bytes(), type=kind)
        except (OSError, msgspec.DecodeError) as error:
            raise CalibrationFileError(f"{file}: not what calibration writes: {error}") from error

    def drawn(self, names: str) -> list[Element]:
        """A figure of each camera's picture that a step left in the folder; `names` has `{}` for the camera. Raises ReportError."""
        files = {camera.name: self.folder / names.format(camera.name) for camera in self.cameras.cameras}
        return [
            figure(
                picture_svg(decoded(name, file.read_bytes()), f"camera {name}", highest_px=HIGHEST_PX), name
            )
            for name, file in files.items()
            if file.exists()
        ]


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
