"""The views that cameras were calibrated with, kept beside the calibration: pictures, and what was found in them."""

import shutil
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from calibration.solving import Calibration, Sighting
from drivers.cameras import CameraFrame
from nodal.bench_file import make_folder
from nodal.errors import CalibrationFileError

Array = NDArray[np.float64]

VIEWS, NEW_VIEWS, REFUSED_VIEWS = "views", "views.new", "views.refused"
FOUND = "views.json"
Point = tuple[float, float]
Row4 = tuple[float, float, float, float]


class KeptSighting(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A view in one camera: corners in px, and found minus predicted at each."""

    view: str
    camera: str
    ids: tuple[int, ...]
    px: tuple[Point, ...]
    residual_px: tuple[Point, ...]

    @classmethod
    def of(cls, sighting: Sighting) -> "KeptSighting":
        """What is kept of it."""
        return cls(
            view=sighting.view,
            camera=sighting.camera,
            ids=tuple(sighting.corners.ids.tolist()),
            px=tuple(map(tuple, np.round(sighting.corners.px, 4).tolist())),
            residual_px=tuple(map(tuple, np.round(sighting.residual_px, 4).tolist())),
        )

    @property
    def rms_px(self) -> float:
        """Over both coordinates of all corners."""
        return float(np.sqrt(np.mean(np.square(self.residual_px))))


class KeptViews(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The views that were used, and where the board was in the rig frame (4, 4; mm) in each."""

    rig_from_board: dict[str, tuple[Row4, Row4, Row4, Row4]] = {}
    sightings: tuple[KeptSighting, ...] = ()

    def of_camera(self, name: str) -> list[KeptSighting]:
        """In their order."""
        return [sighting for sighting in self.sightings if sighting.camera == name]


class NewViews:
    """Views as they are taken, apart from those of the calibration in force until they replace them; if they never do, they are
    set aside, to be added to and tried again: somebody held a board for each.
    """

    def __init__(self, calibration: Path) -> None:
        """`calibration` is the folder of the calibration; views of an attempt that was cut off are set aside."""
        self._calibration = calibration
        self._folder = calibration / NEW_VIEWS
        self._set_aside()
        make_folder(self._folder, "calibration")

    def __enter__(self) -> Self:
        """Begin to take views."""
        return self

    def __exit__(self, *_: object) -> None:
        """However it ended; raises CalibrationFileError."""
        self._set_aside()

    def keep(self, view: str, frames: Iterable[CameraFrame]) -> None:
        """The cameras' own pictures of this view; raises CalibrationFileError."""
        for frame in frames:
            _write(self._folder / picture_name(view, frame.name), frame.jpeg)

    def replace_old(self, calibration: Calibration) -> None:
        """They are the views in force; raises CalibrationFileError."""
        kept = KeptViews(
            rig_from_board=msgspec.convert(
                {view: pose.tolist() for view, pose in calibration.rig_from_board.items()},
                dict[str, tuple[Row4, Row4, Row4, Row4]],
            ),
            sightings=tuple(map(KeptSighting.of, calibration.sightings)),
        )
        _write(self._folder / FOUND, msgspec.json.encode(kept))
        self._become(VIEWS)

    def _set_aside(self) -> None:
        if not self._folder.exists():
            return
        if any(self._folder.iterdir()):
            place = self._become(REFUSED_VIEWS)
            print(f"the views of an attempt that came to nothing are in {place}", file=sys.stderr, flush=True)
        else:
            self._folder.rmdir()

    def _become(self, name: str) -> Path:
        """The views that stood there stay beside them as `NAME~`."""
        place = self._calibration / name
        try:
            if place.exists():
                before = place.with_name(f"{name}~")
                shutil.rmtree(before, ignore_errors=True)
                place.rename(before)
            return self._folder.rename(place)
        except OSError as error:
            raise CalibrationFileError(f"{place}: cannot be replaced: {error.strerror}") from error


def kept_views(calibration: Path) -> KeptViews:
    """What was found in the views in force, nothing where there are none; raises CalibrationFileError."""
    file = calibration / VIEWS / FOUND
    if not file.exists():
        return KeptViews()
    try:
        return msgspec.json.decode(file.read_bytes(), type=KeptViews)
    except (OSError, msgspec.DecodeError) as error:
        raise CalibrationFileError(f"{file}: not what was found in views: {error}") from error


def kept_pictures(calibration: Path, cameras: Iterable[str]) -> Mapping[str, Mapping[str, Path]]:
    """Files by view and camera, in the order of the views."""
    found: dict[str, dict[str, Path]] = {}
    ends = {camera: picture_name("", camera) for camera in cameras}
    for camera, end in ends.items():
        for file in (calibration / VIEWS).glob(f"*{end}"):
            # a picture of camera `top_left` ends as those of `left` do
            if end == max(filter(file.name.endswith, ends.values()), key=len):
                found.setdefault(file.name.removesuffix(end), {})[camera] = file
    return dict(sorted(found.items()))


def picture_name(view: str, camera: str) -> str:
    """What the picture of a view is called, so that `--images` can tell views and cameras from it."""
    return f"{view}_{camera}.jpg"


def _write(file: Path, data: bytes) -> None:
    try:
        file.write_bytes(data)
    except OSError as error:
        raise CalibrationFileError(f"{file}: cannot be written: {error.strerror}") from error
