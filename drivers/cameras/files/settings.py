"""Settings of cameras that are files."""

from typing import Annotated

import msgspec


class AviCameraSettings(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="source", tag="avi"
):
    """A video of JPEG pictures (`source = "avi"`), which are kept as they are, at the rate that the video tells."""

    file: str
    """A video whose coding is MJPEG; no other is taken, since its pictures would not be the camera's own."""


class FolderCameraSettings(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="source", tag="folder"
):
    """A folder of pictures (`source = "folder"`). JPEG pictures are kept as they are; PNG, BMP, TIFF and WebP become JPEG of
    the highest quality. Pictures of several cameras belong together by the numbers in their names, or by their order.
    """

    folder: str
    pattern: Annotated[str, msgspec.Meta(min_length=1)] = "*"
    """Which of the folder's files are this camera's, such as `"*_left.jpg"`."""
    rate_hz: Annotated[float, msgspec.Meta(gt=0, le=1000)] = 30.0
    """The rate at which they are played; the same for every camera."""


class RecordingCameraSettings(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="source", tag="recording"
):
    """The frames of a camera in a recording (`source = "recording"`), at the times at which they were captured."""

    file: str
    """One file of a recording (MCAP); a recording that goes on in further parts has them beside it."""
    camera: str = ""
    """The camera's name in the recording, if it is another than here."""


FileCameraSettings = AviCameraSettings | FolderCameraSettings | RecordingCameraSettings
