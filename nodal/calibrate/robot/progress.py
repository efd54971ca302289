"""How the identification of a robot goes: a line with the time that is left, drawn anew on a terminal."""

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.live import Live
from rich.text import Text

REDRAW_S = 0.5
LINE_S = 5.0


class Progress:
    """Says what is done; elsewhere than on a terminal as a line now and then."""

    def __init__(self) -> None:
        self._console = Console(stderr=True)
        self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._words = ""
        self._end_s: float | None = None
        self._next_s = 0.0

    def __enter__(self) -> Self:
        """Begin to draw."""
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the terminal as it was."""
        if self._console.is_terminal:
            self._live.stop()

    def takes(self, seconds: float) -> None:
        """From now on, about."""
        self._end_s = time.monotonic() + seconds

    def tell(self, words: str) -> None:
        """What is done from now on."""
        self._words = words
        self.show()

    def say(self, text: str) -> None:
        """One line that stays."""
        self._console.print(text, highlight=False, markup=False, soft_wrap=True)

    def show(self) -> None:
        """Draw if it is time to."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s = now_s + (REDRAW_S if self._console.is_terminal else LINE_S)
        words = self._words
        if self._end_s is not None:
            words += f" | about {max(self._end_s - now_s, 0.0):.0f} s left"
        if self._console.is_terminal:
            self._live.update(Text(words), refresh=True)
        else:
            self.say(words)
