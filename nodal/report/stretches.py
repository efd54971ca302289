"""What the controller was doing, stretch by stretch, and which targets it was after. Pure."""

import dataclasses
import re
from collections import Counter
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from messaging.control import ControllerState, State, Target
from nodal.report.bench_run import BenchRun

SILENCE_NS = 500_000_000
"""Cycles further apart than this say nothing about what was between them."""
HEARD_LATE_NS = 100_000_000
"""A target is logged at most this long after the cycle that took it up."""

UNRECORDED = -1
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stretch:
    """Cycles one after another in the same state, for the same target and reason. Times are Unix ns."""

    begin_ns: int
    end_ns: int
    state: State
    target_name: str
    reason: str

    @property
    def duration_s(self) -> float:
        """Until the next stretch began, or the last cycle before a silence."""
        return (self.end_ns - self.begin_ns) / 1e9

    @property
    def by_itself(self) -> bool:
        """True for a hold that no operator asked for."""
        return self.state is State.HOLD and "operator" not in self.reason


def stretches(states: Sequence[ControllerState]) -> list[Stretch]:
    """In order of time."""
    found: list[Stretch] = []
    begin = 0
    for index, state in enumerate(states):
        last = index == len(states) - 1
        silent = not last and states[index + 1].time_ns - state.time_ns > SILENCE_NS
        if last or silent or _doing(states[index + 1]) != _doing(state):
            first = states[begin]
            found.append(
                Stretch(
                    begin_ns=first.time_ns,
                    end_ns=state.time_ns if last or silent else states[index + 1].time_ns,
                    state=first.state,
                    target_name=first.target_name,
                    reason=first.reason,
                )
            )
            begin = index + 1
    return found


def without_numbers(reason: str) -> str:
    """A reason's kind: what is the same however long, late or far it was."""
    return NUMBER.sub("…", reason)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Pursuit:
    """The cycles that were after one target, whether it was followed or waited; `target` is None when it was not recorded."""

    label: str
    target: Target | None
    states: list[ControllerState]

    @property
    def followed(self) -> list[ControllerState]:
        """The cycles that tracked."""
        return [state for state in self.states if state.state is State.TRACKING]

    @property
    def names(self) -> tuple[str, ...]:
        """The nodal points that count; all of them when it is not known what they weigh."""
        if self.target is None:
            return self.states[0].node_names if self.states else ()
        weighed = zip(self.target.node_names, self.target.weights, strict=True)
        return tuple(name for name, weight in weighed if weight > 0)

    @cached_property
    def duration_s(self) -> float:
        """Of all its cycles."""
        return sum(stretch.duration_s for stretch in stretches(self.states))

    @cached_property
    def followed_s(self) -> float:
        """Of those that tracked."""
        return sum(
            stretch.duration_s for stretch in stretches(self.states) if stretch.state is State.TRACKING
        )


def pursuits(run: BenchRun) -> list[Pursuit]:
    """One for each different target, in the order in which they were first gone after; a target asked again is the same."""
    found: dict[tuple[object, ...], Pursuit] = {}
    namesakes: Counter[str] = Counter()
    distinct: list[Target] = []
    in_force: dict[tuple[object, ...], int] = {}
    waiting = list(reversed(run.accepted))
    for state in run.states:
        while waiting and waiting[-1].time_ns <= state.time_ns + HEARD_LATE_NS:
            target = waiting.pop().target
            number = next((n for n, known in enumerate(distinct) if known == target), len(distinct))
            distinct[number:] = distinct[number:] or [target]
            in_force[target.name, target.node_names] = number
        if not state.target_name or state.state not in (State.TRACKING, State.HOLD):
            continue
        number = in_force.get((state.target_name, state.node_names), UNRECORDED)
        what = state.target_name, state.node_names, number
        if what not in found:
            namesakes[state.target_name] += 1
            before = namesakes[state.target_name] - 1
            found[what] = Pursuit(
                label=f"{state.target_name} ({before + 1})" if before else state.target_name,
                target=None if number == UNRECORDED else distinct[number],
                states=[],
            )
        found[what].states.append(state)
    return list(found.values())


def seconds_in(found: Sequence[Stretch], state: State) -> float:
    """How long the controller was in this state."""
    return float(np.sum([stretch.duration_s for stretch in found if stretch.state is state]))


def _doing(state: ControllerState) -> tuple[str, ...]:
    # while tracking, the reason says what was limited in this very cycle
    reason = "" if state.state is State.TRACKING else state.reason
    return state.state, state.target_name, reason
