"""What every camera offers, whatever stands behind it."""

import dataclasses
from typing import Protocol


@dataclasses.dataclass(frozen=True, kw_only=True)
class CameraFrame:
    """One picture as the camera coded it.

    `capture_monotonic_ns` is the middle of the exposure on the host's CLOCK_MONOTONIC. `number` counts the camera's
    frames: a gap says how many were lost before they were read.
    """

    name: str
    jpeg: bytes
    capture_monotonic_ns: int
    number: int


class Camera(Protocol):
    """A camera that is running."""

    @property
    def name(self) -> str:
        """Its name on the bench."""
        ...

    @property
    def ended(self) -> bool:
        """True once it will never give another frame: a file that was read to its end. Devices never end."""
        ...

    def read(self) -> CameraFrame | None:
        """The next frame that was not read yet, or None; returns at once. Only the newest few wait to be read."""
        ...

    def close(self) -> None:
        """Let the device go."""
        ...
