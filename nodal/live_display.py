"""A display on stderr: drawn over and over on a terminal, a line now and then elsewhere."""

import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

from rich.console import Console, RenderableType
from rich.live import Live


class LiveDisplay:
    """What shows how something goes. It may be told often and draws rarely."""

    def __init__(self, redraw_s: float, line_s: float) -> None:
        """How often it is drawn on a terminal, and how often it says a line elsewhere."""
        self._console = Console(stderr=True)
        self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self.is_terminal = self._console.is_terminal
        self._period_s = redraw_s if self.is_terminal else line_s
        self._next_s = 0.0

    def __enter__(self) -> Self:
        """Begin to draw."""
        if self.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the terminal as it was."""
        if self.is_terminal:
            self._live.stop()

    def say(self, text: str) -> None:
        """One line that stays."""
        self._console.print(text, highlight=False, markup=False, soft_wrap=True)

    def draw(
        self, picture: Callable[[], RenderableType], line: Callable[[], str], *, news: bool = False
    ) -> None:
        """The picture on a terminal, the line elsewhere; if it is time to, or what there is to say is new."""
        now_s = time.monotonic()
        if not news and now_s < self._next_s:
            return
        self._next_s = now_s + self._period_s
        if self.is_terminal:
            self._live.update(picture(), refresh=True)
        else:
            self.say(line())
