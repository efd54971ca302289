"""One look for all pictures, and the way they are saved."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from messaging.errors import NodalError

INK, FAINT, MEASURED, DESIRED, NODE, WITHOUT_FEEDBACK = (
    "#22272b",
    "#c9ced3",
    "#1769aa",
    "#6b7780",
    "#c8324a",
    "#d98a1f",
)
PALETTE = (MEASURED, NODE, WITHOUT_FEEDBACK, "#2a8c5a", "#7d57b8", "#5b6770")
"""For series that stand side by side."""
STATES = {
    "idle": "#fefefe",
    "homing": "#e9ecef",
    "ready": "#e9ecf0",
    "tracking": "#d6e6f4",
    "hold": "#f6c88a",
    "fault": "#f0a3ad",
}
"""Backgrounds by the controller's state."""
GRID = "#e7eaec"
PAGE_COLOURS = {
    "ink": INK,
    "faint": FAINT,
    "quiet": DESIRED,
    "grid": GRID,
    **{f"series-{number}": colour for number, colour in enumerate(PALETTE)},
    **{f"state-{state}": colour for state, colour in STATES.items()},
}
"""Names under which a page may choose other colours, for dark surroundings say."""
RESOLUTION_DPI = 110

RULES: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": DESIRED,
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "figure.constrained_layout.use": True,
    "svg.fonttype": "none",
}


@contextmanager
def drawing(width_in: float, height_in: float, salt: str = "") -> Iterator[Any]:
    """A figure that is drawn without a display; names inside an SVG come from the salt. NodalError without matplotlib."""
    try:
        import matplotlib as mpl  # noqa: PLC0415  slow, and part of an extra
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError as error:
        raise NodalError("pictures need matplotlib; install nodal with its extra `plots`") from error
    with mpl.rc_context({**RULES, "svg.hashsalt": salt}):
        figure = Figure(figsize=(width_in, height_in))
        FigureCanvasAgg(figure)
        yield figure


@contextmanager
def picture(path: Path, width_in: float, height_in: float) -> Iterator[Any]:
    """A drawing that is saved when the block ends."""
    with drawing(width_in, height_in) as figure:
        yield figure
        figure.savefig(path, dpi=RESOLUTION_DPI)


def robot_axes(figure: Any, position: Any, points_mm: Any) -> Any:
    """Three-dimensional axes in mm with equal scales around these points (N, 3)."""
    axes = figure.add_subplot(position, projection="3d")
    low, high = points_mm.min(axis=0), points_mm.max(axis=0)
    middle, reach = (low + high) / 2, max(float((high - low).max()) * 0.6, 1.0)
    axes.set(
        xlim=(middle[0] - reach, middle[0] + reach),
        ylim=(middle[1] - reach, middle[1] + reach),
        zlim=(middle[2] - reach, middle[2] + reach),
        xlabel="x, mm",
        ylabel="y, mm",
        zlabel="z, mm",
        box_aspect=(1, 1, 1),
    )
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.get_major_locator().set_params(nbins=5)
    axes.view_init(elev=18, azim=-62)
    return axes
