"""One level, one pose, one method: estimates without a prior and with one, held against the truth."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.stats import chi2

from benchmarks.degradations.level import FRAME_S, Level
from benchmarks.degradations.motions import Mover
from benchmarks.degradations.optics import untouched
from benchmarks.degradations.scenery import Bench
from benchmarks.poses import NODES_MM, Array, true_nodes
from messaging.shape import NodalPoints
from sensing.errors import SensingError
from sensing.method import METHODS, Method
from sensing.refined.track import Track
from sensing.set_inputs import SetInputs
from sensing.settings import MethodName
from sensing.shape import Shape
from sensing.step import Clocks, seen_by_the_rest

SILENT_MM = 1.0
"""An estimate without a flag of which a nodal point is off by more is a silent error."""
WARM_FRAMES = 3
POINTS = NodalPoints(names=tuple(f"{arc:g}" for arc in NODES_MM), arc_mm=NODES_MM)
CLOCKS = Clocks(stage_s=time.perf_counter, age_ns=lambda: 0)
INSIDE = float(chi2(3).ppf(0.95))
"""The squared Mahalanobis distance of the 95 % ellipsoid."""
LEAST_VARIANCE_MM2 = 1e-12


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came of one set of pictures: a shape, or words why there is none.

    `error_mm` (8,) and `inside` (8,), whether the truth lies in the 95 % ellipsoid, are those of the nodal points;
    both are empty without a shape. `broken` is a refusal nobody meant: an error that is not sensing's own.
    """

    warm: bool
    frame: int
    seconds: float
    error_mm: Array
    inside: Array
    flags: tuple[str, ...]
    refusal: str = ""
    broken: bool = False

    @property
    def start(self) -> str:
        """How the estimate began."""
        if self.warm:
            return f"warm-{self.frame}"
        return "prior" if self.frame < 0 else "cold"

    @property
    def trusted(self) -> bool:
        """A shape that nothing speaks against."""
        return not (self.refusal or self.flags)

    @property
    def silent(self) -> bool:
        """Wrong, and nothing says so."""
        return self.trusted and not bool((self.error_mm <= SILENT_MM).all())


@dataclass(frozen=True, eq=False)
class Seen:
    """An outcome, and what is needed to look at it again."""

    outcome: Outcome
    shape: Shape | None
    pictures: Mapping[str, bytes]
    truth_mm: Array


def run(level: Level, method: MethodName, number: int) -> Iterator[Seen]:
    """One estimate without a prior, then frame after frame from a shape found in undegraded pictures."""
    estimator = METHODS[method](level.scene())
    frames = [level.pictures(number, frame * FRAME_S) for frame in range(WARM_FRAMES)]
    motion = level.moves(number)
    yield _judged(estimator, frames[0], None, motion.at(0.0), warm=False, frame=0)
    track = _track(prior(level, method, number))
    for frame, pictures in enumerate(frames):
        seen = _judged(estimator, pictures, track, motion.at(frame * FRAME_S), warm=True, frame=frame)
        track = _track(seen)
        yield seen


def prior(level: Level, method: MethodName, number: int) -> Seen:
    """What comes of undegraded pictures taken one frame before the first, with a true calibration and no prior."""
    return _undegraded(level.bench, level.motion, level.background is not None, method, number)


def held_against(shape: Shape, truth_mm: Array) -> tuple[Array, Array]:
    """Errors (8,) in mm of the nodal points against a centreline (81, 3), and which truth lies in its 95 % ellipsoid.

    Raises NodalPointError when the shape is too short for them.
    """
    found_mm, covariance = shape.nodes(NODES_MM)
    off = found_mm - true_nodes(truth_mm)
    variance, axes = np.linalg.eigh(covariance)
    along = np.einsum("nij,ni->nj", axes, off)
    # a direction that a covariance claims to know exactly has room for no truth
    distance = (along**2 / np.maximum(variance, LEAST_VARIANCE_MM2)).sum(axis=1)
    return np.linalg.norm(off, axis=1), distance <= INSIDE


def _judged(
    method: Method,
    pictures: Mapping[str, bytes],
    track: Track | None,
    truth_mm: Array,
    *,
    warm: bool,
    frame: int,
) -> Seen:
    nothing = np.empty(0)
    start = time.perf_counter()
    try:
        shape = _estimate(method, pictures, track)
        seconds = time.perf_counter() - start
        error_mm, inside = held_against(shape, truth_mm)
    except Exception as error:  # noqa: BLE001  whatever it is belongs in the table, and must not end it
        seconds = time.perf_counter() - start
        broken = not isinstance(error, SensingError)
        reason = f"{type(error).__name__}: {error}" if broken else str(error)
        outcome = Outcome(warm, frame, seconds, nothing, nothing, (), reason, broken)
        return Seen(outcome, None, pictures, truth_mm)
    flags = tuple(map(str, shape.flags))
    return Seen(Outcome(warm, frame, seconds, error_mm, inside, flags), shape, pictures, truth_mm)


def _estimate(method: Method, pictures: Mapping[str, bytes], track: Track | None) -> Shape:
    inputs = SetInputs(
        jpegs=pictures, sequence=0, capture_time_ns=0, insertion_mm=0.0, base_known=True, points=POINTS
    )
    return seen_by_the_rest(method, inputs, track, CLOCKS, {})


@lru_cache(maxsize=32)
def _undegraded(bench: Bench, motion: Mover, background: bool, method: MethodName, number: int) -> Seen:
    clean = Level(name="undegraded", bench=bench, motion=motion, background=untouched if background else None)
    truth_mm = clean.moves(number).at(-FRAME_S)
    pictures = clean.pictures(number, -FRAME_S)
    return _judged(METHODS[method](clean.scene()), pictures, None, truth_mm, warm=False, frame=-1)


def _track(seen: Seen) -> Track | None:
    return None if seen.shape is None else seen.shape.track
