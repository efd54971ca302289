"""What the controller makes of each fault, in virtual time: `python -m benchmarks.control.faults`.

The tip follows the circle; then something breaks. `until safe` is the time until nothing is driven any more: torque is off,
or goals stand still. `driven` is how far the tip moved meanwhile, `after` how far it went after that, and `astray` how far
it was from where the controller led it.
"""

import argparse
import dataclasses
import itertools
import logging
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.paths import CIRCLE, TIP
from benchmarks.control.robots import BENCH_ROBOT
from benchmarks.control.scenarios import begin
from benchmarks.yardstick import yardstick
from controller.loop import Loop
from controller.settings import ControllerSettings
from drivers.simulated.servos.memory import Memory
from messaging.control import Action, ActionRequest
from nodal.virtual.bench import VirtualBench
from nodal.virtual.settings import ServoSettings, VirtualBenchSettings

FOLLOWED_S, WATCHED_S = 3.0, 4.0
OVERLOAD = 0x20
STRONG_MA = 1500.0
"""What the servos may draw, so that there is something above the controller's own limit."""
FORCED_RAD = 0.2
DRIVEN_AT_MOST_MM = 3.0
BROKEN_LAW = str(Path(__file__).with_name("not_a_number.py"))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that breaks."""

    name: str
    cause: Callable[[VirtualBench], object]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Consequence:
    """What came of it."""

    mode: str
    safe_s: float
    """Infinite when the robot is driven on."""
    driven_mm: float
    after_mm: float
    astray_mm: float
    """Furthest from where the controller led it, as long as it did."""
    reason: str


def tendon_snaps(bench: VirtualBench) -> None:
    """The first tendon of the first pair lies loose from now on."""
    tendons = len(bench.plant.robot.pull_per_displacement)
    bench.plant.robot.slip(np.append(100.0, np.zeros(tendons - 1)))


def stage_is_forced(bench: VirtualBench) -> None:
    """Something turns the stage's screw back a little and holds it, so that its servo draws more than it should."""
    bench.plant.servos[-1].motor.position_rad -= FORCED_RAD
    bench.plant.jammed.add(bench.plant.axes - 1)


def law_breaks(bench: VirtualBench) -> None:
    """The law answers nan from now on."""
    bench.hand_over(Loop(ControllerSettings(law_file=BROKEN_LAW), BENCH_ROBOT.robot))


FAULTS = (
    Fault(name="operator stop", cause=lambda bench: bench.ask(ActionRequest(action=Action.STOP))),
    Fault(name="sensing silent", cause=lambda bench: setattr(bench.seeing, "lost", True)),
    Fault(name="sensing flagged", cause=lambda bench: setattr(bench.seeing, "flags", ("out_of_view",))),
    Fault(name="sensing refuses", cause=lambda bench: setattr(bench.seeing, "refusal", "no robot in sight")),
    Fault(name="servo silent", cause=lambda bench: bench.actuators.silent.add(0)),
    Fault(name="servo overload", cause=lambda bench: bench.plant.servos[0].fail(OVERLOAD)),
    Fault(name="servo restarts", cause=lambda bench: bench.plant.servos[0].reboot(bench.now_s)),
    Fault(name="stage is forced", cause=stage_is_forced),
    Fault(name="pair jams", cause=lambda bench: bench.plant.jammed.add(0)),
    Fault(name="stage jams", cause=lambda bench: bench.plant.jammed.add(bench.plant.axes - 1)),
    Fault(name="tendon snaps", cause=tendon_snaps),
    Fault(name="law answers nan", cause=law_breaks),
)


def tracking_bench(law: str = "") -> VirtualBench:
    """A bench whose tip follows the circle, and whose every cycle can be looked at."""
    controller = ControllerSettings(law=law) if law else ControllerSettings()
    settings = VirtualBenchSettings(
        servos=ServoSettings(maximum_current_ma=STRONG_MA), robot_step_s=1 / controller.rate_hz
    )
    bench = VirtualBench(settings, controller, BENCH_ROBOT.robot)
    bench.home()
    begin(bench, CIRCLE)
    bench.run(FOLLOWED_S)
    return bench


def consequence(bench: VirtualBench, fault: Fault, watched_s: float = WATCHED_S) -> Consequence:
    """Cause the fault and watch."""
    broken_s = bench.now_s
    fault.cause(bench)
    times, tips, goals, errors = [], [], [], [0.0]
    while bench.now_s < broken_s + watched_s:
        samples, _ = bench.run(0.0)
        times.append(bench.now_s - broken_s)
        tips.append(samples.node_mm[0, samples.node_names.index(TIP)])
        errors.append(float(np.nan_to_num(samples.error_mm(TIP)[0])))
        goals.append([_goal(servo.memory) for servo in bench.plant.servos])
    last = _still(goals)
    tip_mm = np.array(tips)
    safe = last < len(times) - 1
    return Consequence(
        mode=str(bench.state.mode),
        safe_s=times[last] if safe else np.inf,
        driven_mm=_furthest(tip_mm[: last + 1]) if safe else np.nan,
        astray_mm=max(errors),
        after_mm=_furthest(tip_mm[last:]) if safe else 0.0,
        reason=bench.state.supervision.reason,
    )


def _goal(memory: Memory) -> int | None:
    return memory["goal_position"] if memory["torque_enable"] else None


def _still(goals: Sequence[Sequence[int | None]]) -> int:
    """The first row from which on no goal of a driven servo changes any more."""
    return max(
        (
            row + 1
            for row, (old, new) in enumerate(itertools.pairwise(goals))
            if any(None not in pair and pair[0] != pair[1] for pair in zip(old, new, strict=True))
        ),
        default=0,
    )


def _furthest(tip_mm: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(tip_mm - tip_mm[0], axis=1).max())


def main(words: Sequence[str] | None = None) -> int:
    """Break everything once, and print what came of it."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.control.faults", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--law", default="", help="which law follows the circle (default: the controller's)")
    logging.getLogger("controller").setLevel(logging.ERROR)
    tracking = tracking_bench(parser.parse_args(words).law)
    print(
        f"{'fault':<18}{'then':<10}{'until safe ms':>14}{'driven mm':>11}{'after mm':>10}{'astray mm':>11}  reason"
    )
    found = {fault.name: consequence(tracking.copy(), fault) for fault in FAULTS}
    for name, then in found.items():
        print(
            f"{name:<18}{then.mode:<10}{1e3 * then.safe_s:14.0f}{then.driven_mm:11.2f}{then.after_mm:10.2f}"
            f"{then.astray_mm:11.2f}  {then.reason}"
        )
    endless = [name for name, then in found.items() if np.isinf(then.safe_s)]
    furthest_mm = max(max(np.nan_to_num(then.driven_mm), then.astray_mm) for then in found.values())
    print(f"led on, since nothing was noticed or it could be made good: {', '.join(endless) or 'none'}")
    print(
        yardstick(
            "furthest that the tip is driven after a fault, or led astray",
            f"<= {DRIVEN_AT_MOST_MM:g} mm",
            f"{furthest_mm:.1f} mm",
            met=furthest_mm <= DRIVEN_AT_MOST_MM,
        )
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
