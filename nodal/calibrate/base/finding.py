"""The course of `nodal calibrate base`: one way or both, what is kept of them, and whether sensing is content with it."""

import argparse
import dataclasses
import time
from collections.abc import Callable, Sequence

from calibration.base import Base, Difference, Way, difference
from calibration.camera_set import CameraSet
from drivers.cameras import Camera, FileCameraSettings, open_cameras
from messaging.frames import CameraCalibration
from messaging.scene import Scene
from nodal.bench_file import BenchFile
from nodal.bench_settings import BenchSettings
from nodal.calibrate.base.from_board import board_base
from nodal.calibrate.base.from_robot import Look, RobotWay, backgrounds
from nodal.calibrate.base.keeping import dated, keep, kept_bases
from nodal.calibrate.hand import BenchHand
from nodal.calibrate.looking import Jpegs, taken
from nodal.calibrate.person import Person, person_at
from nodal.calibration.folder import load_cameras, own_bench
from nodal.cameras.chosen import chosen_cameras
from nodal.errors import CommandError
from nodal.processes.missing import with_processes
from nodal.running import stop_on_signals
from sensing.errors import SensingError
from sensing.method import bench_method
from sensing.shape import Shape

BOARD_SETS = 30


@dataclasses.dataclass(frozen=True, kw_only=True)
class Check:
    """What sensing makes of the robot at rest with the new rig: a shape, or why there is none."""

    shape: Shape | None
    refusal: str
    known_length_mm: float

    @property
    def good(self) -> bool:
        """Whether there is a shape without flags."""
        return self.shape is not None and not self.shape.flags


@dataclasses.dataclass(frozen=True, kw_only=True)
class Outcome:
    """What was found now, what is used, how the two ways differ where both are known, and what sensing says, if it was asked."""

    bench: BenchFile
    bases: dict[Way, Base]
    found: tuple[Way, ...]
    used: Way
    difference: Difference | None
    check: Check | None


def find_base(arguments: argparse.Namespace) -> Outcome:
    """Find, keep and check; raises NodalError of many kinds, and overwrites nothing then."""
    bench = own_bench(arguments.config)
    settings, cameras, ways = bench.checked(), load_cameras(bench), _ways(arguments, bench)
    chosen = chosen_cameras(arguments, settings)
    of_files = any(isinstance(camera, FileCameraSettings) for camera in chosen.values())
    if of_files and ways != ("board",):
        raise CommandError("files show the board at the base alone: with them only --board can be done")
    if absent := [camera.name for camera in cameras.cameras if camera.name not in chosen]:
        raise CommandError(f"camera {', '.join(absent)}: no pictures are given; all cameras are needed")
    needed = () if of_files else ("rendezvous", "simulate", *(("control",) if "robot" in ways else ()))
    bases, look = kept_bases(bench, cameras), None
    with (
        with_processes(bench, "calibration", needed) as session,
        open_cameras(chosen, session, paced=False) as running,
    ):
        person = None if of_files else person_at(settings, session)
        if "board" in ways:
            bases["board"], pictures = _by_board(settings, cameras, running, person)
        if "robot" in ways and person is not None:
            person.please(Scene.ROBOT)
            turned = _until_interrupted()
            way = RobotWay(settings, cameras, running, arguments.pull, turned)
            base, look = way.found(BenchHand(session))
            turned()
            bases["robot"], pictures = dated(base, cameras), look.sets[0]
        elif person is not None:
            person.please(Scene.ROBOT)
            look = Look(taken(running, settings.sensing.maximum_skew_s, 1, time.monotonic_ns()), 0.0)
    used = ways[0]
    rig = keep(bench, cameras, bases, used, pictures)
    both = "board" in bases and "robot" in bases
    return Outcome(
        bench=bench,
        bases=bases,
        found=ways,
        used=used,
        difference=difference(bases["board"], bases["robot"]) if both else None,
        check=None if look is None else _check(settings, rig, look),
    )


def _until_interrupted() -> Callable[[], None]:
    """Raises KeyboardInterrupt when it is called after SIGINT, SIGTERM or SIGHUP, which end the process no more where it stands:
    a controller that runs on would hold the tendons.
    """
    stop = stop_on_signals()

    def turned() -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    return turned


def _by_board(
    settings: BenchSettings, cameras: CameraSet, running: Sequence[Camera], person: Person | None
) -> tuple[Base, Jpegs]:
    """The robot frame by the board, and one set of the pictures that show it; nobody sets the scene of files."""
    since_ns = 0
    if person is not None:
        person.please(Scene.BOARD_AT_BASE)
        since_ns = time.monotonic_ns()
    sets = taken(running, settings.sensing.maximum_skew_s, BOARD_SETS, since_ns)
    return dated(board_base(settings.board, cameras, sets), cameras), sets[0]


def _check(settings: BenchSettings, rig: tuple[CameraCalibration, ...], look: Look) -> Check:
    """Sensing's own word on the robot at rest."""
    try:
        method = bench_method(settings.sensing, settings.robot, rig, backgrounds(settings))
        pictures = {name: method.scene.picture(name, data) for name, data in look.sets[0].items()}
        shape = method.estimate(pictures, look.insertion_mm, None, time.perf_counter)
    except SensingError as error:
        return Check(shape=None, refusal=str(error), known_length_mm=settings.robot.length_mm)
    return Check(shape=shape, refusal="", known_length_mm=settings.robot.length_mm)


def _ways(arguments: argparse.Namespace, bench: BenchFile) -> tuple[Way, ...]:
    """Those that are asked for; without any, the board's where the bench file says how it stands, else the robot's."""
    asked: tuple[Way, ...] = (
        *(("board",) if arguments.board else ()),
        *(("robot",) if arguments.robot else ()),
    )
    return asked or (("robot",) if bench.settings.board.at_base is None else ("board",))
