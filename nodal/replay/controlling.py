"""The controller over a log: each cycle through `Loop.step`, with what the controller carried from the cycle before."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from controller.account import Account, Timing, account_of
from controller.cycle import Inputs, LoopState, Outputs
from controller.loop import Loop
from messaging import topics
from messaging.control import ControllerState, Reply
from messaging.errors import NodalError
from messaging.history import Asked, Memory
from messaging.shape import ShapeEstimate
from nodal.bench_file import Bench
from nodal.errors import ReplayError
from nodal.replay.comparison import Comparison, compared, compared_bytes, skipped
from nodal.replay.cycles import ControlPart, Unseen, command_of, inputs_of
from nodal.replay.typed import read
from recordings.reader import Recorded

STATE_KEY, COMMAND_KEY, MEMORY_KEY, REPLY_KEY = (
    topic.key
    for topic in (topics.CONTROLLER_STATE, topics.TENDON_COMMAND, topics.CONTROLLER_MEMORY, topics.ASKED)
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Cycle:
    """One cycle that was run again: as logged, what it did, what it said, and what it left to the next one."""

    recorded: Recorded
    outputs: Outputs
    account: Account
    after: LoopState


def loop_of(bench: Bench) -> Loop:
    """The controller of this bench; raises ControllerSetupError."""
    return Loop(bench.settings.controller, bench.settings.robot)


def verify(part: ControlPart, bench: Bench) -> Comparison:
    """Every logged cycle against what the controller makes of the same inputs and the same memory."""
    loop = loop_of(bench)
    state, unknown = _recalled(part.before)
    found = Comparison()
    last: Recorded | None = None
    for recorded in part.states:
        logged = read(recorded, ControllerState)
        if recorded.sequence == 0:
            state = loop.start()
        elif last is not None and recorded.sequence != last.sequence + 1:
            state, unknown = None, "a cycle between the memory and it is missing from the log"
        last = recorded
        inputs = None
        try:
            inputs = inputs_of(logged, part, None)
        except Unseen as reason:
            # what broke the chain first is why nothing is known
            state, unknown = None, unknown if state is None else str(reason)
        if state is None or inputs is None:
            found += skipped(STATE_KEY, unknown)
        else:
            cycle = _run(loop, state, recorded, inputs, commanded=logged.commanded)
            state = cycle.after
            found += _compared(logged, part, cycle)
        if (memory := part.memories.get(logged.time_ns)) is not None:
            mine = b"" if state is None else state.to_bytes()
            if state is not None:
                found += compared_bytes(MEMORY_KEY, logged.time_ns, memory.content, mine)
            if mine != memory.content:
                state, unknown = _recalled(memory)
    return found


def imagine(part: ControlPart, bench: Bench, shapes: Mapping[int, ShapeEstimate] | None) -> Iterator[Cycle]:
    """What the controller would have done in every cycle; `shapes` by capture time stand in for those that it saw.

    It begins with the controller's start, or with the first memory in the log; cycles before are left out, and those
    whose inputs are not in the log. Raises ReplayError when that memory is of no use to these settings.
    """
    loop = loop_of(bench)
    state = None if part.before is None else _begun(part.before)
    for recorded in part.states:
        logged = read(recorded, ControllerState)
        if recorded.sequence == 0:
            state = loop.start()
        if state is not None:
            try:
                inputs = inputs_of(logged, part, shapes)
            except Unseen:
                continue
            cycle = _run(loop, state, recorded, inputs, commanded=None)
            state = cycle.after
            yield cycle
        elif (memory := part.memories.get(logged.time_ns)) is not None:
            state = _begun(memory)


def _run(
    loop: Loop, before: LoopState, recorded: Recorded, inputs: Inputs, *, commanded: bool | None
) -> Cycle:
    """`commanded` says whether the command could be written; None: whenever there was a drive to write it to."""
    logged = read(recorded, ControllerState)
    after, outputs = loop.step(before, inputs)
    if commanded is None:
        commanded = outputs.command_mm is not None and inputs.drive is not None
    timing = Timing(
        written_s=inputs.now_s,
        time_ns=logged.time_ns,
        lateness_s=logged.lateness_s,
        busy_s=logged.busy_s,
        overruns=logged.overruns,
    )
    account = account_of(before, after, inputs, outputs, commanded=commanded, timing=timing)
    return Cycle(recorded=recorded, outputs=outputs, account=account, after=after)


def _begun(memory: Memory) -> LoopState:
    state, why = _recalled(memory)
    if state is None:
        raise ReplayError(f"the log begins in the middle of a run, and {why}")
    return state


def _recalled(memory: Memory | None) -> tuple[LoopState | None, str]:
    if memory is None:
        return None, "it stands before the first memory in the log"
    try:
        return LoopState.from_bytes(memory.content), ""
    except NodalError as error:
        return None, f"the memory before it cannot be used: {error}"


def _compared(logged: ControllerState, part: ControlPart, cycle: Cycle) -> Comparison:
    return (
        compared(STATE_KEY, logged.time_ns, logged, cycle.account.controller)
        + _replies(part.asked.get(logged.time_ns, ()), cycle.outputs.replies)
        + _command(logged, part, cycle.account)
    )


def _command(logged: ControllerState, part: ControlPart, account: Account) -> Comparison:
    try:
        command = command_of(logged, part)
    except Unseen as reason:
        return skipped(COMMAND_KEY, str(reason))
    if command is None:
        return Comparison()
    if account.command is None:
        return compared_bytes(COMMAND_KEY, logged.time_ns, command.to_bytes(), b"")
    return compared(COMMAND_KEY, logged.time_ns, command, account.command)


def _replies(asked: Sequence[Asked], replies: tuple[Reply, ...]) -> Comparison:
    found = Comparison()
    for question, reply in zip(asked, replies, strict=True):
        found += compared(REPLY_KEY, question.time_ns, question.reply, reply)
    return found
