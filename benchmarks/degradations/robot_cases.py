"""Cases of the robot itself, its poses, and what else is in the scene."""

import numpy as np

from benchmarks.degradations import motions, optics, rigs
from benchmarks.degradations.level import Case, Level
from benchmarks.degradations.motions import eye
from benchmarks.degradations.scenery import REFERENCE, Bench
from benchmarks.poses import Array
from drivers.simulated.cameras.settings import BodySettings

LEFT, RIGHT = REFERENCE.rig
DARK = (60, 56, 56)


def _azimuth(camera_eye_mm: Array) -> float:
    return float(np.arctan2(camera_eye_mm[1], camera_eye_mm[0]))


def _beside(apart_mm: float) -> optics.Optics:
    """A stick that stands upright beside the base."""
    foot, top = np.array([apart_mm, 0.0, 0.0]), np.array([apart_mm, 0.0, 70.0])
    return optics.with_stick(lambda _: (foot, top))


def _crossing(arc_mm: int, from_mm: tuple[float, float, float]) -> optics.Optics:
    """A stick that comes from somewhere and touches the robot."""
    return optics.with_stick(lambda points: (np.array(from_mm), points[arc_mm]))


def _longer(by_mm: float) -> optics.Optics:
    """A stick that goes on where the robot ends."""

    def _place(points: Array) -> tuple[Array, Array]:
        tangent = (points[-1] - points[-2]) / np.linalg.norm(points[-1] - points[-2])
        return points[-1] - 2 * tangent, points[-1] + by_mm * tangent

    return optics.with_stick(_place)


ROBOT_CASES = (
    Case(
        "thickness",
        tuple(
            Level(name=f"{mm:g} mm", bench=Bench(body=BodySettings(diameter_mm=(mm, mm))))
            for mm in (2.0, 3.0, 4.0, 8.0, 12.0)
        ),
    ),
    Case(
        "self-overlap",
        (
            Level(name="left view", motion=motions.towards(_azimuth(eye(LEFT)), 1.3, 1.3)),
            Level(name="left view, from behind", motion=motions.towards(_azimuth(-eye(LEFT)), 1.3, 1.3)),
            Level(name="hook between the cameras", motion=motions.towards(-np.pi / 2, 1.3, 1.3)),
            Level(name="S in left view", motion=motions.towards(_azimuth(eye(LEFT)), 1.3, -1.3)),
            Level(name="loop", motion=motions.towards(_azimuth(eye(LEFT)) + np.pi / 2, 2.7, 2.7)),
        ),
    ),
    Case(
        "along epipolar line",
        tuple(
            Level(
                name=f"{degrees} degrees off", motion=motions.along_baseline(LEFT, RIGHT, np.deg2rad(degrees))
            )
            for degrees in (20, 10, 5, 0)
        ),
    ),
    Case(
        "straight at a camera",
        tuple(
            Level(name=f"{degrees} degrees off", motion=motions.pointing_at(LEFT, np.deg2rad(degrees)))
            for degrees in (20, 10, 5, 0)
        ),
    ),
    Case(
        "hidden in one view",
        (
            Level(name="5 mm, like the backdrop", optics=optics.covered("left", 50, 5, None)),
            Level(name="15 mm, like the backdrop", optics=optics.covered("left", 50, 15, None)),
            Level(name="15 mm, dark", optics=optics.covered("left", 50, 15, DARK)),
            Level(name="tip, like the backdrop", optics=optics.covered("left", 80, 10, None)),
            Level(name="tip, dark", optics=optics.covered("left", 80, 10, DARK)),
            Level(name="base, dark", optics=optics.covered("left", 8, 15, DARK)),
        ),
    ),
    Case(
        "two objects",
        (
            Level(name="40 mm apart", optics=_beside(40)),
            Level(name="12 mm apart", optics=_beside(-12)),
            Level(name="touching at 30 mm", optics=_crossing(30, (60, 10, 50))),
            Level(name="touching at 60 mm", optics=_crossing(60, (-50, -10, 100))),
            Level(name="touching the tip", optics=_crossing(80, (-50, 20, 90))),
            Level(name="10 mm longer", optics=_longer(10)),
            Level(name="2 mm longer", optics=_longer(2)),
        ),
    ),
    Case(
        "out of view",
        (
            Level(name="upper part", bench=Bench(rig=rigs.aside(0, -330)), motion=motions.anywhere(0.7)),
            Level(
                name="upper part in one view",
                bench=Bench(rig=rigs.aside(0, -330, ("left",))),
                motion=motions.anywhere(0.7),
            ),
            Level(name="base", bench=Bench(rig=rigs.aside(0, 420)), motion=motions.anywhere(0.7)),
            Level(name="one side", bench=Bench(rig=rigs.aside(860, 0)), motion=motions.anywhere(0.7)),
            Level(name="wholly in one view", bench=Bench(rig=rigs.aside(2400, 0, ("left",)))),
            Level(name="wholly", bench=Bench(rig=rigs.aside(2400, 0))),
        ),
    ),
)
