"""The bench's cameras, whatever stands behind them: frames, and the sets of frames that were taken together."""

from drivers.cameras.camera import Camera, CameraFrame
from drivers.cameras.errors import CameraError, CameraSilentError, UnknownCameraError
from drivers.cameras.opening import open_cameras
from drivers.cameras.pairing import FrameSet, FrameSetPairing
from drivers.cameras.settings import CameraSettings, SimulatedCameraSettings
from drivers.cameras.silence import SilenceWatch

__all__ = [
    "Camera",
    "CameraError",
    "CameraFrame",
    "CameraSettings",
    "CameraSilentError",
    "FrameSet",
    "FrameSetPairing",
    "SilenceWatch",
    "SimulatedCameraSettings",
    "UnknownCameraError",
    "open_cameras",
]
