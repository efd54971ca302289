"""Records `run.mcap` anew on the small simulated bench: `python tests/data/record_run.py OUT_FOLDER`.

A run in which a replay meets everything that it must repeat: homing, a target out of reach, a circle, a pause, an operator's
heartbeat, nodal points that are renamed on the way, sensing that freezes, a fault, sensing that dies and starts again, a
second homing, a stop signal, a jog, and the operator's stop.
"""

import os
import signal
import sys
import threading
from pathlib import Path

import numpy as np

from messaging.control import Action, ActionRequest, State
from messaging.message import Message
from messaging.session import Session, open_session
from messaging.shape import NodalPoints
from messaging.topics import CONTROLLER_DO, CONTROLLER_TARGET, HEARTBEAT, SENSING_NODES, STOP, Service
from nodal import targets
from nodal.bench_file import load_bench
from nodal.demo.folder import make_demo_folder, processes_of
from nodal.demo.telemetry import Telemetry
from nodal.processes.launcher import Launcher

HERE = Path(__file__).parent
FAR = targets.points({"tip": [90.0, 0.0, 10.0]}, {})
CIRCLE = targets.circle("tip", radius_mm=10.0, period_s=8.0, height_mm=85.0, centre_mm=(0.0, 0.0))
OTHER_POINTS = NodalPoints(names=("distal", "tip"), arc_mm=np.array([60.0, 80.0]))


class Run:
    """Asks and waits, with the bench tended meanwhile."""

    def __init__(self, session: Session, launcher: Launcher) -> None:
        self._session, self._launcher = session, launcher
        self._telemetry = Telemetry(session)
        launcher.on_turn = self._telemetry.take

    def ask(self, service: Service, request: Message) -> None:
        """Whatever the answer is, it is in the recording."""
        self._session.ask(service, request, 5.0)

    def do(self, action: Action) -> None:
        """Ask the controller."""
        self.ask(CONTROLLER_DO, ActionRequest(action=action))

    def until(self, *states: State) -> None:
        """Until the controller is in one of these states."""
        self._launcher.wait_until(
            lambda: self._telemetry.state in states, f"state {' or '.join(states)}", within_s=30.0
        )

    def seen(self) -> None:
        """Until a shape that can be trusted comes."""
        self._launcher.wait_until(
            lambda: self._telemetry.shape is not None and self._telemetry.shape.trusted,
            "a trusted shape",
            within_s=30.0,
        )

    def for_a_while(self, turns: int) -> None:
        """That many turns of the launcher, a tenth of a second each."""
        for _ in range(turns):
            self._launcher.turn()


def main(out: Path) -> None:
    """Record, and say where."""
    folder, bench = make_demo_folder(load_bench(HERE / "small.toml"), out)
    with (
        processes_of(folder, threading.Event()) as launcher,
        open_session(bench.settings.zenoh, bench.settings.name, "operator") as session,
    ):
        launcher.start()
        run = Run(session, launcher)
        run.seen()
        run.do(Action.HOME)
        run.until(State.READY)
        run.ask(CONTROLLER_TARGET, FAR)
        run.ask(CONTROLLER_TARGET, CIRCLE)
        run.do(Action.ARM)
        run.for_a_while(10)
        run.do(Action.PAUSE)
        session.gives(HEARTBEAT).give()
        run.for_a_while(5)
        run.do(Action.RESUME)
        run.for_a_while(5)
        run.ask(SENSING_NODES, OTHER_POINTS)
        run.for_a_while(10)
        if (sensing := launcher.children["sense"].pid) is None:
            raise SystemExit("sensing is not running")
        os.kill(sensing, signal.SIGSTOP)
        run.until(State.FAULT)
        os.kill(sensing, signal.SIGKILL)
        run.seen()
        run.do(Action.HOME)
        run.for_a_while(10)
        session.gives(STOP).give()
        run.until(State.IDLE)
        run.ask(CONTROLLER_DO, ActionRequest(action=Action.JOG, axis="1", distance_mm=0.2))
        run.for_a_while(3)
        run.do(Action.STATUS)
        run.do(Action.STOP)
        run.until(State.IDLE)
    print(folder.recording)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
