"""Tells the log how well frames find partners: a bench whose cameras drift apart should say so before it says nothing."""

import logging

from drivers.cameras.pairing import FrameSet, FrameSetPairing, worst_skew_periods

logger = logging.getLogger(__name__)

FIRST_S = 5.0
PERIOD_S = 60.0
MS_PER_S = 1000.0


class PairingReport:
    """The skew of the first seconds' sets, and from then on that of every minute in which frames found no partner."""

    def __init__(self, pairing: FrameSetPairing, now_s: float) -> None:
        self._pairing = pairing
        self._unpaired = pairing.unpaired.copy()
        self._skews_s: list[float] = []
        self._is_first = True
        self._due_s = now_s + FIRST_S

    def add(self, frame_set: FrameSet) -> None:
        """A set that came about. Before the first one of all, cameras may have begun at different times."""
        if self._is_first and not self._skews_s:
            self._unpaired = self._pairing.unpaired.copy()
        self._skews_s.append(frame_set.skew_s)

    def tell(self, now_s: float) -> None:
        """Say what there is to say, when it is time."""
        if now_s < self._due_s:
            return
        unpaired = self._pairing.unpaired - self._unpaired
        if unpaired:
            missed = ", ".join(f"{count} of {name}" for name, count in unpaired.items())
            logger.warning("%s; frames without a partner: %s", self._sets(), missed)
        elif self._is_first and self._skews_s:
            logger.info("%s", self._sets())
        self._is_first = False
        self._unpaired = self._pairing.unpaired.copy()
        self._skews_s.clear()
        self._due_s = now_s + PERIOD_S

    def _sets(self) -> str:
        allowed = f"{MS_PER_S * self._pairing.maximum_skew_s:g} ms are allowed"
        if not self._skews_s:
            worst = worst_skew_periods(len(self._pairing.names))
            return (
                f"no frame set, for the cameras' frames lie too far apart ({allowed}): let sensing.maximum_skew_s be "
                f"{100 * worst:.0f} % of a frame's period, which is the worst that comes about, or start one camera anew"
            )
        mean_ms = MS_PER_S * sum(self._skews_s) / len(self._skews_s)
        return (
            f"{len(self._skews_s)} frame sets, their frames {mean_ms:.1f} ms apart on average, "
            f"{MS_PER_S * max(self._skews_s):.1f} ms at most ({allowed})"
        )
