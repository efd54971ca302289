"""Logs replayed and compared: stretches of them side by side, on every core or on a cluster, always added up in order."""

import time
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path

import msgspec

from messaging.errors import NodalError
from nodal.bench_file import Bench
from nodal.errors import ReplayError
from nodal.replay import controlling, sensing
from nodal.replay.comparison import Comparison
from nodal.replay.cycles import ControlPart
from nodal.replay.recorded import bench_of
from nodal.replay.script import control_stretches, sensing_stretches, whole
from nodal.replay.sensing import SensingPart
from recordings.log import Log

LOGS_AHEAD = 2


class Verdict(msgspec.Struct, frozen=True, kw_only=True):
    """One log's replay. `span_s` is the time that the log covers, `took_s` how long its replay was under way."""

    log: str
    span_s: float
    took_s: float
    comparison: Comparison
    damage: list[str]
    out: str = ""
    """Where a what-if was written."""
    error: str = ""
    """Why the log could not be replayed at all."""

    @property
    def same(self) -> bool:
        """True when something was compared and nothing differs."""
        return not self.error and self.comparison.compared > 0 and not self.comparison.different


@dataclass
class _UnderWay:
    path: Path
    started_s: float
    span_s: float
    damage: list[str]
    futures: list[Future[Comparison]]


def verify_stretch(part: SensingPart | ControlPart, bench: Bench) -> Comparison:
    """One stretch; what a worker does. Raises ReplayError, which unlike others finds its way back from a worker."""
    try:
        return (
            sensing.verify(part, bench) if isinstance(part, SensingPart) else controlling.verify(part, bench)
        )
    except NodalError as error:
        raise ReplayError(str(error)) from None


def verified(
    paths: Iterable[Path], executor: Executor, law: Path | None = None, logs_ahead: int = LOGS_AHEAD
) -> Iterator[Verdict]:
    """The verdict on each log, in their order; a log that cannot be replayed has an error and ends nothing.

    `law` is run where a log was led by a law of its own. So many logs are read before the outcome of the first is waited for.
    """
    under_way: deque[_UnderWay] = deque()
    for path in paths:
        try:
            under_way.append(_begun(path, executor, law))
        except NodalError as error:
            while under_way:
                yield _ended(under_way.popleft())
            yield impossible(path, error)
        if len(under_way) > logs_ahead:
            yield _ended(under_way.popleft())
    while under_way:
        yield _ended(under_way.popleft())


def _begun(path: Path, executor: Executor, law: Path | None) -> _UnderWay:
    started_s = time.monotonic()
    log = Log(path)
    bench = bench_of(log, {}, law)
    sensed, controlled = whole(log)
    if not sensed.sets and not controlled.states:
        raise ReplayError(
            f"{path}: it holds neither estimates nor cycles of the controller; there is nothing to compare"
        )
    times = [record.log_time_ns for record in sensed.sets] + [
        state.log_time_ns for state in controlled.states
    ]
    stretches: list[SensingPart | ControlPart] = [
        *sensing_stretches(sensed),
        *control_stretches(controlled),
    ]
    return _UnderWay(
        path=path,
        started_s=started_s,
        span_s=(max(times) - min(times)) / 1e9,
        damage=[str(damage) for damage in log.damage],
        futures=[executor.submit(verify_stretch, stretch, bench) for stretch in stretches],
    )


def _ended(log: _UnderWay) -> Verdict:
    try:
        comparison = sum((future.result() for future in log.futures), Comparison())
    except NodalError as error:
        return impossible(log.path, error)
    return Verdict(
        log=str(log.path),
        span_s=log.span_s,
        took_s=time.monotonic() - log.started_s,
        comparison=comparison,
        damage=log.damage,
    )


def impossible(path: Path, error: NodalError) -> Verdict:
    """The verdict on a log that cannot be replayed."""
    text = str(error)
    return Verdict(
        log=str(path),
        span_s=0.0,
        took_s=0.0,
        comparison=Comparison(),
        damage=[],
        error=text if str(path) in text else f"{path}: {text}",
    )
