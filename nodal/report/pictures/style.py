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
    "grid.color": "#e7eaec",
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "figure.constrained_layout.use": True,
}


@contextmanager
def picture(path: Path, width_in: float, height_in: float) -> Iterator[Any]:
    """A figure that is drawn without a display and saved when the block ends; raises NodalError without matplotlib."""
    try:
        import matplotlib as mpl  # noqa: PLC0415  slow, and part of an extra
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError as error:
        raise NodalError(
            f"{path.name}: pictures need matplotlib; install nodal with its extra `plots`"
        ) from error
    with mpl.rc_context(RULES):
        figure = Figure(figsize=(width_in, height_in))
        FigureCanvasAgg(figure)
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
