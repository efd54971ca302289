"""The pictures of folders, one folder or one pattern of names for each camera."""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from drivers.cameras.errors import CameraError
from drivers.cameras.files.numbering import together
from drivers.cameras.files.picture import FilePicture
from drivers.cameras.files.settings import FolderCameraSettings

PICTURES = frozenset({".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".webp"})
JPEG_START = b"\xff\xd8"
BEST_QUALITY = 100
NS_PER_S = 1e9


def pictures_in_folders(cameras: Mapping[str, FolderCameraSettings]) -> dict[str, Iterator[FilePicture]]:
    """Each camera's pictures, in step: those that belong together have one time, and a missing one leaves a gap.

    Raises CameraError for a folder without pictures, rates that differ, or pictures that nothing says belong together.
    """
    rates_hz = {settings.rate_hz for settings in cameras.values()}
    if len(rates_hz) > 1:
        raise CameraError(
            f"the folders of cameras {', '.join(cameras)} have the rates {sorted(rates_hz)} Hz; pictures that "
            "belong together need one rate"
        )
    files = {name: picture_files(name, settings) for name, settings in cameras.items()}
    numbers = together({name: [file.stem for file in those] for name, those in files.items()})
    steps = sorted({number for those in numbers.values() for number in those})
    offset_ns = {number: round(step * NS_PER_S / min(rates_hz)) for step, number in enumerate(steps)}
    return {
        name: iter(
            FilePicture(offset_ns=offset_ns[number], number=number, jpeg=partial(_jpeg, file))
            for number, file in sorted(zip(numbers[name], those, strict=True))
        )
        for name, those in files.items()
    }


def picture_files(name: str, settings: FolderCameraSettings) -> list[Path]:
    """This camera's files, by name; raises CameraError when there are none."""
    folder = Path(settings.folder)
    if not folder.is_dir():
        raise CameraError(f"camera {name}: there is no folder {folder}")
    try:
        matching = sorted(file for file in folder.glob(settings.pattern) if file.is_file())
    except (ValueError, NotImplementedError) as error:
        raise CameraError(f"camera {name}: pattern {settings.pattern!r}: {error}") from error
    files = [file for file in matching if file.suffix.lower() in PICTURES]
    if not files:
        raise CameraError(
            f"camera {name}: no picture in {folder} matches {settings.pattern!r}; pictures end in "
            f"{', '.join(sorted(PICTURES))}"
        )
    return files


def _jpeg(file: Path) -> bytes:
    """The file's own bytes if it is a JPEG, else the picture as a JPEG without loss that could be seen."""
    try:
        data = file.read_bytes()
    except OSError as error:
        raise CameraError(f"{file}: cannot be read: {error.strerror}") from error
    return data if data.startswith(JPEG_START) else _coded_anew(file, data)


def _coded_anew(file: Path, data: bytes) -> bytes:
    import cv2  # noqa: PLC0415  settings of cameras are read where no OpenCV is installed
    import numpy as np  # noqa: PLC0415

    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_ANYCOLOR) if data else None
    if picture is None:
        raise CameraError(f"{file}: not a picture that can be read")
    full_colour = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
    quality = [
        cv2.IMWRITE_JPEG_QUALITY,
        BEST_QUALITY,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        full_colour,
    ]
    return cv2.imencode(".jpg", picture, quality)[1].tobytes()
