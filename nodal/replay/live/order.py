"""Recorded publications in the order in which they were said, read ahead of the moment at which they are due."""

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from heapq import heappop, heappush
from itertools import islice

from recordings.reader import Recorded

Timed = tuple[int, Recorded]
"""A time in ns, and what was said then."""

LATE_NS = 1_000_000_000
"""A recorder writes down at most this much later what was said."""
BETWEEN_ROUNDS_NS = 50_000_000
BATCH = 64
BATCHES_AHEAD = 4
"""A few tenths of a second of everything that a bench says, and never more than a few hundred frames."""


def timeline(rounds: Iterable[Iterable[Recorded]]) -> Iterator[Timed]:
    """What is to be said, and when, in ns after the first of all; one round after another, until one is empty."""
    begins_ns = 0
    for recorded in rounds:
        due_ns = first_ns = None
        for said_ns, one in by_publication(recorded):
            first_ns = said_ns if first_ns is None else first_ns
            due_ns = begins_ns + said_ns - first_ns
            yield due_ns, one
        if due_ns is None:
            return
        begins_ns = due_ns + BETWEEN_ROUNDS_NS


def by_publication(recorded: Iterable[Recorded]) -> Iterator[Timed]:
    """The same with the Unix time at which it was said, in that order, each topic's own order kept.

    A receiver tells from a shape's publish time when its frames were taken; the recorder's own times come a few ms
    later, now more, now less. They stand in where a publish time is out of reach of them: another host's clock, or a
    recorder that was held up.
    """
    waiting: list[tuple[int, int, Recorded]] = []
    last: dict[str, int] = {}
    for number, one in enumerate(recorded):
        in_reach = 0 <= one.log_time_ns - one.publish_time_ns <= LATE_NS
        said_ns = max(one.publish_time_ns if in_reach else one.log_time_ns, last.get(one.topic, 0))
        last[one.topic] = said_ns
        heappush(waiting, (said_ns, number, one))
        while waiting and waiting[0][0] < one.log_time_ns - LATE_NS:
            yield _earliest(waiting)
    while waiting:
        yield _earliest(waiting)


def read_ahead(source: Iterator[Timed], executor: ThreadPoolExecutor) -> Iterator[Timed]:
    """The same, read by the executor's one thread while what came before waits for its time; raises what `source` does."""
    batches = deque(executor.submit(_batch, source) for _ in range(BATCHES_AHEAD))
    while batch := batches.popleft().result():
        batches.append(executor.submit(_batch, source))
        yield from batch


def _earliest(waiting: list[tuple[int, int, Recorded]]) -> Timed:
    said_ns, _, one = heappop(waiting)
    return said_ns, one


def _batch(source: Iterator[Timed]) -> list[Timed]:
    return list(islice(source, BATCH))
