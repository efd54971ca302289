"""How much of one core the sensing of two cameras takes: `python benchmarks/sensing_rates.py [--sizes 1920x1080 3840x2160]`.

From JPEG bytes to the bytes of the estimate and of its views, while the robot goes round: CPU time of the process by
`time.process_time`, which other programs on the machine hardly change, and wall time, which they do. OpenCV has one
thread. JPEGs are the simulated cameras' own with restart markers, as some webcams send them, and the same pictures coded
again without them and with 4:2:2 colours, as others do.
"""

# ruff: noqa: E402  arithmetic has to be fixed before NumPy is loaded, as in the sensing process
from nodal.arithmetic import pin

pin()

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from benchmarks.degradations.rigs import Rig, sized
from benchmarks.poses import LENGTH_MM, NODES_MM, Array, bent, centreline, photograph, renderers
from messaging.shape import NodalPoints, ShapeEstimate
from messaging.views import CentrelineView, NodalPointsView
from sensing.refined.method import Refined
from sensing.scene import Scene
from sensing.sensor import Sensor

CASES: dict[tuple[int, int], dict[int, int | None]] = {
    (640, 480): {60: None},
    (1280, 720): {60: 50},
    (1920, 1080): {30: 50},
    (3840, 2160): {10: 100, 30: None},
}
"""By size, rates in Hz and the share of one core in % that the yardsticks allow; None: no yardstick."""
POINTS = NodalPoints(names=tuple(f"{arc:g}" for arc in NODES_MM), arc_mm=NODES_MM)
SETS = 12
PASSES = 5
TURN_HZ = 0.1
"""So fast the robot goes round; its tip moves at 20 mm/s."""
STAGE_AGE_S = 0.5

FrameSet = dict[str, bytes]


@dataclass(frozen=True)
class Cost:
    """Medians in ms of a frame set's CPU and wall time, cold and warm, and how many warm ones were found anew."""

    cold_cpu_ms: float
    cold_wall_ms: float
    cpu_ms: float
    wall_ms: float
    anew: int


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    names = {f"{width}x{height}": (width, height) for width, height in CASES}
    parser.add_argument("--sizes", nargs="+", choices=names, default=list(names))
    sizes = [names[name] for name in parser.parse_args().sizes]
    cv2.setNumThreads(1)
    print(
        "two cameras, a frame set's medians in ms; share of one core at a rate, and what the yardstick allows"
    )
    print(
        f"{'size':>10} {'JPEG':<15} {'cold CPU':>8} {'wall':>6} {'warm CPU':>8} {'wall':>6}  share of one core"
    )
    for width, height in sizes:
        for kind, sets in _sights(width, height).items():
            cost = _cost(sized(width, height), sets)
            shares = ", ".join(_share(cost, rate, most) for rate, most in CASES[width, height].items())
            anew = f"; {cost.anew} found anew" if cost.anew else ""
            print(
                f"{f'{width}x{height}':>10} {kind:<15} {cost.cold_cpu_ms:8.1f} {cost.cold_wall_ms:6.1f} "
                f"{cost.cpu_ms:8.2f} {cost.wall_ms:6.2f}  {shares}{anew}",
                flush=True,
            )


def _share(cost: Cost, rate_hz: int, most: int | None) -> str:
    share = f"{rate_hz} Hz {cost.cpu_ms * rate_hz / 10:.0f} %"
    return share if most is None else f"{share} (allowed {most} %)"


def _sights(width: int, height: int) -> dict[str, list[FrameSet]]:
    """Frame sets of a robot that goes round, to and fro, by how they are coded."""
    cameras = renderers(sized(width, height))
    slowest_hz = min(CASES[width, height])
    turns_rad = 2 * np.pi * TURN_HZ / slowest_hz * np.arange(SETS)
    sets = [photograph(cameras, _pose(turn_rad)) for turn_rad in turns_rad]
    coded = {
        "restart markers": sets,
        "none, 4:2:2": [{name: _coded_again(jpeg) for name, jpeg in one.items()} for one in sets],
    }
    return {kind: [*there, *there[-2:0:-1]] for kind, there in coded.items()}


def _pose(turn_rad: float) -> Array:
    return centreline(bent((0.5, 0.8), (turn_rad, turn_rad + 0.6)))


def _coded_again(jpeg: bytes) -> bytes:
    picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    sampling = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422]
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85, *sampling])[1].tobytes()


def _cost(rig: Rig, sets: list[FrameSet]) -> Cost:
    scene = Scene.of(rig, length_mm=LENGTH_MM)
    cold = [_timed(lambda one=one: _sensed(_sensor(scene), one, 0)) for one in sets[:3]]
    sensor = _sensor(scene)
    _sensed(sensor, sets[0], 0)
    warm, estimates = [], []
    for number, one in enumerate(PASSES * sets):
        warm.append(_timed(lambda one=one, number=number: estimates.append(_sensed(sensor, one, number))))
    anew = sum("cold_start" in estimate.stage_names for estimate in estimates)
    return Cost(*np.median(cold, axis=0), *np.median(warm, axis=0), anew)


def _sensor(scene: Scene) -> Sensor:
    return Sensor(Refined(scene), POINTS, LENGTH_MM, STAGE_AGE_S)


def _sensed(sensor: Sensor, jpegs: FrameSet, number: int) -> ShapeEstimate:
    """All that the sensing process does with a frame set but for sending it."""
    estimate = sensor.estimate(jpegs, number, number, lambda: 0)
    estimate.to_bytes()
    CentrelineView.of(estimate).to_bytes()
    NodalPointsView.of(estimate).to_bytes()
    return estimate


def _timed(work: Callable[[], object]) -> tuple[float, float]:
    """CPU and wall time in ms."""
    cpu_s, wall_s = time.process_time(), time.perf_counter()
    work()
    return 1e3 * (time.process_time() - cpu_s), 1e3 * (time.perf_counter() - wall_s)


if __name__ == "__main__":
    main()
