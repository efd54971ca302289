"""Sensing against its yardsticks: `python -m benchmarks.sensing [--poses 40] [--photographs FOLDER]`.

Accuracy of both methods over seeded poses of the simulated bench, and over a folder of photographs with exact truth where
one is given or named by NODAL_PHOTOGRAPHS; then what an estimate costs. All in one run on one thread, told as ratios.
"""

# ruff: noqa: E402  arithmetic has to be fixed before NumPy is loaded, as in the sensing process
from nodal.arithmetic import pin

pin()

import argparse
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from benchmarks.photographs import photographed_rig, photographs
from benchmarks.poses import LENGTH_MM, centreline, photograph, random_bends, renderers
from benchmarks.scoring import Score
from benchmarks.sensing_costs import cost_lines, estimated
from benchmarks.yardstick import most_mm, yardstick
from drivers.simulated.cameras.rig import default_cameras
from sensing.method import METHODS
from sensing.scene import Scene
from sensing.settings import MethodName

MOVED_RAD = 0.02
"""A frame earlier each section was bent by about this much less: 1 mm at the tip."""
COLD, WARM, PLAIN = "refined, cold", "refined, warm", "plain"
COVERAGE_PERCENT = 90.0, 99.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=40, help="of the simulated bench (default 40)")
    parser.add_argument(
        "--photographs",
        type=Path,
        metavar="FOLDER",
        default=os.environ.get("NODAL_PHOTOGRAPHS"),
        help="photographs with exact truth (default: the folder that NODAL_PHOTOGRAPHS names, if any)",
    )
    parser.add_argument("--each", action="store_true", help="print a line for every estimate")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    say = print if arguments.each else _keep_quiet
    scores = {f"simulated bench, {way}": score for way, score in _simulated(arguments.poses, say).items()}
    if arguments.photographs:
        seen = _photographed(Path(arguments.photographs), say)
        scores |= {f"photographs, {way}": score for way, score in seen.items()}
    for name, score in scores.items():
        print(name, *score.lines(), sep="\n", end="\n\n", flush=True)
    print("yardstick, measured, met or missed")
    for name, score in scores.items():
        for line in _accuracy_lines(name, score):
            print(line)
    for line in cost_lines():
        print(line, flush=True)


def _simulated(poses: int, say: Callable[[str], None]) -> dict[str, Score]:
    scores = {way: Score() for way in (COLD, WARM, PLAIN)}
    rig = default_cameras()
    cameras, random = renderers(rig), np.random.default_rng(1)
    scene = Scene.of(rig, length_mm=LENGTH_MM)
    refined, plain = (METHODS[name](scene) for name in (MethodName.REFINED, MethodName.PLAIN))
    for number in range(poses):
        bends = random_bends(random)
        truth_mm = centreline(bends)
        pictures = photograph(cameras, truth_mm)
        before = photograph(cameras, centreline(bends * (1 - MOVED_RAD / np.abs(bends).max())))
        ways = {
            COLD: lambda pictures=pictures: estimated(refined, pictures),
            WARM: lambda pictures=pictures, before=before: estimated(
                refined, pictures, estimated(refined, before).track
            ),
            PLAIN: lambda pictures=pictures: estimated(plain, pictures),
        }
        for way, look in ways.items():
            say(f"pose {number} {way}: {scores[way].add(look, truth_mm)}")
    return scores


def _photographed(folder: Path, say: Callable[[str], None]) -> dict[str, Score]:
    """Every pair by itself: without a prior, and without being told the robot's length."""
    scores = {COLD: Score(), PLAIN: Score()}
    rig = photographed_rig(folder)
    for one in photographs(folder):
        scene = Scene.of(rig, backgrounds=one.backgrounds)
        for way, method in ((COLD, MethodName.REFINED), (PLAIN, MethodName.PLAIN)):
            came_out = scores[way].add(
                lambda name=method, scene=scene, one=one: estimated(METHODS[name](scene), one.pictures),
                one.truth_mm,
            )
            say(f"{one.label} {way}: {came_out}")
    return scores


def _accuracy_lines(name: str, score: Score) -> Iterator[str]:
    """The yardsticks of accuracy are the refined method's; ellipsoids and silence are both methods'."""
    if not score.trusted:
        yield yardstick(name, "some shape without a flag", "none", met=False)
        return
    if PLAIN not in name:
        yield most_mm(f"{name}: mean node error", float(score.error_mm.mean()), 0.05)
        yield most_mm(f"{name}: mean tip error", float(score.error_mm[:, -1].mean()), 0.1)
        yield most_mm(f"{name}: length error per 10 mm", float(score.length_per_10_mm.mean()), 0.007)
    least, most = COVERAGE_PERCENT
    percent = 100 * score.inside
    yield yardstick(
        f"{name}: truth in the 95 % ellipsoid",
        f"for {least:g} to {most:g} % of nodal points",
        f"{percent:.1f} %",
        met=least <= percent <= most,
    )
    yield yardstick(f"{name}: wrong in silence", "none", str(score.silent), met=score.silent == 0)


def _keep_quiet(_: str) -> None:
    pass


if __name__ == "__main__":
    main()
