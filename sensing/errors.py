"""Errors of sensing.

NodalError
`-- SensingError
|-- PictureError            a picture of one camera that cannot be used; `camera` says whose
|   |-- UnreadableImageError    bytes that are not a whole picture
|   `-- ImageSizeError          a picture whose size is not its calibration's
|-- WorkAreaError           a work area that is not one of its camera's picture, or leaves the robot out
|-- RefusedError            a picture set in which no shape can be resolved; `reason` says why
|-- NodalPointError         a nodal point that is not on the robot
`-- MemoryMisfitError       a logged memory that is not sensing's, or of a scene with other cameras
"""

from messaging.errors import NodalError


class SensingError(NodalError):
    """An error of the sensing room."""


class PictureError(SensingError):
    """A camera's picture cannot be used."""

    def __init__(self, camera: str, reason: str) -> None:
        super().__init__(camera, reason)
        self.camera = camera
        self.reason = reason

    def __str__(self) -> str:
        """The camera and the reason."""
        return f"camera {self.camera}: {self.reason}"


class UnreadableImageError(PictureError):
    """The bytes of a picture cannot be decoded whole."""


class ImageSizeError(PictureError):
    """A picture's size differs from the size its camera was calibrated at."""


class WorkAreaError(SensingError):
    """A work area is of no camera, reaches beyond the picture, or does not contain the base."""


class RefusedError(SensingError):
    """No shape can be resolved in this frame set."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class NodalPointError(SensingError):
    """A nodal point lies beyond the robot."""


class MemoryMisfitError(SensingError):
    """A logged memory does not fit."""
