"""How long it takes to plan a way between shapes, and to check a target: `python -m benchmarks.planning`.

Scenes are random and seeded: balls and a wall around a robot, a free shape to begin with, and the tip's place in another.
Beside scenes as they come stand those whose straight way leads into a region. Every way that is found is looked at again,
five times as closely as planning looks.
"""

import argparse
import dataclasses
import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import medians_s
from controller.errors import NoWayError, TargetError
from controller.planning.plan import Plan, plan
from controller.planning.search import Search
from controller.planning.space import Space, interpolated
from controller.plant import Plant
from controller.reachability import check_target
from controller.regions import HalfSpace, Region, Sphere
from controller.settings import ControllerSettings, SectionTendons
from messaging.control import Target
from messaging.settings import RobotSettings
from nodal import targets

Array = NDArray[np.float64]

SCENES, CHECKS = 50, 30
LENGTH_MM = 80.0
PLACES_MM = ((-55.0, -55.0, 15.0), (55.0, 55.0, 115.0))
RADIUS_MM = (4.0, 14.0)
CLOSER = 5
PATH_S = 80.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Kind:
    """A robot and how many balls stand around it."""

    name: str
    sections: int
    stage: bool
    balls: int


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A way to be planned."""

    settings: ControllerSettings
    plant: Plant
    begin: Array
    goal: Array
    target: Target


KINDS = (
    Kind(name="2 sections, stage, 3 balls", sections=2, stage=True, balls=3),
    Kind(name="2 sections, stage, 8 balls", sections=2, stage=True, balls=8),
    Kind(name="2 sections, 5 balls", sections=2, stage=False, balls=5),
    Kind(name="3 sections, stage, 5 balls", sections=3, stage=True, balls=5),
)


def scenes(kind: Kind, count: int, *, blocked: bool) -> Iterator[Scene]:
    """So many scenes of a kind; with `blocked` only those whose straight way leads into a region."""
    random = np.random.default_rng(1)
    sections = tuple(SectionTendons(pair_angle_deg=(30.0 * n, 30.0 * n + 90)) for n in range(kind.sections))
    robot = RobotSettings(section_length_mm=(LENGTH_MM / kind.sections,) * kind.sections, stage=kind.stage)
    while count:
        settings = ControllerSettings(sections=sections, forbidden=_regions(random, kind.balls))
        space = Space(Plant.of(settings, robot))
        begin, goal = _free(space, random), _free(space, random)
        if blocked and Search(space, 0.0, 0).way(begin, goal[None], 0) is not None:
            continue
        tip, _ = space.nodes_and_jacobian(goal, np.array([LENGTH_MM]))
        count -= 1
        yield Scene(
            settings=settings,
            plant=space.plant,
            begin=begin,
            goal=goal,
            target=targets.points({"tip": tip[0].tolist()}, {}),
        )


def _regions(random: np.random.Generator, balls: int) -> tuple[Region, ...]:
    regions: list[Region] = [HalfSpace(name="wall", point_mm=(0.0, -50.0, 0.0), normal=(0.0, 1.0, 0.0))]
    while len(regions) <= balls:
        x, y, z = random.uniform(*PLACES_MM).tolist()
        radius = float(random.uniform(*RADIUS_MM))
        if np.hypot(x, y) > radius + 8:
            regions.append(Sphere(name=f"ball {len(regions)}", centre_mm=(x, y, z), radius_mm=radius))
    return tuple(regions)


def _free(space: Space, random: np.random.Generator) -> Array:
    while True:
        configuration = space.random(random)
        if space.spare_mm(configuration) > 1:
            return configuration


def planned(scene: Scene) -> Plan:
    """The plan of a scene, through four nodal points; raises TargetError."""
    arcs = {name: LENGTH_MM * share for name, share in (("a", 0.25), ("b", 0.5), ("c", 0.75), ("tip", 1.0))}
    return plan(scene.target, arcs, scene.begin, scene.plant, scene.settings)


def plan_line(kind: Kind, *, blocked: bool) -> str:
    """One row of the table."""
    times, samples, ways_s, no_way, refused, worst_mm = [], [], [], 0, 0, np.inf
    for scene in scenes(kind, SCENES, blocked=blocked):
        start = time.perf_counter()
        try:
            found = planned(scene)
        except NoWayError:
            no_way += 1
        except TargetError:
            refused += 1
        else:
            samples.append(found.way.samples)
            ways_s.append(found.way_s)
            worst_mm = min(worst_mm, _closely(scene, found))
        times.append(time.perf_counter() - start)
    median, high, most = 1e3 * np.quantile(times, [0.5, 0.9, 1.0])
    scene_kind = "blocked" if blocked else "any"
    return (
        f"{kind.name:28} {scene_kind:8} {len(ways_s):4d} {no_way:5d} {refused:7d} {median:9.0f} {high:7.0f} {most:7.0f} "
        f"{np.median(samples):8.0f} {np.median(ways_s):7.1f} {worst_mm:9.2f}"
    )


def _closely(scene: Scene, found: Plan) -> float:
    way = found.way.configurations
    places = np.linspace(0, len(way) - 1, CLOSER * len(way))
    between = interpolated(places, np.arange(len(way)), way)
    return float(Space(scene.plant).spare_mm(between).min())


def check_lines() -> Iterator[str]:
    """What it costs to check circles of 120 places and a path of 2000, with and without regions, accepted and refused."""
    robot = RobotSettings(section_length_mm=(LENGTH_MM / 2, LENGTH_MM / 2))
    regions = (
        Sphere(name="lamp", centre_mm=(30.0, 30.0, 60.0), radius_mm=10.0),
        Sphere(name="knob", centre_mm=(0.0, -30.0, 40.0), radius_mm=10.0),
        HalfSpace(name="wall", point_mm=(-35.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0)),
    )
    start_mm = np.array([[0.0, 0.0, LENGTH_MM]])
    asked = {
        "circle in reach": _circle(85.0, 15.0),
        "circle bent": _circle(70.0, 15.0),
        "circle far out": _circle(40.0, 60.0),
        "circle too far": _circle(40.0, 80.0),
        "path of 2000 places": _long_path(),
    }
    works = {}
    for what, target in asked.items():
        for forbidden in ((), regions):
            settings = ControllerSettings(forbidden=forbidden)
            plant = Plant.of(settings, robot)

            def check(
                target: Target = target, plant: Plant = plant, settings: ControllerSettings = settings
            ) -> bool:
                try:
                    check_target(target, {"tip": LENGTH_MM}, plant, settings, start_mm=start_mm)
                except TargetError:
                    return False
                return True

            works[f"{what}, {len(forbidden)} regions: {'accepted' if check() else 'refused'}"] = check
    for name, median_s in medians_s(works, CHECKS).items():
        yield f"check of a {name:40} {1e3 * median_s:6.1f} ms"


def _circle(height_mm: float, radius_mm: float) -> Target:
    return targets.circle(
        "tip", radius_mm=radius_mm, period_s=40.0, height_mm=height_mm, centre_mm=(0.0, 0.0)
    )


def _long_path() -> Target:
    """Round and round, each round a little wider, through 2000 places."""
    turn, radius_mm = np.linspace(0, 16 * np.pi, 2000), np.linspace(5, 25, 2000)
    places = np.stack([radius_mm * np.cos(turn), radius_mm * np.sin(turn), np.full(2000, 85.0)], axis=-1)
    gone_mm = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
    return Target(
        name="path",
        node_names=("tip",),
        weights=np.ones(1),
        time_s=gone_mm * PATH_S / gone_mm[-1],
        position_mm=places[:, None],
        repeat=False,
    )


def main() -> None:
    """Print both tables."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    print("\n".join(check_lines()), flush=True)
    print(
        f"\n{'robot':28} {'scenes':8} found no way refused median ms  90 % ms  max ms  samples   way s  spare mm"
    )
    for kind in KINDS:
        for blocked in (False, True):
            print(plan_line(kind, blocked=blocked), flush=True)


if __name__ == "__main__":
    main()
