"""Where servos were last seen, so that one that restarted is found again. Pure.

A servo that restarts forgets how many turns it has made, and keeps its angle within one. Which turn it is in is known
still, as long as it was not turned by half of one meanwhile.
"""

from collections.abc import Iterable, Mapping

from drivers.dynamixel.axis import Axis


class Whereabouts:
    """Of all servos of a drive, over closing and opening."""

    def __init__(self) -> None:
        """Nobody was seen yet."""
        self._ticks: dict[int, int] = {}
        self._zero_ticks: dict[int, float] = {}
        self._restarted: set[int] = set()

    def saw(self, ticks: Mapping[int, int]) -> None:
        """The present positions of servos."""
        self._ticks.update(ticks)

    def restarted(self, servos: Iterable[int]) -> set[int]:
        """These have restarted; those of which that was not known."""
        unknown = set(servos) - self._restarted
        self._restarted |= unknown
        return unknown

    def found(self, axis: Axis, ticks: int) -> Axis:
        """The axis with 0 mm where its settings say, or where it stands when they do not; raises WrongSetupError."""
        servo, zero_ticks = axis.settings.id, axis.settings.zero_ticks
        restarted, before = servo in self._restarted, self._ticks.get(servo)
        self._restarted.discard(servo)
        self._ticks[servo] = ticks
        if zero_ticks is None:
            return axis.zeroed(ticks, 0.0)
        found = axis.zeroed(self._zero_ticks.get(servo, zero_ticks), 0.0)
        if restarted and before is not None:
            found = found.after_reboot(before, ticks)
        self._zero_ticks[servo] = found.zero_ticks
        return found
