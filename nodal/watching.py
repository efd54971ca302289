"""The controller's state as one live line, and the operator's heartbeat while somebody looks at it."""

import shutil
import sys
import time
from typing import TextIO

from messaging import topics
from messaging.control import ControllerState, State
from messaging.session import open_session
from nodal.bench_file import read_bench

BEAT_S = 0.1
SILENT_AFTER_S = 1.0
SILENT = "the controller is silent"


def watch(config: str) -> int:
    """Until Ctrl-C; returns the exit status."""
    settings = read_bench(config).settings
    out = _Line(sys.stdout)
    try:
        with open_session(settings.zenoh, settings.name, "watch") as session:
            heartbeat, states = session.gives(topics.HEARTBEAT), session.newest(topics.CONTROLLER_STATE)
            heard_s = time.monotonic()
            while True:
                heartbeat.give()
                taken = states.take()
                if taken is not None and isinstance(taken[0], ControllerState):
                    heard_s = time.monotonic()
                    out.say(line(taken[0]))
                elif time.monotonic() - heard_s > SILENT_AFTER_S:
                    out.say(SILENT)
                time.sleep(BEAT_S)
    except KeyboardInterrupt:
        out.end()
        return 0


def line(state: ControllerState) -> str:
    """One cycle in words."""
    words = [f"{state.state}: {state.reason}" if state.reason else str(state.state)]
    if state.target_name and state.state in (State.TRACKING, State.HOLD):
        words.append(f"{state.target_name} {state.progress:.0%}, error {state.tracking_error_mm:.2f} mm")
    if state.advice:
        words.append(state.advice)
    return " | ".join(words)


class _Line:
    """On a terminal the line is written over and over; elsewhere every new one stands on its own."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._live = out.isatty()
        self._last = ""

    def say(self, text: str) -> None:
        if text == self._last:
            return
        self._last = text
        if self._live:
            width = shutil.get_terminal_size().columns - 1
            self._out.write(f"\r{text[:width]:<{width}}")
        else:
            self._out.write(f"{text}\n")
        self._out.flush()

    def end(self) -> None:
        if self._live:
            self._out.write("\n")
