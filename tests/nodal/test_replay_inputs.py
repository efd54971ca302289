"""What a cycle sees is put together again from what is said about it, so that the cycle can be repeated to the last bit."""

from pathlib import Path

import numpy as np
import pytest

from controller.account import Timing, account_of
from controller.loop import Loop
from controller.settings import ControllerSettings, OperatorSettings
from controller.wire import STOP_REQUEST
from messaging import topics
from messaging.control import Action, ActionRequest
from messaging.history import Asked
from messaging.message import Message
from messaging.settings import RobotSettings
from nodal.replay.cycles import ControlPart, inputs_of, request_of
from nodal.virtual.bench import VirtualBench
from nodal.virtual.settings import VirtualBenchSettings
from recordings.reader import Recorded

SETTINGS = ControllerSettings(operator=OperatorSettings(heartbeat_s=0.5, hold_s=0.5))
ROBOT = RobotSettings(section_length_mm=(40.0, 40.0))
HOME, JOG = ActionRequest(action=Action.HOME), ActionRequest(action=Action.JOG, axis="2", distance_mm=0.3)


def recorded(topic, message: Message, time_ns):
    """A message as a log holds it."""
    return Recorded(
        path=Path("log"),
        topic=topic.key,
        schema=message.protobuf.DESCRIPTOR.full_name,
        log_time_ns=time_ns,
        publish_time_ns=time_ns,
        sequence=0,
        payload=message.to_bytes(),
    )


class Logged:
    """A loop that writes down each cycle as the process does; shapes get capture times of their own."""

    def __init__(self):
        self._loop = Loop(SETTINGS, ROBOT)
        self.cycles = []
        self.heartbeat = False

    def start(self):
        return self._loop.start()

    def step(self, state, inputs):
        object.__setattr__(inputs, "heartbeat", self.heartbeat)
        after, outputs = self._loop.step(state, inputs)
        time_ns = len(self.cycles) + 1
        timing = Timing(written_s=inputs.now_s, time_ns=time_ns, lateness_s=0.0, busy_s=0.0, overruns=0)
        account = account_of(state, after, inputs, outputs, commanded=True, timing=timing)
        self.cycles.append((inputs, account, outputs, after))
        return after, outputs


def part_of(cycles):
    """The log of these cycles."""
    shapes, tendons, asked = {}, {}, {}
    for inputs, account, outputs, _ in cycles:
        time_ns = account.controller.time_ns
        if inputs.sighting is not None:
            shape = inputs.sighting.shape
            shapes[shape.capture_time_ns] = recorded(topics.SHAPE, shape, time_ns)
        if account.tendons is not None:
            tendons[time_ns] = recorded(topics.TENDON_STATE, account.tendons, time_ns)
        asked[time_ns] = [
            Asked.of(
                topics.STOP.key if request is STOP_REQUEST else topics.CONTROLLER_DO.key,
                request.to_bytes(),
                reply,
                time_ns,
            )
            for request, reply in zip(inputs.requests, outputs.replies, strict=True)
        ]
    return ControlPart(
        states=[], tendons=tendons, commands={}, asked=asked, shapes=shapes, memories={}, before=None
    )


@pytest.fixture(scope="module")
def run():
    """Home under a heartbeat, a jog, a drive that comes and goes, and a stop signal."""
    loop = Logged()
    bench = VirtualBench(VirtualBenchSettings(), SETTINGS, ROBOT, loop)
    loop.heartbeat = True
    bench.run(0.3)
    bench.run(2.0, HOME)
    loop.heartbeat = False
    bench.run(1.5)
    assert bench.state.supervision.fault.code == "operator_lost"
    bench.run(0.1, ActionRequest(action=Action.RELAX))
    loop.heartbeat = True
    bench.run(0.5)
    bench.run(0.5, JOG)
    bench.actuators.silent = {1}
    bench.run(0.3)
    assert bench.state.supervision.fault.code == "drive_lost"
    bench.actuators.silent = set()
    bench.run(1.5)
    bench.run(0.2, ActionRequest(action=Action.RELAX))
    bench.run(0.2, HOME)
    bench.run(0.2, STOP_REQUEST)
    assert bench.state.mode == "idle"
    return loop.cycles


def test_every_cycle_is_repeated_to_the_last_bit_from_its_log(run):
    part, again = part_of(run), Loop(SETTINGS, ROBOT)
    state = again.start()
    for inputs, account, outputs, after in run:
        rebuilt = inputs_of(account.controller, part, None)
        assert (rebuilt.heartbeat, rebuilt.absence, rebuilt.absence_fault) == (
            inputs.heartbeat,
            inputs.absence,
            inputs.absence_fault,
        )
        assert rebuilt.requests == inputs.requests
        state, repeated = again.step(state, rebuilt)
        assert state.to_bytes() == after.to_bytes()
        assert repeated.replies == outputs.replies
        assert repeated.reason == outputs.reason


def test_a_stop_signal_stands_in_the_log_as_an_order(run):
    part = part_of(run)
    stops = [asked for each in part.asked.values() for asked in each if asked.service == topics.STOP.key]
    assert len(stops) == 1
    assert request_of(stops[0]) == ActionRequest(action=Action.STOP)
    assert np.array_equal([stops[0].accepted], [True])
