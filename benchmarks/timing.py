"""Times of several works side by side in one run, so that they can be told as ratios."""

import time
from collections.abc import Callable, Mapping

import numpy as np


def medians_s(works: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """The median time of each work in s; they take turns, so that whatever else a machine does falls on all alike."""
    times: dict[str, list[float]] = {name: [] for name in works}
    for work in works.values():
        work()
    for _ in range(repeats):
        for name, work in works.items():
            start = time.perf_counter()
            work()
            times[name].append(time.perf_counter() - start)
    return {name: float(np.median(taken)) for name, taken in times.items()}
