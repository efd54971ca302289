"""`nodal cameras look`: how good the cameras' pictures are, and what would make them better."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from nodal.cameras.chosen import add_source_arguments
from nodal.exit_status import REFUSED

if TYPE_CHECKING:
    from collections.abc import Iterator

    from nodal.cameras.judging.report import CameraReport

SUMMARY = "take a picture with each camera, judge it in words, and suggest settings"
PICTURES = 12
AT_MOST = 300


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which cameras, and where the pictures go."""
    whose = parser.add_mutually_exclusive_group(required=True)
    whose.add_argument("--config", metavar="BENCH", help="the cameras of this bench file")
    whose.add_argument("--device", metavar="PATH", help="one camera that is plugged in, on no bench yet")
    parser.add_argument("--out", default="look", metavar="DIR", help="folder for the pictures (default look)")
    parser.add_argument(
        "--pictures", type=int, default=PICTURES, metavar="N", help=f"pictures to take (default {PICTURES})"
    )
    parser.add_argument(
        "--focus",
        action="store_true",
        help="instead: try each webcam's focus from end to end, and tell where edges are sharpest",
    )
    parser.add_argument("--write", action="store_true", help="put what is suggested into the bench file")
    parser.add_argument("--json", action="store_true", help="print figures and findings as JSON")
    add_source_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """0 when nothing is poor, 3 when something is. Raises CameraError, BenchFileError, CommandError, ProcessError."""
    from nodal.bench_file import make_folder  # noqa: PLC0415
    from nodal.cameras.focusing import look_for_focus  # noqa: PLC0415
    from nodal.cameras.judging.report import as_json, as_words  # noqa: PLC0415
    from nodal.cameras.looking import look_at_bench, look_at_device  # noqa: PLC0415
    from nodal.errors import CommandError  # noqa: PLC0415

    if not 1 <= arguments.pictures <= AT_MOST:
        raise CommandError(f"--pictures {arguments.pictures}: allowed are 1 to {AT_MOST}")
    files = arguments.images or arguments.video or arguments.recording
    if arguments.device and (arguments.write or files):
        raise CommandError(
            "--device looks through a camera that is on no bench: allowed beside it are --focus, --out, --pictures, --json"
        )
    if arguments.focus:
        if files:
            raise CommandError(
                "--focus moves the lens of a webcam; pictures, videos and recordings have none"
            )
        return look_for_focus(arguments)
    folder = make_folder(Path(arguments.out), "--out")
    report = look_at_device(arguments) if arguments.device else look_at_bench(arguments)
    written = list(_written(report.cameras, folder))
    print(as_json(report) if arguments.json else as_words(report, written))
    return REFUSED if report.is_poor else 0


def _written(cameras: "list[CameraReport]", folder: Path) -> "Iterator[Path]":
    """Each camera's own picture, and the one that is drawn into."""
    import cv2  # noqa: PLC0415

    from nodal.cameras.judging.annotating import annotated  # noqa: PLC0415
    from nodal.errors import CommandError  # noqa: PLC0415

    for camera in cameras:
        drawn = cv2.imencode(".png", annotated(camera.look, camera.findings))[1].tobytes()
        for name, content in ((".jpg", camera.look.jpeg), ("-judged.png", drawn)):
            file = folder / f"{camera.look.camera}{name}"
            try:
                file.write_bytes(content)
            except OSError as error:
                raise CommandError(f"--out: {file} cannot be written: {error.strerror}") from error
            yield file
