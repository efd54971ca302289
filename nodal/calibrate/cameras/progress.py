"""How the taking of views goes: drawn anew on a terminal, a line for each view elsewhere."""

from collections.abc import Iterable

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from calibration.views import Size, View
from nodal.calibrate.cameras.taking import Taking
from nodal.live_display import LiveDisplay

COLUMNS, ROWS = 16, 9
SHADES = " ░▒▓█"
FULL = 20
"""So many corners in a block of the picture are as good as any more."""
MOST_WANTED = 4
LINE_S, DRAWN_S = 3.0, 0.3


class TakingProgress(LiveDisplay):
    """Shows a `Taking`; `show` is called after each look, and while there is nothing to look at."""

    def __init__(self) -> None:
        super().__init__(DRAWN_S, LINE_S)

    def show(self, taking: Taking, waiting: str = "") -> None:
        """Draw, or say what is new; `waiting` says why there is nothing to look at."""
        taken = taking.verdict is not None and taking.verdict.taken
        self.draw(
            lambda: drawn(taking, waiting),
            lambda: in_one_line(taking, waiting),
            news=not waiting and (self.is_terminal or taken),
        )


def in_one_line(taking: Taking, waiting: str = "") -> str:
    """Views so far, the last verdict or what is waited for, and what is wanted most."""
    wanted = next(iter(taking.missing), "")
    return f"{len(taking.views)} views | {waiting or _judged(taking)}" + (
        f" | next: {wanted}" if wanted else " | enough"
    )


def drawn(taking: Taking, waiting: str = "") -> Group:
    """The same with everything that is missing, and which parts of each picture were covered."""
    facts = Table.grid(padding=(0, 2))
    facts.add_row(Text("views", style="bold"), f"{len(taking.views)} taken")
    facts.add_row(Text("waiting" if waiting else "last look", style="bold"), Text(waiting or _judged(taking)))
    for number, wanted in enumerate(taking.missing[:MOST_WANTED] or ("nothing, that is enough",)):
        facts.add_row(Text("" if number else "still missing", style="bold"), Text(wanted))
    pictures = Table.grid(padding=(0, 3))
    pictures.add_row(*(Text(camera, style="bold") for camera in taking.sizes))
    pictures.add_row(
        *(
            Text("\n".join(f"│{row}│" for row in blocks(taking.views, camera, size)))
            for camera, size in taking.sizes.items()
        )
    )
    return Group(facts, pictures, Text("Ctrl-C goes on with the views that there are", style="dim"))


def blocks(views: Iterable[View], camera: str, size: Size) -> list[str]:
    """Rows of characters, the darker the more corners of the board were seen in that part of the picture."""
    px = [view.corners[camera].px for view in views if camera in view.corners]
    across, down = np.concatenate([np.zeros((0, 2)), *px]).T
    counts, _, _ = np.histogram2d(down, across, bins=(ROWS, COLUMNS), range=((0, size[1]), (0, size[0])))
    shades = np.ceil(counts.clip(0, FULL) / FULL * (len(SHADES) - 1)).astype(int)
    return ["".join(SHADES[shade] for shade in row for _ in range(2)) for row in shades]


def _judged(taking: Taking) -> str:
    verdict, view = taking.verdict, taking.view
    if verdict is None or view is None:
        return "nothing seen yet"
    return f"view {view.name} taken: {verdict.reason}" if verdict.taken else f"not taken: {verdict.reason}"
