"""Folders and patterns of picture files, as they are given on the command line."""

import glob
from collections.abc import Mapping
from pathlib import Path

from drivers.cameras import FolderCameraSettings
from drivers.cameras.files.folder import picture_files
from nodal.errors import CommandError


def folders(given: Mapping[str, str]) -> dict[str, FolderCameraSettings]:
    """Cameras that are these folders, or the files of these patterns.

    Raises CameraError for one without pictures, CommandError when two cameras have a picture in common.
    """
    cameras = {name: _folder(text) for name, text in given.items()}
    owner: dict[Path, str] = {}
    for name, camera in cameras.items():
        for file in picture_files(name, camera):
            if (other := owner.setdefault(file.resolve(), name)) != name:
                raise CommandError(
                    f"--images: picture {file} is given to camera {other} and to camera {name}; every camera has its own, for "
                    f"instance {name}='{file.parent}/*_{name}{file.suffix}'"
                )
    return cameras


def _folder(text: str) -> FolderCameraSettings:
    path = Path(text)
    if path.is_dir():
        return FolderCameraSettings(folder=text)
    if path.exists():
        return FolderCameraSettings(folder=str(path.parent), pattern=glob.escape(path.name))
    fixed = path.parent
    while glob.has_magic(str(fixed)):
        fixed = fixed.parent
    return FolderCameraSettings(folder=str(fixed), pattern=str(path.relative_to(fixed)))
