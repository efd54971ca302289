"""What `nodal calibrate robot` gains on random benches in virtual time: `python -m benchmarks.robot_identification`.

For each bench: the moves that are held out, foreseen as drawn and as identified; how far a second experiment with other moves
finds other numbers, in the standard deviations that were said; and a circle in closed loop, begun at the drawing and begun at
what was identified, after homing anew.
"""

import argparse
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.control.paths import CIRCLE
from benchmarks.control.robots import BENCH_ROBOT
from controller.identified import IdentifiedSettings
from controller.settings import ControllerSettings
from drivers.dynamixel.settings import AxisSettings
from nodal.calibrate.robot.experiment import experiment, plan_for, reach
from nodal.calibrate.robot.leading import Leader
from nodal.calibrate.robot.results import Outcome, identify
from nodal.calibrate.robot.wiring import find_wiring
from nodal.virtual.bench import VirtualBench
from nodal.virtual.hand import VirtualHand
from nodal.virtual.random_bench import random_bench

Array = NDArray[np.float64]

SHARE, OTHER_SHARE = 0.6, 0.5
CIRCLE_S = 14.0
SPANS_S = ((0.0, 2.0), (2.0, 4.0), (4.0, CIRCLE_S))
SETTINGS, ROBOT = BENCH_ROBOT.controller, BENCH_ROBOT.robot
AXES = tuple(
    AxisSettings(
        name=f"pair {axis}", id=axis, mm_per_rad=5.0, min_mm=-12.0, max_mm=12.0, max_current_ma=1000.0
    )
    for axis in range(1, 5)
)


def identified(seed: int, share: float) -> tuple[Outcome, float]:
    """What is found on this bench, and how long it takes there."""
    bench = VirtualBench(random_bench(seed), SETTINGS, ROBOT)
    leader, begin_s = Leader(VirtualHand(bench), SETTINGS, len(AXES), lambda: None, print), bench.now_s
    kinematics = SETTINGS.kinematics(ROBOT)
    find_wiring(leader, SETTINGS, kinematics, AXES)
    plan = plan_for(SETTINGS, ROBOT, reach(SETTINGS, share, leader.stage_mm()))
    seen = experiment(leader, plan, lambda _: None)
    leader.let_go()
    mm_per_rad = tuple(axis.mm_per_rad for axis in AXES)
    return identify(seen, SETTINGS, leader.node_names, ROBOT, mm_per_rad), bench.now_s - begin_s


def circled(seed: int, known: IdentifiedSettings | None) -> list[float]:
    """RMS of the tip's error in each span, from `arm` on."""
    controller: ControllerSettings = msgspec.structs.replace(SETTINGS, identified=known)
    bench = VirtualBench(random_bench(seed), controller, ROBOT)
    bench.home()
    bench.target(CIRCLE)
    bench.do("arm")
    samples, _ = bench.run(CIRCLE_S)
    error_mm, time_s = samples.error_mm("tip"), samples.now_s - samples.now_s[0]
    return [
        float(np.sqrt(np.nanmean(error_mm[(time_s >= begin) & (time_s < end)] ** 2)))
        for begin, end in SPANS_S
    ]


def scores(one: Outcome, other: Outcome) -> dict[str, Array]:
    """Differences of two experiments on one bench, in their standard deviations."""
    found = {}
    for name in ("gain", "bias_rad", "stage_gain", "lost_motion_mm"):
        a, b = getattr(one.robot, name), getattr(other.robot, name)
        found[name] = np.ravel((a.value - b.value) / np.hypot(a.sigma, b.sigma))
    return found


def main(words: Sequence[str] | None = None) -> None:
    """Print a row for each bench, and the medians."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--benches", type=int, default=6, metavar="N", help="how many (default 6)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the first bench (default 1)")
    arguments = parser.parse_args(words)
    print("foreseen without feedback, RMS of all nodal points; circle: tip RMS in s 0-2, 2-4, 4-14")
    rows, all_scores = [], []
    for seed in range(arguments.seed, arguments.seed + arguments.benches):
        outcome, took_s = identified(seed, SHARE)
        foreseen = outcome.foreseen
        drawn, known = circled(seed, None), circled(seed, outcome.settings)
        all_scores.append(scores(outcome, identified(seed, OTHER_SHARE)[0]))
        rows.append([took_s, foreseen.before_mm, foreseen.after_mm, *drawn, *known])
        print(_row(f"bench {seed}", rows[-1]), flush=True)
    print(_row("median", np.median(rows, axis=0).tolist()))
    for name in all_scores[0]:
        joined = np.concatenate([one[name] for one in all_scores])
        inside = float((np.abs(joined) < 1.96).mean())
        print(
            f"{name}: a second experiment is {np.sqrt((joined**2).mean()):.2f} sigma away, {inside:.0%} within 95 %"
        )


def _row(name: str, values: Sequence[float]) -> str:
    took_s, before, after, *circles = values
    drawn, known = circles[:3], circles[3:]
    spans = (" ".join(f"{value:.2f}" for value in one) for one in (drawn, known))
    return f"{name:8} {took_s:4.0f} s  drawn {before:.2f}, identified {after:.2f} mm  circle: drawn {next(spans)}, identified {next(spans)} mm"


if __name__ == "__main__":
    main()
