"""What sensing is given with one frame set."""

from collections.abc import Mapping
from dataclasses import dataclass

from messaging.shape import NodalPoints


@dataclass(frozen=True, kw_only=True, eq=False)
class SetInputs:
    """What one step sees: coded pictures by camera, where the stage was and whether that is known, and what is asked."""

    jpegs: Mapping[str, bytes]
    sequence: int
    capture_time_ns: int
    insertion_mm: float
    base_known: bool
    points: NodalPoints
