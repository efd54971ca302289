"""What the refined method carries from one frame set to the next."""

from collections.abc import Mapping
from dataclasses import dataclass

from sensing.pictures.backdrop import Backdrop
from sensing.refined.tube import Curve, Tip


@dataclass(frozen=True)
class Track:
    """Where the robot was seen last, and against which backdrops."""

    curve: Curve
    tip: Tip
    insertion_mm: float
    backdrops: Mapping[str, Backdrop]
