"""Settings of one camera, as they stand in [cameras.NAME]. `source` says what kind of camera it is.

Another kind joins by its own struct in the union `CameraSettings`, and its driver in `opening.py`.
"""

import msgspec

from drivers.cameras.files.settings import AviCameraSettings, FolderCameraSettings, RecordingCameraSettings
from drivers.cameras.v4l2.settings import V4l2CameraSettings


class SimulatedCameraSettings(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="source", tag="simulated"
):
    """A camera of the simulated bench. What it sees and how well is said in [simulation.cameras]."""


CameraSettings = (
    SimulatedCameraSettings
    | V4l2CameraSettings
    | AviCameraSettings
    | FolderCameraSettings
    | RecordingCameraSettings
)
