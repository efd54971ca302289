"""Where the names of points on a line stand, so that they cover neither the line nor one another. Pure."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def label_places(line: Array, points: Array, away: Array, low: Array, high: Array) -> Array:
    """Places (n, 2) for names of points (n, 2) on a line (m, 2), each beside its point at a distance from `away` (n,).

    A name stands on that side of the line where more room is left by the line, by the names before it, and by the
    frame with the corners `low` (2,) and `high` (2,).
    """
    along = np.gradient(line, axis=0)
    places: list[Array] = []
    for point, distance in zip(points, away, strict=True):
        tangent = along[np.linalg.norm(line - point, axis=1).argmin()]
        tangent = tangent / max(float(np.linalg.norm(tangent)), 1e-12)
        normal = np.array([-tangent[1], tangent[0]])
        sides = [point + side * distance * normal for side in (1.0, -1.0)]
        places.append(max(sides, key=lambda place: _room(place, line, places, low, high)))
    return np.array(places).reshape(-1, 2)


def alignment(rightwards: float, upwards: float) -> dict[str, str]:
    """How a name is to stand at its place so that it lies on the far side of it, for matplotlib."""
    steep = abs(upwards) > 2 * abs(rightwards)
    level = abs(rightwards) > 2 * abs(upwards)
    return {
        "ha": "center" if steep else "left" if rightwards > 0 else "right",
        "va": "center" if level else "bottom" if upwards > 0 else "top",
    }


def _room(place: Array, line: Array, taken: list[Array], low: Array, high: Array) -> float:
    """The distance to whatever is nearest; negative outside of the frame."""
    to_line = float(np.linalg.norm(line - place, axis=1).min())
    to_names = min((float(np.linalg.norm(other - place)) for other in taken), default=to_line)
    to_frame = float(np.min([place - low, high - place]))
    return min(to_line, to_names, to_frame)
