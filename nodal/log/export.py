"""`nodal log export`: a recording for other programs and other people."""

import argparse
import sys
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING

from nodal.errors import CommandError
from nodal.log.spans import Span, add_span_arguments, span_of

if TYPE_CHECKING:
    from recordings.log import Log

SUMMARY = (
    "write tables (CSV, NPZ, Parquet), a video with overlays, the cameras' pictures, or the attached files"
)

TABLES = ("csv", "npz", "parquet")
PICTURES = ("mp4", "jpeg")
WIDTH_PX = 1920


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recording, what of it, and where to."""
    parser.add_argument("log", type=Path, metavar="LOG", help="a recording; its later parts belong to it")
    parser.add_argument(
        "--to",
        required=True,
        choices=(*TABLES, *PICTURES, "files"),
        help="csv, parquet: a folder with one file a topic; npz: one file of NumPy arrays; mp4: video with overlays; "
        "jpeg: a folder with the cameras' pictures as they came; files: a folder with what is attached",
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="OUT",
        help="file or folder; it must not exist yet",
    )
    parser.add_argument(
        "--topics",
        nargs="+",
        default=[],
        metavar="KEY",
        help="only these topics: shape, tendon/state, camera/left ... (tables; default: all that tables are made of)",
    )
    add_span_arguments(parser)
    parser.add_argument(
        "--camera",
        action="append",
        default=[],
        metavar="NAME",
        help="only this camera; may be given again (mp4, jpeg; default: all)",
    )
    parser.add_argument(
        "--width",
        type=int,
        metavar="PX",
        help=f"width of the video, all cameras side by side (mp4; default {WIDTH_PX})",
    )


def run(arguments: argparse.Namespace) -> int:
    """Write it; what was written is said on stdout, what could not be read on stderr."""
    from nodal.exports.output import draft_of  # noqa: PLC0415
    from recordings.log import Log  # noqa: PLC0415

    _check(arguments)
    draft_of(arguments.output)
    log = Log(arguments.log)
    for line in _written(log, arguments):
        print(line)
    for damage in log.damage:
        print(f"nodal: warning: {damage}", file=sys.stderr)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Refuse arguments that the format has no use for; raises CommandError."""
    kind = arguments.to
    useless = {
        "--topics": arguments.topics and kind not in TABLES,
        "--camera": arguments.camera and kind not in PICTURES,
        "--width": arguments.width is not None and kind != "mp4",
        "--from and --until": (arguments.from_moment or arguments.until_moment) and kind == "files",
    }
    for option, given in useless.items():
        if given:
            raise CommandError(f"{option}: means nothing with --to {kind}")


def _written(log: "Log", arguments: argparse.Namespace) -> list[str]:
    from nodal.exports import files  # noqa: PLC0415

    if arguments.to == "files":
        return files.write_attachments(log, arguments.output)
    span = span_of(log, arguments)
    if arguments.to in TABLES:
        return _tables(log, arguments, span)
    cameras = files.camera_topics(arguments.camera)
    if arguments.to == "jpeg":
        return files.write_pictures(log, cameras, span, arguments.output)
    from nodal.exports.video.film import write_film  # noqa: PLC0415

    width_px = WIDTH_PX if arguments.width is None else arguments.width
    return write_film(log, arguments.camera, span, width_px, arguments.output)


def _tables(log: "Log", arguments: argparse.Namespace, span: Span) -> list[str]:
    from nodal.exports.table_files import WRITERS  # noqa: PLC0415
    from nodal.exports.tables import Tables  # noqa: PLC0415
    from nodal.exports.topics_chosen import chosen  # noqa: PLC0415

    topics = chosen(arguments.topics)
    tables = Tables(span.beginning_ns)
    tables.hear(log.messages(topics, span.start_ns, span.end_ns))
    for (key, reason), count in tables.unreadable.items():
        print(f"nodal: warning: {key}: {count} left out: {reason}", file=sys.stderr)
    finished = tables.finished()
    wanted = arguments.topics or ["*"]
    if absent := [key for key in wanted if not any(fnmatch(table.key, key) for table in finished)]:
        raise CommandError(f"{log.path}: nothing was recorded then of {', '.join(absent)}")
    return WRITERS[arguments.to](finished, arguments.output)
