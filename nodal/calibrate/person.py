"""Whoever sets the scene before the cameras: a person at the bench, or on a simulated bench the simulation."""

import sys
from typing import Protocol

from messaging.scene import Scene, SceneRequest
from messaging.session import Session
from messaging.topics import SIMULATION_SCENE
from nodal.asking import answer
from nodal.bench_settings import BenchSettings
from nodal.errors import CalibrationError

ANSWER_S = 20.0

WORDS = {
    Scene.ROBOT: "put the robot into its holder, as the bench runs",
    Scene.EMPTY: "take the robot out of its holder, and leave everything else as it is",
    Scene.BOARD: "take the board; hold it still at one place after another, all over the pictures, tilted every way",
    Scene.BOARD_AT_BASE: "put the board into its fixture at the base, with the stage at zero",
}


class Person(Protocol):
    """Sets scenes."""

    def please(self, scene: Scene) -> None:
        """Returns when the scene stands; raises CalibrationError when nobody can set it."""
        ...


class PersonAtTerminal:
    """Reads what to do, and presses Enter when it is done."""

    def please(self, scene: Scene) -> None:
        """Ask, and wait; raises CalibrationError when there is nobody to press Enter."""
        print(f"Please {WORDS[scene]}; then press Enter.", file=sys.stderr, flush=True)
        if not sys.stdin.readline():
            raise CalibrationError(
                f"nobody is there to {WORDS[scene]}: standard input has ended before Enter was pressed"
            )


class SimulatedPerson:
    """The simulated bench sets its own scenes."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def please(self, scene: Scene) -> None:
        """Ask the simulation; raises UnansweredError when it does not run, CalibrationError when it refuses."""
        print(f"the simulated bench is asked to {WORDS[scene]}", file=sys.stderr, flush=True)
        reply = answer(self._session, SIMULATION_SCENE, SceneRequest(scene=scene), ANSWER_S)
        if not reply.accepted:
            raise CalibrationError(f"the simulated bench cannot {WORDS[scene]}: {reply.reason}")


def person_at(settings: BenchSettings, session: Session) -> Person:
    """Who sets the scene on this bench."""
    return PersonAtTerminal() if settings.simulation is None else SimulatedPerson(session)
