"""What the benches are put through. Every disturbance is a change of the bench, of its sensing, or in the middle of a run."""

import dataclasses
from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.control.figures import Figures, stepped, tracked
from benchmarks.control.paths import CIRCLE, REST_MM, SPLINE_S, STEP_FROM_MM, STEP_TO_MM, point, spline
from benchmarks.control.robots import BENCH_ROBOT, OTHER_ROBOTS, Robot
from controller.limits import Limits
from controller.settings import ControllerSettings
from messaging.control import Target
from nodal.virtual.bench import VirtualBench
from nodal.virtual.errors import VirtualBenchError
from nodal.virtual.samples import Samples
from nodal.virtual.settings import VirtualBenchSettings

replace = msgspec.structs.replace

APPROACH_S = 4.0
"""How long a path is followed before it counts."""
TURN_S = 10.0
DISTURBED_AT_S = 2.5
"""When in the turn that counts something happens."""
PUSHED_S, BLIND_S = 2.0, 0.3

Build = Callable[[VirtualBenchSettings], VirtualBenchSettings]
Play = Callable[[VirtualBench, Limits], Figures]
Event = Callable[[VirtualBench], None]


def unchanged(bench: VirtualBenchSettings) -> VirtualBenchSettings:
    """The bench as it was drawn."""
    return bench


def circled(bench: VirtualBench, limits: Limits) -> Figures:
    """One turn of the circle, undisturbed."""
    return tracked(followed(bench, CIRCLE, TURN_S), limits)


def circled_by(robot: Robot) -> Play:
    """One turn of another robot's circle."""
    return lambda bench, limits: tracked(followed(bench, robot.circle, TURN_S), limits)


def splined(bench: VirtualBench, limits: Limits) -> Figures:
    """Once around the spline."""
    return tracked(followed(bench, spline(), SPLINE_S), limits)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scenario:
    """One row of the table."""

    name: str
    robot: Robot = BENCH_ROBOT
    build: Build = unchanged
    play: Play = circled
    """Begins with a bench that is homed."""
    disturbance: bool = True
    """Whether it counts as one of the disturbances on the circle."""
    sensing_only: bool = False
    """Whether only the shapes come otherwise, so that it is nothing new to open loop."""


def tuned(controller: ControllerSettings, bench: VirtualBenchSettings) -> ControllerSettings:
    """The controller with limits of trust that let this bench's shapes pass: old ones, and rare ones."""
    shape = bench.shape
    oldest_s = shape.delay_s + shape.jitter_s + bench.robot_step_s
    rarest_s = 1.5 / shape.rate_hz + shape.jitter_s + bench.robot_step_s
    sensing = replace(
        controller.sensing,
        maximum_age_s=max(controller.sensing.maximum_age_s, 1.2 * oldest_s),
        timeout_s=max(controller.sensing.timeout_s, rarest_s),
    )
    return replace(controller, sensing=sensing)


def begin(bench: VirtualBench, target: Target) -> None:
    """Give the target and arm; raises VirtualBenchError when that is refused."""
    for reply in (bench.target(target), bench.do("arm")):
        if not reply.accepted:
            raise VirtualBenchError(f"not accepted: {reply.reason}")


def followed(
    bench: VirtualBench,
    target: Target,
    duration_s: float,
    *events: tuple[float, Event],
) -> Samples:
    """A path, with `duration_s` of it counted; each event happens so many seconds into what counts."""
    begin(bench, target)
    bench.run(APPROACH_S)
    parts, past_s = [], 0.0
    for at_s, happens in events:
        parts.append(bench.run(at_s - past_s)[0])
        happens(bench)
        past_s = at_s
    return Samples.joined([*parts, bench.run(duration_s - past_s)[0]])


def step(bench: VirtualBench, limits: Limits) -> Figures:
    """10 mm sideways from rest, in the controller's own time."""
    begin(bench, point(STEP_FROM_MM))
    bench.run(APPROACH_S)
    first, _ = bench.run(0.0, point(STEP_TO_MM))
    samples = Samples.joined([first, bench.run(3.0)[0]])
    settle_s, overshoot = stepped(samples, np.array(STEP_FROM_MM), np.array(STEP_TO_MM))
    return dataclasses.replace(tracked(samples, limits), settle_s=settle_s, overshoot_percent=overshoot)


def rest(bench: VirtualBench, limits: Limits) -> Figures:
    """The last second at each of some places."""
    begin(bench, point(REST_MM[0]))
    parts = []
    for place in REST_MM:
        bench.target(point(place))
        bench.run(APPROACH_S)
        parts.append(bench.run(1.0)[0])
    figures = [tracked(part, limits) for part in parts]
    whole = tracked(Samples.joined(parts), limits)
    return dataclasses.replace(
        whole,
        violations=sum(figure.violations for figure in figures),
        unstable=any(figure.unstable for figure in figures),
    )


