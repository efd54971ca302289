"""The processes that a command needs and that do not run yet: started for as long as it needs them."""

import threading
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager

from messaging.errors import NodalError
from messaging.session import Session, open_session
from nodal.bench_file import BenchFile, make_folder, work_folder
from nodal.errors import ProcessError
from nodal.processes.launcher import Launcher

NAMES = {
    "rendezvous": "rendezvous",
    "simulate": "simulation",
    "sense": "sensing",
    "control": "controller",
    "record": "recorder",
}
"""Commands that run processes, and what the processes call themselves on the bus."""

FOUND_S = 1.0
POLL_S = 0.1


@contextmanager
def with_processes(bench: BenchFile, process: str, needed: Collection[str]) -> Iterator[Session]:
    """A session as `process` on a bench where the processes of these commands run: those that are missing are started,
    kept up, and stopped at the end. `simulate` is left out on a bench that is not simulated. Raises ProcessError.
    """
    wanted = [name for name in needed if name != "simulate" or bench.settings.simulation is not None]
    settings = bench.settings
    with open_session(settings.zenoh, settings.name, process) as session:
        missing = _missing(session, wanted)
        logs = work_folder(bench.path) / "logs"
        if missing:
            make_folder(logs, "logs")
        with Launcher(bench.path, logs, threading.Event(), missing) as launcher:
            launcher.start()
            with _tended(launcher):
                yield session


def _missing(session: Session, wanted: Collection[str]) -> frozenset[str]:
    """Those that nobody runs. A session that was just opened finds the others within a moment, so it looks for that long."""
    deadline_s = time.monotonic() + FOUND_S
    while True:
        alive = session.alive()
        missing = frozenset(name for name in wanted if NAMES[name] not in alive)
        if not missing or time.monotonic() > deadline_s:
            return missing
        time.sleep(POLL_S)


@contextmanager
def _tended(launcher: Launcher) -> Iterator[None]:
    """Processes that die meanwhile are started again by a thread that does nothing else; one that keeps dying is told at the end."""
    done = threading.Event()
    failed: list[ProcessError] = []

    def tend() -> None:
        while not done.wait(POLL_S):
            try:
                for child in launcher.children.values():
                    child.tend()
            except ProcessError as error:
                failed.append(error)
                return

    tending = threading.Thread(target=tend, name="processes", daemon=True)
    tending.start()
    try:
        yield
    except NodalError as error:
        if failed:
            raise failed[0] from error
        raise
    finally:
        done.set()
        tending.join()
