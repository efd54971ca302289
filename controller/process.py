"""The controller's process: read, decide, write, publish, keep time. One thread; no worker threads beside it."""

import gc
import logging
import sys
import time
from collections.abc import Callable
from typing import Protocol

from controller import account, real_time
from controller.cycle import Inputs
from controller.drive import Drive
from controller.loop import Loop
from controller.pace import Pace
from controller.punctuality import Punctuality
from controller.settings import ControllerSettings
from controller.wire import Wire
from drivers.actuators import Actuators
from messaging.session import Session
from messaging.settings import RobotSettings

logger = logging.getLogger(__name__)

_CYCLES_PER_COLLECTION = 200
_MEMORY_PERIOD_S = 1.0


class Stop(Protocol):
    """Says when to end; a threading.Event does."""

    def is_set(self) -> bool:
        """True once the process should end."""
        ...


def run(
    settings: ControllerSettings,
    robot: RobotSettings,
    actuators: Actuators,
    session: Session,
    stop: Stop,
    healthy: Callable[[], None],
) -> None:
    """Control the robot until `stop`; however this ends, the tendons are let go.

    Raises ControllerSetupError when the settings do not fit the robot, and RealTimeRefusedError. A missing drive or silent
    sensing ends nothing.
    """
    loop = Loop(settings, robot)
    real_time.enter(settings.real_time)
    state, busy_s, remember_at_s = loop.start(), 0.0, 0.0
    drive = Drive(actuators)
    wire = Wire(session, time.monotonic())
    sys.setswitchinterval(0.0002)  # a busy foreign thread may then hold the interpreter for 0.2 ms, not 5
    gc.collect()
    gc.freeze()
    gc.disable()  # what collections there are come after a cycle's work
    pace = Pace(settings.rate_hz)
    punctuality = Punctuality(time.monotonic())
    try:
        while not stop.is_set():
            beat = pace.wait()
            # the servos' answer takes longest: what comes meanwhile is seen in this cycle
            reading = drive.read(beat.now_s)
            inputs = Inputs(
                now_s=beat.now_s,
                dt_s=beat.dt_s,
                sighting=wire.sighting(beat.now_s),
                drive=reading,
                absence=drive.absence,
                absence_fault=drive.absence_fault,
                requests=wire.requests(),
                heartbeat=wire.heartbeat(),
            )
            before, (state, outputs) = state, loop.step(state, inputs)
            written = drive.act(outputs, beat.now_s)
            timing = account.Timing(
                written_s=time.monotonic(),
                time_ns=time.time_ns(),
                lateness_s=beat.lateness_s,
                busy_s=busy_s,
                overruns=beat.overruns,
            )
            said = account.account_of(before, state, inputs, outputs, commanded=written, timing=timing)
            number = wire.say(outputs, said)
            if beat.now_s >= remember_at_s:
                remember_at_s = beat.now_s + _MEMORY_PERIOD_S
                wire.say_memory(state, timing.time_ns, number)
            if state.mode is not before.mode:
                logger.info("%s: %s", state.mode, outputs.reason)
            for level, line in punctuality.told(timing, said.command, beat.now_s):
                logger.log(level, "%s", line)
            healthy()
            if beat.cycle % _CYCLES_PER_COLLECTION == 0:
                gc.collect(0)
            busy_s = time.monotonic() - beat.now_s
    finally:
        drive.close()
        gc.enable()
        gc.unfreeze()
