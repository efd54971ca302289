"""How the identification of a robot goes: a line with the time that is left, drawn anew on a terminal."""

import time

from rich.text import Text

from nodal.live_display import LiveDisplay

REDRAW_S = 0.5
LINE_S = 5.0


class Progress(LiveDisplay):
    """Says what is done; elsewhere than on a terminal as a line now and then."""

    def __init__(self) -> None:
        super().__init__(REDRAW_S, LINE_S)
        self._words = ""
        self._end_s: float | None = None

    def takes(self, seconds: float) -> None:
        """From now on, about."""
        self._end_s = time.monotonic() + seconds

    def tell(self, words: str) -> None:
        """What is done from now on."""
        self._words = words
        self.show()

    def show(self) -> None:
        """Draw if it is time to."""
        self.draw(lambda: Text(self._line()), self._line)

    def _line(self) -> str:
        if self._end_s is None:
            return self._words
        return f"{self._words} | about {max(self._end_s - time.monotonic(), 0.0):.0f} s left"
