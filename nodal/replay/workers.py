"""Where replays are computed: processes on this machine, or a Dask cluster. The results do not depend on it."""

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from multiprocessing import get_context
from typing import Any

from nodal.errors import ReplayError

ANSWER_WITHIN = "5s"


@contextmanager
def workers(jobs: int, cluster: str | None) -> Iterator[Executor]:
    """Where stretches are replayed: `jobs` processes here, or a Dask cluster (a scheduler's address, or `local`).

    Raises ReplayError when there is no such cluster, or no Dask.
    """
    if cluster is not None:
        with _dask(jobs, cluster) as executor:
            yield executor
    elif jobs == 1:
        with ThreadPoolExecutor(1) as executor:
            yield executor
    else:
        # a fresh interpreter: forking one that holds libraries with threads of their own can lock up
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as executor:
            yield executor


def cores() -> int:
    """How many processes may run at once."""
    return len(os.sched_getaffinity(0))


@contextmanager
def _dask(jobs: int, cluster: str) -> Iterator[Executor]:
    try:
        import distributed  # noqa: PLC0415  slow, and part of an extra
    except ImportError as error:
        raise ReplayError("--dask needs Dask; install nodal with its extra `cluster`") from error
    dask: Any = distributed
    with ExitStack() as open_until_done:
        scheduler = cluster
        if cluster == "local":
            scheduler = open_until_done.enter_context(
                dask.LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None)
            )
        try:
            client = open_until_done.enter_context(dask.Client(scheduler, timeout=ANSWER_WITHIN))
        except (OSError, ValueError) as error:
            raise ReplayError(f"--dask {cluster}: no scheduler answers there: {error}") from error
        yield client.get_executor()
