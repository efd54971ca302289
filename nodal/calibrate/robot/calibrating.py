"""The bench brought to identify its robot: processes, signs first, then the experiment; and what is kept of it."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import msgspec

from nodal.bench_editing import edit_bench_file
from nodal.bench_file import BenchFile, read_bench
from nodal.bench_settings import BenchSettings
from nodal.calibrate.hand import BenchHand
from nodal.calibrate.robot.experiment import experiment, plan_for, reach, seconds
from nodal.calibrate.robot.leading import Leader, leading_robot
from nodal.calibrate.robot.progress import Progress
from nodal.calibrate.robot.results import RobotFound, axes_found, identify
from nodal.calibrate.robot.wiring import Wiring, find_wiring
from nodal.calibration.folder import calibration_folder, save_json
from nodal.errors import CalibrationError, CalibrationFileError, RobotStoppedError
from nodal.processes.missing import NAMES, with_processes
from nodal.running import stop_on_signals

ROBOT = "robot.json"
_RESTART = (
    "end `nodal control` and start it again, so that it reads the bench file, then run this command again"
)


def foretold(config: str, share: float) -> str:
    """What would be moved, how far and how long."""
    settings = read_bench(config).checked()
    controller, axes = settings.controller, settings.servos.tendons
    stage_mm = controller.limits.insertion_mm[0] if settings.robot.stage else None
    within = reach(controller, share, stage_mm)
    plan = plan_for(controller, settings.robot, within)
    fitted = len(plan.alone_mm) + len(plan.together_mm)
    stage = ""
    if within.stage_mm:
        stage = f"\nthe stage goes {abs(within.stage_mm[1] - within.stage_mm[0]):g} mm from where it stands, and back"
    return (
        f"{len(axes)} tendons or pairs ({', '.join(axis.name for axis in axes)}) are pulled one by one until the robot is seen "
        f"to follow, by at most {controller.homing.search_mm:g} mm; then the robot is homed, twice\n"
        f"each goes up to {within.tendon_mm:g} mm either way ({share:.0%} of controller.limits.displacement_mm), alone and with "
        f"the others, one axis at a time at {controller.jog.mm_s:g} mm/s{stage}\n"
        f"{fitted} poses are looked at to be fitted, {len(plan.held_out_mm)} more to be foreseen; about "
        f"{seconds(plan, controller) / 60:.1f} minutes\n"
        "nothing has moved"
    )


def calibrate_robot(bench: BenchFile, share: float) -> RobotFound:
    """Identify the robot of this bench and keep what is found in its file; whatever happens, the tendons are let go.

    What is not to be believed stands in `robot.json` alone, with the doubt. Raises RobotStoppedError, RobotPosesError,
    CalibrationError, ProcessError, BenchFileError, and KeyboardInterrupt after SIGINT, SIGTERM or SIGHUP.
    """
    begin_s, stop = time.monotonic(), stop_on_signals()
    _check(bench)
    with (
        with_processes(bench, "calibration", ("rendezvous", "simulate", "sense")) as session,
        Progress() as progress,
    ):

        def turned() -> None:
            progress.show()
            if stop.is_set():
                raise KeyboardInterrupt

        theirs = NAMES["control"] in session.alive()
        if theirs:
            progress.say("nodal control runs already and is used as it is")
        reversed_axes: tuple[str, ...] = ()
        with _led(bench, turned, progress.say) as leader:
            wiring = _wiring(leader, bench.settings, progress)
            if not wiring.reversed:
                return _identified(bench, leader, progress, share, begin_s, reversed_axes, turned)
            leader.let_go()
        reversed_axes = _turn_signs(bench, wiring, progress)
        if theirs:
            raise RobotStoppedError(
                f"the sign of {', '.join(reversed_axes)} was wrong; it is corrected in {bench.path}", _RESTART
            )
        bench = read_bench(bench.path)
        with _led(bench, turned, progress.say) as leader:
            return _identified(bench, leader, progress, share, begin_s, reversed_axes, turned)


def _check(bench: BenchFile) -> None:
    """That the robot can be seen, and that what is found can be written: before minutes are spent. Raises CalibrationError,
    BenchFileError.
    """
    try:
        bench.loaded()
    except CalibrationFileError as error:
        raise CalibrationError(f"{error}; begin with `nodal calibrate base`") from error
    edit_bench_file(bench.path, {})


@contextmanager
def _led(bench: BenchFile, turned: Callable[[], None], say: Callable[[str], None]) -> Iterator[Leader]:
    """A leader on a controller that reads the bench file as it is now, and runs as long as this lasts."""
    settings = bench.checked()
    with with_processes(bench, "calibration-robot", ("control",)) as session:
        turned()
        tendons = len(settings.servos.tendons)
        with leading_robot(BenchHand(session), settings.controller, tendons, turned, say) as leader:
            yield leader


def _wiring(leader: Leader, settings: BenchSettings, progress: Progress) -> Wiring:
    progress.tell("which way each tendon bends the robot")
    kinematics = settings.controller.kinematics(settings.robot)
    return find_wiring(leader, settings.controller, kinematics, settings.servos.tendons)


def _turn_signs(bench: BenchFile, wiring: Wiring, progress: Progress) -> tuple[str, ...]:
    """Write the other sign into the bench file, and take out what was identified with the old one; returns the axes' names."""
    tendons = bench.settings.servos.tendons
    turned = {axis: {"mm_per_rad": -tendons[axis].mm_per_rad} for axis in wiring.reversed}
    changes: dict[str, Any] = {"servos": {"tendons": turned}}
    if bench.settings.controller.identified is not None:
        changes["controller"] = {"identified": None}
    edit_bench_file(bench.path, changes)
    names = tuple(tendons[axis].name for axis in wiring.reversed)
    progress.tell("starting the controller anew")
    progress.say(
        f"bends the other way: {', '.join(names)}; the sign of mm_per_rad is corrected in {bench.path}"
    )
    return names


def _identified(
    bench: BenchFile,
    leader: Leader,
    progress: Progress,
    share: float,
    begin_s: float,
    reversed_axes: tuple[str, ...],
    turned: Callable[[], None],
) -> RobotFound:
    settings = bench.settings
    controller, robot = settings.controller, settings.robot
    kinematics = controller.kinematics(robot)
    stage_mm = leader.stage_mm() if robot.stage else None
    plan = plan_for(controller, robot, reach(controller, share, stage_mm))
    progress.takes(seconds(plan, controller))
    seen = experiment(leader, plan, progress.tell)
    progress.tell("relaxing")
    leader.let_go()
    mm_per_rad = tuple(axis.mm_per_rad for axis in settings.servos.axes)
    outcome = identify(seen, controller, leader.node_names, robot, mm_per_rad)
    found = RobotFound(
        date=outcome.settings.date,
        seconds=round(time.monotonic() - begin_s, 1),
        length_mm=robot.length_mm,
        poses=sum(len(run.fitted) for run in seen.runs),
        refused=len(seen.refused),
        refused_because=tuple(dict.fromkeys(seen.refused)),
        reversed=reversed_axes,
        axes=axes_found(outcome, seen, kinematics, tuple(axis.name for axis in settings.servos.tendons)),
        fit_rms_mm=outcome.robot.rms_mm,
        held_out=outcome.foreseen,
        identified=outcome.settings,
        doubt=outcome.doubt,
    )
    turned()
    save_json(calibration_folder(bench) / ROBOT, found)
    if not found.doubt:
        edit_bench_file(bench.path, {"controller": {"identified": msgspec.to_builtins(found.identified)}})
    return found
