"""The processes that a command needs and that do not run yet: started for as long as it needs them."""

import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager

from messaging.session import Session, open_session
from nodal.bench_file import BenchFile, make_folder, work_folder
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


@contextmanager
def with_processes(bench: BenchFile, process: str, needed: Collection[str]) -> Iterator[Session]:
    """A session as `process` on a bench where the processes of these commands run: those that are missing are started,
    kept up, and stopped at the end. `simulate` is left out on a bench that is not simulated. Raises ProcessError.
    """
    wanted = [name for name in needed if name != "simulate" or bench.settings.simulation is not None]
    settings = bench.settings
    with open_session(settings.zenoh, settings.name, process) as session:
        alive = _alive(session) if wanted else frozenset()
        missing = [name for name in wanted if NAMES[name] not in alive]
        logs = work_folder(bench.path) / "logs"
        if missing:
            make_folder(logs, "logs")
        with Launcher(bench.path, logs, threading.Event(), missing) as launcher:
            launcher.start()
            with _tended(launcher):
                yield session


def _alive(session: Session) -> frozenset[str]:
    """Who is there; a session that was just opened finds a rendezvous that runs within a moment."""
    wait = threading.Event()
    for _ in range(10):
        if alive := session.alive():
            return alive
        wait.wait(FOUND_S / 10)
    return frozenset()


@contextmanager
def _tended(launcher: Launcher) -> Iterator[None]:
    """Processes that die meanwhile are started again, by a thread that does nothing else."""
    done = threading.Event()

    def tend() -> None:
        while not done.wait(0.1):
            for child in launcher.children.values():
                child.tend()

    tending = threading.Thread(target=tend, name="processes", daemon=True)
    tending.start()
    try:
        yield
    finally:
        done.set()
        tending.join()
