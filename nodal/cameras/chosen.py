"""Which cameras a command looks through: those of the bench, or files that stand for them. Imports nothing slow."""

import argparse
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from drivers.cameras import Camera, CameraSettings
    from messaging.session import Session
    from nodal.bench_file import BenchFile
    from nodal.bench_settings import BenchSettings


def add_source_arguments(parser: argparse.ArgumentParser) -> None:
    """`--images`, `--video` or `--recording`; without any, the bench's own cameras."""
    sources = parser.add_argument_group("instead of the bench's own cameras").add_mutually_exclusive_group()
    sources.add_argument(
        "--images",
        nargs="+",
        metavar="NAME=FILES",
        help="pictures of each camera: a folder, or a pattern such as left='shots/*_left.jpg'",
    )
    sources.add_argument("--video", nargs="+", metavar="NAME=FILE", help="an MJPEG video of each camera")
    sources.add_argument("--recording", metavar="LOG", help="the frames in a recording (MCAP)")


def chosen_cameras(
    arguments: argparse.Namespace, settings: "BenchSettings"
) -> "Mapping[str, CameraSettings]":
    """The cameras to look through by their names on the bench, in the bench's order; files may stand for some of them only.

    Raises CommandError for a name that is not on the bench or given twice, and for pictures given to two cameras; CameraError
    for a folder without pictures.
    """
    from drivers.cameras import AviCameraSettings, RecordingCameraSettings  # noqa: PLC0415
    from nodal.cameras.picture_files import folders  # noqa: PLC0415

    if arguments.images:
        return folders(_by_name("--images", arguments.images, settings))
    if arguments.video:
        files = _by_name("--video", arguments.video, settings)
        return {name: AviCameraSettings(file=file) for name, file in files.items()}
    if arguments.recording:
        _warn_of_parts(arguments.recording)
        return {name: RecordingCameraSettings(file=arguments.recording) for name in settings.cameras}
    return settings.cameras


@contextmanager
def running_cameras(
    bench: "BenchFile", chosen: "Mapping[str, CameraSettings]", process: str
) -> "Iterator[tuple[list[Camera], Session]]":
    """These cameras, running, and a session of this process on the bench; what simulated cameras need is started, and files are
    read as fast as they can be. Raises CameraError, ProcessError.
    """
    from drivers.cameras import SimulatedCameraSettings, open_cameras  # noqa: PLC0415
    from nodal.processes.missing import with_processes  # noqa: PLC0415

    simulated = any(isinstance(settings, SimulatedCameraSettings) for settings in chosen.values())
    needed = ("rendezvous", "simulate") if simulated else ()
    with (
        with_processes(bench, process, needed) as session,
        open_cameras(chosen, session, paced=False) as cameras,
    ):
        yield cameras, session


def _warn_of_parts(recording: str) -> None:
    """A recording that goes on in further files is read no farther than the one that was named."""
    from recordings.parts import parts  # noqa: PLC0415

    _, *others = parts(Path(recording)) or (None,)
    if others:
        print(f"only {recording} is read; it goes on in {', '.join(map(str, others))}", file=sys.stderr)


def _by_name(option: str, given: list[str], settings: "BenchSettings") -> dict[str, str]:
    """What follows the `=` behind each camera's name, in the bench's order."""
    from nodal.errors import CommandError  # noqa: PLC0415

    found: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not (equals and value):
            raise CommandError(f"{option} {text}: allowed is NAME=FILE, NAME a camera of the bench")
        if name not in settings.cameras:
            raise CommandError(
                f"{option} {text}: {name} is not one of the cameras {', '.join(settings.cameras)}"
            )
        if name in found:
            raise CommandError(f"{option}: camera {name} is given twice, {found[name]} and {value}")
        found[name] = value
    return {name: found[name] for name in settings.cameras if name in found}
