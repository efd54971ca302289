"""What a recording says about how the loop kept time."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from benchmarks.yardstick import yardstick
from messaging import topics
from messaging.control import ControllerState, State, TendonCommand
from messaging.shape import ShapeEstimate
from recordings import Log

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Figures:
    """Times in ms."""

    capture_to_command_ms: Array
    sensing_ms: Array
    """From capture until the estimate was published."""
    lateness_ms: Array
    busy_ms: Array
    rested: NDArray[np.bool_]
    """Of the cycles, those before which the loop slept; the others are late because the one before took too long."""
    overruns: int
    seconds: float
    tracked: float
    """Share of cycles in which the target was followed."""
    cores: Mapping[str, float]
    """What each process took of one core."""

    def show(self, out: TextIO) -> None:
        """Yardsticks first."""
        half, most = np.percentile(self.capture_to_command_ms, [50, 99])
        late = float(np.percentile(self.lateness_ms, 99))
        rate_hz = len(self.lateness_ms) / self.seconds
        for line in (
            yardstick("capture to command, p50", "<= 20 ms", f"{half:.1f} ms", met=half <= 20),
            yardstick("capture to command, p99", "<= 40 ms", f"{most:.1f} ms", met=most <= 40),
            yardstick("lateness of control cycles, p99", "<= 1 ms", f"{late:.2f} ms", met=late <= 1),
            yardstick("control cycles", ">= 199 Hz", f"{rate_hz:.1f} Hz", met=rate_hz >= 199),
        ):
            print(line, file=out)
        for name, values in (
            ("capture to command", self.capture_to_command_ms),
            ("capture to shape published", self.sensing_ms),
            ("lateness", self.lateness_ms),
            ("lateness after a rest", self.lateness_ms[self.rested]),
            ("busy", self.busy_ms),
        ):
            p50, p99, p100 = np.percentile(values, [50, 99, 100])
            print(f"{name:28} p50 {p50:6.2f}  p99 {p99:6.2f}  most {p100:6.2f} ms  n {len(values)}", file=out)
        print(f"overruns {self.overruns}; tracking in {100 * self.tracked:.1f} % of the cycles", file=out)
        shares = ", ".join(f"{name} {100 * share:.1f} %" for name, share in self.cores.items())
        print(f"of one core: {shares}", file=out)


def figures_of(recording: Path, begin_ns: int, end_ns: int, cores: Mapping[str, float]) -> Figures:
    """The figures of what was said between two Unix times."""
    wanted = (topics.TENDON_COMMAND, topics.CONTROLLER_STATE, topics.SHAPE)
    commands: list[TendonCommand] = []
    states: list[ControllerState] = []
    shapes: list[ShapeEstimate] = []
    for one in Log(recording).messages(wanted):
        if begin_ns <= one.publish_time_ns < end_ns:
            match message := one.message:
                case TendonCommand():
                    commands.append(message)
                case ControllerState():
                    states.append(message)
                case ShapeEstimate():
                    shapes.append(message)
    return figures_from(commands, states, shapes, (end_ns - begin_ns) / 1e9, cores)


def figures_from(
    commands: Sequence[TendonCommand],
    states: Sequence[ControllerState],
    shapes: Sequence[ShapeEstimate],
    seconds: float,
    cores: Mapping[str, float],
) -> Figures:
    """The figures of these messages."""
    ages = [one.capture_to_command_ns for one in commands if one.capture_to_command_ns >= 0]
    late_s, busy_s = (
        np.array([getattr(state, name) for state in states]) for name in ("lateness_s", "busy_s")
    )
    return Figures(
        capture_to_command_ms=np.array(ages) / 1e6,
        sensing_ms=np.array([shape.capture_to_publish_ns for shape in shapes]) / 1e6,
        lateness_ms=late_s * 1e3,
        busy_ms=busy_s * 1e3,
        # a state tells how long the cycle before it was busy
        rested=np.append(0.0, late_s[:-1]) + busy_s < states[0].dt_s,
        overruns=states[-1].overruns - states[0].overruns,
        seconds=seconds,
        tracked=float(np.mean([state.state is State.TRACKING for state in states])),
        cores=cores,
    )
