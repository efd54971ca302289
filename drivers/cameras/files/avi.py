"""The pictures of an MJPEG video, byte for byte as the camera coded them."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.cameras.errors import CameraError
from drivers.cameras.files.picture import FilePicture

if TYPE_CHECKING:
    import cv2

MJPEG = "MJPG"
NS_PER_MS = 1_000_000


def pictures_in_video(file: Path) -> Iterator[FilePicture]:
    """In their order; raises CameraError now when the file is not such a video."""
    return _read(_opened(file))


def _opened(file: Path) -> "cv2.VideoCapture":
    import cv2  # noqa: PLC0415  settings of cameras are read where no OpenCV is installed

    if not file.is_file():
        raise CameraError(f"{file}: there is no such video")
    # a format of -1 asks for the pictures as they are coded
    video = cv2.VideoCapture(str(file), cv2.CAP_FFMPEG, [cv2.CAP_PROP_FORMAT, -1])
    if not video.isOpened():
        raise CameraError(f"{file}: not a video that can be read")
    coding = int(video.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode("ascii", "replace")
    if coding != MJPEG:
        video.release()
        raise CameraError(
            f"{file}: its pictures are coded as {coding!r}; allowed is {MJPEG!r}, the JPEG pictures of a camera as they are"
        )
    return video


def _read(video: "cv2.VideoCapture") -> Iterator[FilePicture]:
    import cv2  # noqa: PLC0415

    number = 0
    try:
        while True:
            there, coded = video.read()
            if not there:
                return
            offset_ns = round(video.get(cv2.CAP_PROP_POS_MSEC) * NS_PER_MS)
            yield FilePicture(offset_ns=offset_ns, number=number, jpeg=coded.tobytes)
            number += 1
    finally:
        video.release()
