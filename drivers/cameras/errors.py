"""Errors of the cameras.

NodalError
`-- CameraError               every error of a camera
    |-- CameraDeviceError     a camera's device is missing, may not be opened, or refuses its work
    |   |-- CameraBusyError       another program uses it
    |   |-- CameraFormatError     it does not give pictures of the size, format and rate that were asked
    |   |-- CameraControlError    it does not take a control's value, or holds another one
    |   `-- CameraLostError       it was there, and is no more, or gives nothing new
    |-- CameraSilentError     a camera has given no frame for longer than it may
    `-- UnknownCameraError    a frame or a question names a camera that is not on the bench
"""

from messaging.errors import NodalError


class CameraError(NodalError):
    """A camera cannot do its work."""


class CameraDeviceError(CameraError):
    """A camera's device is missing, may not be opened, or refuses its work."""


class CameraBusyError(CameraDeviceError):
    """Another program uses the camera."""


class CameraFormatError(CameraDeviceError):
    """The camera does not give pictures of the size, format and rate that were asked."""


class CameraControlError(CameraDeviceError):
    """The camera does not take a control's value, or holds another one."""


class CameraLostError(CameraDeviceError):
    """A camera that was there is no more, or gives nothing new."""


class CameraSilentError(CameraError):
    """A camera has given no frame for longer than it may."""


class UnknownCameraError(CameraError):
    """A name that is not one of the bench's cameras."""
