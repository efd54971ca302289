"""Cases of the cameras: where they stand, how they are timed, what is wrong with their calibration or their wiring."""

from collections.abc import Callable

import numpy as np

from benchmarks.degradations import coding, level, rigs
from benchmarks.degradations.level import FRAME_S, Case, Level
from benchmarks.degradations.rigs import Rig
from benchmarks.degradations.scenery import Bench
from benchmarks.poses import Array
from messaging.frames import CameraCalibration

FOCAL_PX = 1440.0
THREE, FOUR = Bench(rig=rigs.several(3)), Bench(rig=rigs.several(4))
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def _wrong(change: Callable[[CameraCalibration], CameraCalibration]) -> Callable[[Rig], Rig]:
    """The calibration of the left camera is wrong."""
    return lambda rig: tuple(change(camera) if camera.camera == "left" else camera for camera in rig)


def _turned(axis: tuple[float, float, float], angle_rad: float) -> Callable[[Rig], Rig]:
    return _wrong(lambda camera: rigs.turned(camera, axis, angle_rad))


def _moved(by_mm: Array) -> Callable[[Rig], Rig]:
    return _wrong(lambda camera: rigs.moved(camera, by_mm))


def _zoomed(factor: float) -> Callable[[Rig], Rig]:
    return _wrong(lambda camera: rigs.zoomed(camera, factor))


def _late(by_s: float) -> Callable[[str, float], float]:
    """Half of it too early in the left camera and too late in the right: the middle is the set's moment."""
    return lambda camera, time_s: time_s + (-by_s / 2 if camera == "left" else by_s / 2)


def _stale(by_s: float) -> Callable[[str, float], float]:
    return lambda camera, time_s: time_s - by_s if camera == "left" else time_s


def _frozen(camera: str, time_s: float) -> float:
    """The left camera hands over its last good picture again and again."""
    return -FRAME_S if camera == "left" else time_s


def _wrongly_calibrated() -> tuple[Level, ...]:
    turns = [
        (f"turned {px:g} px {way}", _turned(axis, px / FOCAL_PX))
        for way, axis in (("sideways", Y), ("upwards", X))
        for px in (3.0, 10.0, 30.0)
    ]
    rolls = [(f"rolled {degrees:g} degrees", _turned(Z, np.deg2rad(degrees))) for degrees in (0.3, 1.0)]
    zooms = [(f"focal length {share:+.0%}", _zoomed(1 + share)) for share in (0.01, 0.03)]
    shifts = [
        (f"{mm:g} mm {way}", _moved(mm * np.array(axis)))
        for way, axis in (("sideways", X), ("upwards", Y), ("nearer", Z))
        for mm in (1.0, 3.0)
    ]
    lens = [("no distortion", _wrong(rigs.undistorted))]
    wrong = [*turns, *rolls, *zooms, *shifts, *lens]
    return tuple(Level(name=name, believed=believed) for name, believed in wrong)


CAMERA_CASES = (
    Case(
        "distance",
        tuple(Level(name=f"{mm:g} mm", bench=Bench(rig=rigs.away(mm))) for mm in (130.0, 300.0, 450.0)),
    ),
    Case(
        "angle between cameras",
        tuple(
            Level(name=f"{degrees:g} degrees", bench=Bench(rig=rigs.apart(degrees)))
            for degrees in (20.0, 40.0, 90.0, 120.0)
        ),
    ),
    Case(
        "picture size",
        tuple(
            Level(name=f"{width}x{height}", bench=Bench(rig=rigs.sized(width, height)))
            for width, height in ((640, 480), (1280, 720), (3840, 2160))
        ),
    ),
    Case("cameras", (Level(name="3", bench=THREE), Level(name="4", bench=FOUR))),
    Case(
        "camera lost",
        (
            Level(name="1 of 2", handed=level.without("left")),
            Level(name="1 of 3", bench=THREE, handed=level.without("left")),
            Level(name="2 of 3", bench=THREE, handed=level.without("left", "above")),
            Level(name="2 of 4", bench=FOUR, handed=level.without("left", "above")),
        ),
    ),
    Case(
        "bad picture",
        (
            *(
                Level(name=f"{change.__name__}, 1 of 2", handed=level.replaced("left", change))
                for change in (coding.cut, coding.damaged, coding.halved, coding.blackened)
            ),
            *(
                Level(name=f"{change.__name__}, 1 of 3", bench=THREE, handed=level.replaced("left", change))
                for change in (coding.cut, coding.blackened)
            ),
        ),
    ),
    Case("cameras swapped", (Level(name="2 of 2", handed=level.swapped("left", "right")),)),
    Case("calibration", _wrongly_calibrated()),
    Case(
        "skew",
        tuple(Level(name=f"{1e3 * by_s:g} ms", captured=_late(by_s)) for by_s in (0.005, 0.012, 0.033, 0.1)),
    ),
    Case(
        "stale picture",
        (
            Level(name="frozen camera", captured=_frozen),
            *(Level(name=f"{by_s:g} s old", captured=_stale(by_s)) for by_s in (0.1, 0.3, 1.0)),
        ),
    ),
)
