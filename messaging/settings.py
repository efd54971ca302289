"""Settings of the ground floor, as they stand in the bench file."""

from typing import Annotated

import msgspec


class ZenohSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where the processes of one bench meet.

    `rendezvous` is the endpoint of the router through which they find one another; after that they talk directly.
    `listen` is where each process waits for the others; port 0 picks a free one. Both stay on loopback unless changed.
    """

    rendezvous: Annotated[str, msgspec.Meta(pattern=r"^(tcp|tls)/.+:\d+$")] = "tcp/127.0.0.1:7447"
    listen: Annotated[str, msgspec.Meta(pattern=r"^(tcp|tls)/.+:\d+$")] = "tcp/127.0.0.1:0"


Length = Annotated[float, msgspec.Meta(gt=0, le=2000)]


class RobotSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The robot on the bench, in the words that sensing and the controller share. Lengths in mm.

    Sections stand in order from the base; the last one ends at the tip.
    """

    section_length_mm: Annotated[tuple[Length, ...], msgspec.Meta(min_length=1, max_length=8)]
    stage: bool = True
    """Whether the robot stands on a linear stage that moves it along its axis."""

    @property
    def length_mm(self) -> float:
        """From the base to the tip along the centreline."""
        return sum(self.section_length_mm)
