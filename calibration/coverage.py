"""What the views so far have shown of the cameras, and what to show next: for a person who moves the board."""

from collections.abc import Mapping
from dataclasses import dataclass

from calibration.board import Board
from calibration.views import Size, View


@dataclass(frozen=True)
class Verdict:
    """Whether a view was taken, and why or why not, in words."""

    taken: bool
    reason: str


class Coverage:
    """Judges one view after another; `sizes` are (width, height) in px by camera."""

    def __init__(self, board: Board, sizes: Mapping[str, Size]) -> None:
        self.views: list[View] = []
        """Those that were taken."""
        self._board, self._sizes = board, sizes

    def offer(self, view: View) -> Verdict:
        """Take a view that shows something new and is sharp enough; refuse any other."""
        raise NotImplementedError

    def missing(self) -> tuple[str, ...]:
        """What to show next, most wanted first, in words that a person can follow; empty when it is enough."""
        raise NotImplementedError

    @property
    def enough(self) -> bool:
        """Whether nothing is missing."""
        return not self.missing()