def shape(**changes: float) -> Build:
    """A bench whose shapes come otherwise."""
    return lambda bench: replace(bench, shape=replace(bench.shape, **changes))


def gains(factor: float) -> Build:
    """A bench whose tendons and stage all move by another amount than asked for."""
    return lambda bench: _geared(bench, np.full(len(bench.servos.gain), factor))


def mixed_gains(bench: VirtualBenchSettings) -> VirtualBenchSettings:
    """A bench each of whose axes moves 30 % further than asked for, or less far."""
    return _geared(bench, np.random.default_rng(bench.seed).choice([0.7, 1.3], len(bench.servos.gain)))


def _geared(bench: VirtualBenchSettings, factor: NDArray[np.float64]) -> VirtualBenchSettings:
    gain = tuple((factor * bench.servos.gain).tolist())
    return replace(bench, servos=replace(bench.servos, gain=gain))


def stiffer(bench: VirtualBenchSettings) -> VirtualBenchSettings:
    """A bench whose distal section is half as stiff again."""
    *others, distal = bench.robot.sections
    distal = replace(distal, youngs_modulus_GPa=1.5 * distal.youngs_modulus_GPa)
    return replace(bench, robot=replace(bench.robot, sections=(*others, distal)))


def during_the_turn(*events: tuple[float, Event]) -> Play:
    """One turn of the circle, with events so many seconds into it."""
    return lambda bench, limits: tracked(followed(bench, CIRCLE, TURN_S, *events), limits)


def pushed(bench: VirtualBench) -> None:
    """Somebody pushes the tip sideways, by 0.1 to 0.3 N."""
    chance = np.random.default_rng(bench.settings.seed)
    size_N, heading = chance.uniform(0.1, 0.3), chance.uniform(0, 2 * np.pi)
    bench.plant.robot.push(size_N * np.array([np.cos(heading), np.sin(heading), 0.0]))


def released(bench: VirtualBench) -> None:
    """Nobody pushes any more."""
    bench.plant.robot.push(np.zeros(3))


def loaded(bench: VirtualBench) -> None:
    """Another 20 g hang on the tip."""
    robot = bench.settings.robot
    bench.plant.robot.rebuild(replace(robot, tip_payload_g=robot.tip_payload_g + 20.0))


def slipped(bench: VirtualBench) -> None:
    """A pair slips by 0.5 mm on its pulley."""
    pull = bench.plant.robot.pull_per_displacement
    bench.plant.robot.slip(0.5 * pull[:, bench.settings.seed % pull.shape[1]])


def blinded(bench: VirtualBench) -> None:
    """Shapes come no more."""
    bench.seeing.lost = True


def sighted(bench: VirtualBench) -> None:
    """Shapes come again."""
    bench.seeing.lost = False


SCENARIOS = (
    Scenario(name="circle"),
    Scenario(name="spline", play=splined, disturbance=False),
    Scenario(name="step 10 mm", play=step, disturbance=False),
    Scenario(name="steady state", play=rest, disturbance=False),
    Scenario(name="distal +50 %", build=stiffer),
    Scenario(
        name="push",
        play=during_the_turn((DISTURBED_AT_S, pushed), (DISTURBED_AT_S + PUSHED_S, released)),
    ),
    Scenario(name="payload +20 g", play=during_the_turn((DISTURBED_AT_S, loaded))),
    Scenario(name="slip 0.5 mm", play=during_the_turn((DISTURBED_AT_S, slipped))),
    Scenario(
        name="blind for 0.3 s",
        play=during_the_turn((DISTURBED_AT_S, blinded), (DISTURBED_AT_S + BLIND_S, sighted)),
    ),
    Scenario(name="gains +30 %", build=gains(1.3)),
    Scenario(name="gains -30 %", build=gains(0.7)),
    Scenario(name="gains +-30 %", build=mixed_gains),
    Scenario(name="delay 0 ms", build=shape(delay_s=0.0, jitter_s=0.0), sensing_only=True),
    Scenario(name="delay 50 ms", build=shape(delay_s=0.05), sensing_only=True),
    Scenario(name="delay 100 ms", build=shape(delay_s=0.1), sensing_only=True),
    Scenario(name="delay 150 ms", build=shape(delay_s=0.15), sensing_only=True),
    Scenario(name="vision 10 Hz", build=shape(rate_hz=10.0), sensing_only=True),
    Scenario(name="vision 20 Hz", build=shape(rate_hz=20.0), sensing_only=True),
    Scenario(name="vision 60 Hz", build=shape(rate_hz=60.0), sensing_only=True),
    Scenario(name="20 % lost", build=shape(dropped=0.2), sensing_only=True),
    Scenario(name="noise 0.1 mm", build=shape(noise_mm=0.1), sensing_only=True),
    Scenario(name="noise 0.2 mm", build=shape(noise_mm=0.2), sensing_only=True),
    *(
        Scenario(name=robot.name, robot=robot, play=circled_by(robot), disturbance=False)
        for robot in OTHER_ROBOTS
    ),
)
