"""Errors of the cameras.

NodalError
`-- CameraError               every error of a camera
    |-- CameraSilentError     a camera has given no frame for longer than it may
    `-- UnknownCameraError    a frame or a question names a camera that is not on the bench
"""

from messaging.errors import NodalError


class CameraError(NodalError):
    """A camera cannot do its work."""


class CameraSilentError(CameraError):
    """A camera has given no frame for longer than it may."""


class UnknownCameraError(CameraError):
    """A name that is not one of the bench's cameras."""
