"""All processes of a bench: started in an order that spares retries, kept alive, stopped with the recorder last."""

import threading
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from nodal.errors import ProcessError
from nodal.processes.child import Child

START_ORDER = (("rendezvous",), ("record", "simulate"), ("sense", "control"))
STOP_ORDER = ("control", "sense", "simulate", "record", "rendezvous")
READY_WITHIN_S = 60.0
TURN_S = 0.1


class Stopped(Exception):  # noqa: N818  an order, not an error
    """The operator wants it to end."""


class Launcher:
    """Owns the processes. Whoever waits for anything waits here, so that processes are tended meanwhile."""

    def __init__(
        self,
        bench_file: Path,
        logs: Path,
        stop: threading.Event,
        names: Collection[str] = STOP_ORDER,
        more: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        """`names` are the processes to start, where not all are wanted; `more` are words for some of them beside the bench
        file. What they print goes to the folder `logs`.
        """
        more = more or {}
        self.children = {
            name: Child(name, ("--config", str(bench_file), *more.get(name, ())), logs)
            for name in STOP_ORDER
            if name in names
        }
        self.on_turn: Callable[[], None] = lambda: None
        """Called on every turn of every wait: the place for a progress display."""
        self._stop = stop

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop whatever runs, in order."""
        self.stop()

    def start(self) -> None:
        """Start every process and wait until it is ready; raises ProcessError with its last words, or Stopped."""
        for names in START_ORDER:
            together = [self.children[name] for name in names if name in self.children]
            for child in together:
                child.start()
            deadline_s = time.monotonic() + READY_WITHIN_S
            while late := [child for child in together if not child.ready]:
                if time.monotonic() > deadline_s:
                    raise ProcessError(
                        f"{late[0].name} was not ready within {READY_WITHIN_S:g} s; {late[0].last_words()}"
                    )
                self.turn()

    def turn(self) -> None:
        """One turn of waiting: tend every process, show progress, sleep a little; raises Stopped or ProcessError."""
        if self._stop.is_set():
            raise Stopped
        for child in self.children.values():
            child.tend()
        self.on_turn()
        self._stop.wait(TURN_S)

    def wait_until(self, met: Callable[[], bool], what: str, within_s: float) -> None:
        """Turn until the condition is met; raises ProcessError naming what did not come in time."""
        deadline_s = time.monotonic() + within_s
        while not met():
            if time.monotonic() > deadline_s:
                raise ProcessError(f"{what} did not come within {within_s:g} s")
            self.turn()

    def stop(self) -> None:
        """End every process, the recorder after all that it records."""
        for child in self.children.values():
            child.stop()
            child.close()
