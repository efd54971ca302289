"""The virtual bench, asked and watched as the bus is: what moves a robot to be identified moves this one too."""

import numpy as np

from messaging.control import Action, ActionRequest, Reply
from nodal.calibrate.hand import Glimpse
from nodal.errors import CalibrationError
from nodal.virtual.bench import VirtualBench

_LOOK_S = 0.03


class VirtualHand:
    """Implements `nodal.calibrate.hand.Hand`."""

    def __init__(self, bench: VirtualBench) -> None:
        """The bench may be changed meanwhile: that is how things go wrong."""
        self.bench = bench
        self._last = -1

    def ask(self, action: Action, axis: str = "", distance_mm: float = 0.0) -> Reply:
        """See `Hand`; time goes on until the controller has answered: by one step of the robot while its servos answer it."""
        self.bench.ask(ActionRequest(action=action, axis=axis, distance_mm=distance_mm))
        while not (replies := self.bench.run(0.0)[1]):
            pass
        return replies[0]

    def watch(self) -> Glimpse:
        """See `Hand`."""
        bench = self.bench
        bench.run(_LOOK_S)
        state, drive, seen = bench.state, bench.heard, bench.sighted
        if drive is None:
            raise CalibrationError("the servos are not heard")
        fresh = None if seen is None or seen.shape.sequence == self._last else seen.shape
        if fresh is not None:
            self._last = fresh.sequence
        told = state.supervision.told
        return Glimpse(
            now_s=bench.now_s,
            state=state.mode.state.value,
            reason=state.supervision.reason,
            advice=told.get("advice", ""),
            fault=told.get("fault", ""),
            absence=bench.absence,
            command_mm=state.command_mm if state.mode.torque else np.full(bench.plant.axes, np.nan),
            position_mm=drive.position_mm,
            current_ma=drive.current_ma,
            shape=fresh,
            captured_s=0.0 if fresh is None else fresh.capture_time_ns / 1e9,
        )
