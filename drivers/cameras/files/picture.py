"""A picture in a file, with its place in time."""

import dataclasses
from collections.abc import Callable


@dataclasses.dataclass(frozen=True, kw_only=True)
class FilePicture:
    """`offset_ns` counts from a zero that cameras of the same kind share; `jpeg` reads the picture and may raise CameraError."""

    offset_ns: int
    number: int
    jpeg: Callable[[], bytes]
