"""The bench's cameras, whatever stands behind them: frames, and the sets of frames that were taken together."""

from drivers.cameras.camera import Camera, CameraFrame
from drivers.cameras.errors import (
    CameraBusyError,
    CameraControlError,
    CameraDeviceError,
    CameraError,
    CameraFormatError,
    CameraSilentError,
    UnknownCameraError,
)
from drivers.cameras.files.settings import (
    AviCameraSettings,
    FileCameraSettings,
    FolderCameraSettings,
    RecordingCameraSettings,
)
from drivers.cameras.opening import open_cameras
from drivers.cameras.pairing import FrameSet, FrameSetPairing, worst_skew_periods
from drivers.cameras.pairing_report import PairingReport
from drivers.cameras.settings import CameraSettings, SimulatedCameraSettings
from drivers.cameras.silence import SilenceWatch
from drivers.cameras.v4l2.settings import V4l2CameraSettings, V4l2Controls

__all__ = [
    "AviCameraSettings",
    "Camera",
    "CameraBusyError",
    "CameraControlError",
    "CameraDeviceError",
    "CameraError",
    "CameraFormatError",
    "CameraFrame",
    "CameraSettings",
    "CameraSilentError",
    "FileCameraSettings",
    "FolderCameraSettings",
    "FrameSet",
    "FrameSetPairing",
    "PairingReport",
    "RecordingCameraSettings",
    "SilenceWatch",
    "SimulatedCameraSettings",
    "UnknownCameraError",
    "V4l2CameraSettings",
    "V4l2Controls",
    "open_cameras",
    "worst_skew_periods",
]
