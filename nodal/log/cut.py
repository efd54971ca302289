"""`nodal log cut`: a stretch of a recording as a recording of its own."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from nodal.errors import CommandError
from nodal.log.spans import add_span_arguments

if TYPE_CHECKING:
    from nodal.log.events import Wanted
    from recordings import Log

SUMMARY = (
    "write a stretch of it, by time or around an event, into a recording of its own that can be replayed"
)

EVENTS = (
    "fault, hold, state, target, asked, flag, refusal, warning, restart; or one of them by name, such as state:tracking, "
    "target:circle, flag:tip_unseen"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The recording, the stretch, and the new file."""
    parser.add_argument(
        "log",
        type=Path,
        metavar="LOG",
        help="a recording; its later parts belong to it; or a folder that holds one",
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="OUT",
        help="the new file; it must not exist yet. With --which all: OUT-1, OUT-2 and so on",
    )
    add_span_arguments(parser)
    parser.add_argument("--around", type=_event, metavar="EVENT", help=f"instead of times: {EVENTS}")
    parser.add_argument(
        "--before", type=_duration, default=5.0, metavar="S", help="seconds before the event (default 5)"
    )
    parser.add_argument(
        "--after", type=_duration, default=5.0, metavar="S", help="seconds after the event (default 5)"
    )
    parser.add_argument(
        "--which",
        choices=("first", "last", "all"),
        default="first",
        help="of the times that the event came about (default first)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Write it, and say what is in it."""
    import sys  # noqa: PLC0415

    from nodal.log.choosing import one_log  # noqa: PLC0415
    from nodal.log.deriving import cut  # noqa: PLC0415
    from nodal.log.lines import derived_in_words  # noqa: PLC0415

    log = one_log(arguments.log)
    for start_ns, end_ns, out in _cuts(log, arguments):
        print(derived_in_words(cut(log, start_ns, end_ns, out)))
    for damage in log.damage:
        print(f"nodal: warning: {damage}", file=sys.stderr)
    return 0


def _cuts(log: "Log", arguments: argparse.Namespace) -> list[tuple[int, int, Path]]:
    from nodal.log.events import times_of  # noqa: PLC0415
    from nodal.log.spans import span_of  # noqa: PLC0415

    around, out = arguments.around, arguments.output
    by_time = bool(arguments.from_moment or arguments.until_moment)
    if by_time == bool(around):
        raise CommandError("say what to cut: either --from or --until or both, or --around an event")
    span = span_of(log, arguments)
    if by_time and span.start_ns >= span.end_ns:
        raise CommandError(f"--from {arguments.from_moment.text}: the recording has ended by then")
    if by_time:
        return [(max(span.start_ns, span.beginning_ns), span.end_ns, out)]
    times = times_of(log, around)
    if not times:
        raise CommandError(f"{log.path}: {around.text} does not come about in it")
    chosen = {"first": times[:1], "last": times[-1:], "all": times}[arguments.which]
    outs = (
        [out]
        if arguments.which != "all"
        else [out.with_name(f"{out.stem}-{number}{out.suffix}") for number in range(1, len(chosen) + 1)]
    )
    return [
        (
            max(time_ns - int(arguments.before * 1e9), span.beginning_ns),
            time_ns + int(arguments.after * 1e9) + 1,
            path,
        )
        for time_ns, path in zip(chosen, outs, strict=True)
    ]


def _event(text: str) -> "Wanted":
    from nodal.log.events import event  # noqa: PLC0415  brings messages with it, which help does without

    return event(text)


def _duration(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0 <= seconds < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds, 0 or more")
    return seconds
