"""A stretch of a recording as its user names it: `--from` and `--until`, in seconds from its beginning or as UTC."""

import argparse
import dataclasses
import datetime as dt
import math
from typing import TYPE_CHECKING

from nodal.errors import CommandError

if TYPE_CHECKING:
    from recordings.log import Log


@dataclasses.dataclass(frozen=True, kw_only=True)
class Moment:
    """Either seconds from a recording's first message, or a Unix time in ns; `text` is how it was given."""

    text: str
    after_s: float | None = None
    unix_ns: int | None = None

    def in_ns(self, beginning_ns: int) -> int:
        """Unix time in ns, for a recording that begins then."""
        if self.unix_ns is not None:
            return self.unix_ns
        return beginning_ns + round((self.after_s or 0.0) * 1e9)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Span:
    """Log times from `start_ns` on and before `end_ns`, of a recording that begins at `beginning_ns`. Unix ns."""

    beginning_ns: int
    start_ns: int
    end_ns: int


def moment(text: str) -> Moment:
    """What `12.5` or `2026-05-02T13:04:05.5Z` says; raises ArgumentTypeError."""
    try:
        after_s = float(text)
    except ValueError:
        return Moment(text=text, unix_ns=_unix_ns(text))
    if not math.isfinite(after_s) or after_s < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time: seconds are 0 or more")
    return Moment(text=text, after_s=after_s)


def add_span_arguments(parser: argparse.ArgumentParser) -> None:
    """`--from` and `--until`."""
    for option, which in (("--from", "first moment"), ("--until", "moment before which it ends")):
        parser.add_argument(
            option,
            dest=f"{option.strip('-')}_moment",
            type=moment,
            metavar="T",
            help=f"{which}: seconds from the recording's beginning, or UTC as in 2026-05-02T13:04:05.5Z",
        )


def span_of(log: "Log", arguments: argparse.Namespace) -> Span:
    """The stretch that the arguments name; raises CommandError when nothing can lie in it, RecordingError."""
    whole = log.span_ns
    if whole is None:
        raise CommandError(f"{log.path}: the recording holds no messages")
    beginning_ns, last_ns = whole
    begin, end = arguments.from_moment, arguments.until_moment
    start_ns = begin.in_ns(beginning_ns) if begin else beginning_ns
    end_ns = end.in_ns(beginning_ns) if end else last_ns + 1
    if end and end_ns <= start_ns:
        where = f"--from {begin.text}" if begin else "the beginning"
        raise CommandError(f"--until {end.text} is not after {where}")
    return Span(beginning_ns=beginning_ns, start_ns=start_ns, end_ns=end_ns)


def _unix_ns(text: str) -> int:
    try:
        time = dt.datetime.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is neither seconds from the beginning, such as 12.5, nor a time such as 2026-05-02T13:04:05Z"
        ) from None
    if time.tzinfo is None:
        time = time.replace(tzinfo=dt.UTC)
    since = time - dt.datetime.fromtimestamp(0, dt.UTC)
    return (since // dt.timedelta(microseconds=1)) * 1000
