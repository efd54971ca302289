"""From settings to cameras that are files."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from drivers.cameras.errors import CameraError
from drivers.cameras.files.avi import pictures_in_video
from drivers.cameras.files.folder import pictures_in_folders
from drivers.cameras.files.picture import FilePicture
from drivers.cameras.files.playback import FileCamera, Playback
from drivers.cameras.files.recording import pictures_in_recording
from drivers.cameras.files.settings import (
    AviCameraSettings,
    FileCameraSettings,
    FolderCameraSettings,
    RecordingCameraSettings,
)


def file_cameras(settings: Mapping[str, FileCameraSettings], *, paced: bool) -> list[FileCamera]:
    """The cameras in their order, in step with one another (see Playback); raises CameraError naming the file, or the cameras that share no clock."""
    kinds = {camera.__struct_config__.tag for camera in settings.values()}
    if len(kinds) > 1:
        raise CameraError(
            f"cameras {', '.join(settings)} are files of the kinds {', '.join(sorted(map(str, kinds)))}, whose pictures have no "
            "time in common; allowed is one kind"
        )
    tracks: dict[str, Iterator[FilePicture]] = pictures_in_folders(
        {name: camera for name, camera in settings.items() if isinstance(camera, FolderCameraSettings)}
    )
    for name, camera in settings.items():
        match camera:
            case AviCameraSettings():
                tracks[name] = pictures_in_video(Path(camera.file))
            case RecordingCameraSettings():
                tracks[name] = pictures_in_recording(Path(camera.file), camera.camera or name)
    return Playback({name: tracks[name] for name in settings}, paced=paced).cameras
