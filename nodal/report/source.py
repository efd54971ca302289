"""Where a run was read from: its files, what is attached to them, and what is wrong with them."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from nodal.bench_file import BENCH_ATTACHMENT
from nodal.errors import BenchFileError
from nodal.report.loading import attached_rig, lost_in
from nodal.toml_file import table_in
from recordings import Log
from recordings.metadata import CHECKSUM

GOES_ON = "goes_on_in"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Source:
    """`bench_text` is the effective bench file; empty when none is attached. Sizes in bytes."""

    path: Path
    bench_name: str
    bench_text: str
    attached: tuple[str, ...]
    files: Mapping[Path, int]
    versions: Mapping[str, str]
    lost: Mapping[str, int]
    damage: tuple[str, ...]
    rig_problem: str
    """Why no camera's calibration is known; empty when it is."""
    ending: str
    """Why the recorder ended it; empty when the recording was cut off, or goes on in a part that is not there."""


def source_of(log: Log) -> Source:
    """Of a log whose messages were read, so that its damage is known; raises RecordingError."""
    _, rig_problem = attached_rig(log)
    text = log.attachments.get(BENCH_ATTACHMENT, b"").decode(errors="replace")
    summaries = log.metadata("SUMMARY")
    last = summaries.get(log.parts[-1], {GOES_ON: ""})
    versions: dict[str, str] = {}
    for noted in log.metadata("VERSIONS").values():
        versions |= noted
    return Source(
        path=log.path,
        bench_name=_name(text),
        bench_text=text,
        attached=tuple(log.attachments),
        files={part: part.stat().st_size for part in log.parts},
        versions={name: version for name, version in versions.items() if name != CHECKSUM},
        lost=lost_in(summaries.values()),
        damage=tuple(dict.fromkeys(str(damage) for damage in log.damage)),
        rig_problem=rig_problem,
        ending="" if GOES_ON in last else last.get("ended_because", "it was finished"),
    )


def _name(bench_text: str) -> str:
    try:
        return str(table_in(bench_text.encode(), BENCH_ATTACHMENT).get("name", ""))
    except BenchFileError:
        return ""
