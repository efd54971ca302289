"""Recorded publications in the order in which they were said, read ahead of the moment at which they are due."""

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from heapq import heappop, heappush
from itertools import islice

from recordings.reader import Recorded

Said = tuple[int, Recorded]
"""When it was said, Unix ns, and what."""

LATE_NS = 1_000_000_000
"""A recorder writes down at most this much later what was said."""
BATCH = 64
BATCHES_AHEAD = 4
"""About half a second of everything that a bench says; a few hundred frames at most."""


def by_publication(recorded: Iterable[Recorded]) -> Iterator[Said]:
    """The same in the order of saying, given the order of recording, each topic's own order kept.

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
        while waiting[0][0] < one.log_time_ns - LATE_NS:
            yield waiting[0][0], heappop(waiting)[2]
    while waiting:
        yield waiting[0][0], heappop(waiting)[2]


def read_ahead(source: Iterator[Said], executor: ThreadPoolExecutor) -> Iterator[Said]:
    """The same, read by the executor's one thread while what came before is waiting to be said; raises what `source` does."""
    batches = deque(executor.submit(_batch, source) for _ in range(BATCHES_AHEAD))
    while batch := batches.popleft().result():
        batches.append(executor.submit(_batch, source))
        yield from batch


def _batch(source: Iterator[Said]) -> list[Said]:
    return list(islice(source, BATCH))
