"""Where a run was read from: its files, what is attached to them, and what is wrong with them."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from nodal.bench_file import BENCH_ATTACHMENT
from nodal.errors import BenchFileError
from nodal.report.loading import lost_in
from nodal.toml_file import table_in
from recordings import Log


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
    finished: bool


def source_of(log: Log) -> Source:
    """Of a log whose messages were read, so that its damage is known; raises RecordingError."""
    text = log.attachments.get(BENCH_ATTACHMENT, b"").decode(errors="replace")
    summaries = log.metadata("SUMMARY")
    versions: dict[str, str] = {}
    for noted in log.metadata("VERSIONS").values():
        versions |= noted
    return Source(
        path=log.path,
        bench_name=_name(text),
        bench_text=text,
        attached=tuple(log.attachments),
        files={part: part.stat().st_size for part in log.parts},
        versions=versions,
        lost=lost_in(summaries.values()),
        damage=tuple(str(damage) for damage in log.damage),
        finished=log.parts[-1] in summaries,
    )


def _name(bench_text: str) -> str:
    try:
        return str(table_in(bench_text.encode(), BENCH_ATTACHMENT).get("name", ""))
    except BenchFileError:
        return ""
