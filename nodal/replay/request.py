"""`nodal replay` from its arguments to its exit status."""

import sys
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import dataclass
from pathlib import Path

import msgspec

from messaging.errors import NodalError
from nodal.errors import CommandError, ReplayError
from nodal.replay.account import as_text, ignored_in_words, totals_of
from nodal.replay.verification import Verdict, impossible, verified
from nodal.replay.what_if import write_what_if
from nodal.replay.workers import cores, workers
from nodal.toml_file import Table, merged

SAME, DIFFERENT, FAILED = 0, 1, 2
HEEDED = ("robot", "sensing", "controller")
"""Tables of the bench file that a replay depends on."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """What the user asked for; `jobs` None means one for each core, `changes` are KEY=VALUE."""

    logs: Sequence[Path]
    changes: Sequence[str]
    out: Path | None
    law: Path | None
    jobs: int | None
    cluster: str | None
    as_json: bool


def replay(request: Request) -> int:
    """Replay, print, and return the exit status; raises NodalError for what cannot be done at all."""
    changes = changes_in(request.changes)
    jobs = cores() if request.jobs is None else request.jobs
    if jobs < 1:
        raise CommandError(f"--jobs {jobs}: at least 1 is needed")
    if changes and request.out is None:
        raise CommandError("--set asks what would have been; say where to write that: -o OUT")
    verdicts = []
    try:
        with workers(jobs, request.cluster) as executor:
            for verdict in _verdicts(request, changes, executor):
                verdicts.append(verdict)
                if verdict.error:
                    print(f"nodal: error: {verdict.error}", file=sys.stderr)
                elif not request.as_json:
                    print(as_text(verdict), flush=True)
    except BrokenExecutor as error:
        raise ReplayError(f"a process that computed the replay died: {error}") from error
    totals = totals_of(verdicts)
    if request.as_json:
        print(msgspec.json.format(msgspec.json.encode(totals), indent=1).decode())
    elif totals.compared:
        print(ignored_in_words())
    if any(verdict.error for verdict in verdicts):
        return FAILED
    return SAME if totals.same or request.out is not None else DIFFERENT


def changes_in(words: Sequence[str]) -> Table:
    """The tables that KEY=VALUE words change; values are TOML, or else plain text. Raises CommandError."""
    changes: Table = {}
    for word in words:
        key, equals, text = word.partition("=")
        steps = key.strip().split(".")
        if not equals or not all(steps) or len(steps) < 2:
            raise CommandError(f"--set {word!r} is not KEY=VALUE, such as controller.tuning.feedback_per_s=4")
        if steps[0] not in HEEDED:
            raise CommandError(f"--set {word!r}: a replay depends on keys of {', '.join(HEEDED)} only")
        table: Table = {steps[-1]: _value(text.strip())}
        for step in reversed(steps[:-1]):
            table = {step: table}
        changes = merged(changes, table)
    return changes


def _value(text: str) -> object:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _verdicts(request: Request, changes: Table, executor: Executor) -> Iterator[Verdict]:
    if request.out is None:
        yield from verified(request.logs, executor, request.law)
        return
    outs = _outs(request.logs, request.out)
    futures = [
        executor.submit(write_what_if, log, changes, out, request.law)
        for log, out in zip(request.logs, outs, strict=True)
    ]
    for log, future in zip(request.logs, futures, strict=True):
        try:
            yield future.result()
        except NodalError as error:
            yield impossible(log, error)


def _outs(logs: Sequence[Path], out: Path) -> list[Path]:
    """Where the replay of each log goes; raises CommandError when two would meet."""
    if len(logs) == 1 and not out.is_dir():
        return [out]
    names = [log.name for log in logs]
    if len(set(names)) < len(names):
        raise CommandError(f"-o {out}: two of the logs have the same name")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f"-o {out}: cannot be made: {error.strerror}") from error
    return [out / name for name in names]
