"""The bench that made a recording, as a replay may use it."""

from pathlib import Path

from nodal.bench_file import LAW_ATTACHMENT, Bench, recorded_bench
from nodal.errors import ReplayError
from nodal.toml_file import Table, merged
from recordings.log import Log


def bench_of(log: Log, changes: Table, law: Path | None) -> Bench:
    """The bench with these changes, and with `law` where it was led by a law in a file of its own.

    A recording may come from anybody: the file that it names is not run unless the user names it too. Raises ReplayError,
    BenchFileError or CalibrationFileError.
    """
    bench = recorded_bench(log.path, log.attachments, changes)
    named = "law_file" in changes.get("controller", {})
    if not bench.settings.controller.law_file or named:
        return bench
    if law is None:
        held = (
            f"; the recording holds its text as {LAW_ATTACHMENT}" if LAW_ATTACHMENT in log.attachments else ""
        )
        raise ReplayError(
            f"{log.path}: its controller was led by a law of its own, {bench.settings.controller.law_file}{held}. "
            "It is run when you say so: --law FILE"
        )
    own = {"controller": {"law_file": str(law.resolve())}}
    return recorded_bench(log.path, log.attachments, merged(changes, own))
