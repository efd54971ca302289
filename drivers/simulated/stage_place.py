"""Where the simulated stage's screw stands, over a simulator that dies: a real one keeps its place without power.

It stands in a file beside the servos' link, for a simulator that comes back within seconds. One that ends in good order
forgets it, and the next one begins with the stage at zero.
"""

import math
import time
from pathlib import Path

_KEPT_S = 30.0
_MOVED_RAD = 0.1
"""How far the screw turns before that is written down."""


class StagePlace:
    """The place of one bench's stage."""

    def __init__(self, link: str) -> None:
        """`link` is where the servos' device is found."""
        self._file = Path(f"{link}.stage")
        self._kept_rad = math.inf

    def recalled_rad(self) -> float:
        """Where it stood a moment ago, counted from the simulator's zero; 0 when nobody knows."""
        try:
            age_s = time.time() - self._file.stat().st_mtime
            place_rad = float(self._file.read_text(encoding="ascii"))
        except (OSError, ValueError):
            return 0.0
        return place_rad if age_s < _KEPT_S and math.isfinite(place_rad) else 0.0

    def keep(self, place_rad: float) -> None:
        """It stands here now; raises OSError when that cannot be written."""
        if abs(place_rad - self._kept_rad) < _MOVED_RAD:
            return
        self._kept_rad = place_rad
        fresh = self._file.with_name(f".{self._file.name}")
        fresh.write_text(f"{place_rad}", encoding="ascii")
        fresh.replace(self._file)

    def forget(self) -> None:
        """The simulator ends in good order."""
        self._file.unlink(missing_ok=True)
