"""Live progress on stderr: a table that is redrawn on a terminal, a line now and then elsewhere."""

import time

import numpy as np
from rich.table import Table
from rich.text import Text

from nodal.demo.telemetry import Telemetry
from nodal.live_display import LiveDisplay
from nodal.processes.launcher import Launcher

REDRAW_S = 0.5
LINE_S = 2.0


class Progress(LiveDisplay):
    """Shows how the bench fares. `show` is called often and draws rarely."""

    def __init__(self, launcher: Launcher, telemetry: Telemetry, watched: str, seconds: float) -> None:
        """`watched` is the nodal point whose place is shown, `seconds` how long the demo takes."""
        super().__init__(REDRAW_S, LINE_S)
        self._launcher = launcher
        self._telemetry = telemetry
        self._watched = watched
        self._seconds = seconds
        self._start_s = time.monotonic()

    def show(self) -> None:
        """Draw if it is time to."""
        self.draw(
            lambda: _table(self._facts()),
            lambda: " | ".join(f"{name} {value}" for name, value in self._facts().items()),
        )

    def _facts(self) -> dict[str, str]:
        elapsed_s = time.monotonic() - self._start_s
        shape, controller = self._telemetry.shape, self._telemetry.controller
        facts = {"time": f"{elapsed_s:.0f} of about {self._seconds:.0f} s"}
        if shape is None:
            facts["sensing"] = "silent"
        else:
            state = shape.refusal or ", ".join(shape.flags) or "good"
            age_ms = shape.capture_to_publish_ns / 1e6
            facts["sensing"] = f"{self._telemetry.shape_rate_hz:.1f} Hz, {age_ms:.0f} ms old, {state}"
            if self._watched in shape.node_names:
                place = shape.node_mm[shape.node_names.index(self._watched)]
                facts[self._watched] = " ".join(f"{value:.2f}" for value in place) + " mm"
        if controller is None:
            facts["controller"] = "silent"
        else:
            facts["controller"] = (
                f"{controller.state}, {self._telemetry.control_rate_hz:.0f} Hz, "
                f"{1e3 * controller.lateness_s:.1f} ms late, {controller.overruns} cycles missed"
            )
            if words := self._telemetry.timeliness.words:
                facts["latency"] = words
            if controller.target_name and np.isfinite(controller.tracking_error_mm):
                facts["tracking"] = f"{controller.target_name}, {controller.tracking_error_mm:.2f} mm off"
            if controller.reason:
                facts["because"] = controller.reason
        restarts = [
            f"{child.name} {child.restarts}" for child in self._launcher.children.values() if child.restarts
        ]
        if restarts:
            facts["restarts"] = ", ".join(restarts)
        return facts


def _table(facts: dict[str, str]) -> Table:
    table = Table.grid(padding=(0, 2))
    for name, value in facts.items():
        table.add_row(Text(name, style="bold"), Text(value))
    return table
