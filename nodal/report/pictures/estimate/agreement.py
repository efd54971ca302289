"""How one camera's midline agrees with the shape along its length. Pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensing.geometry.camera import Camera
from sensing.refined.fitted_line import FittedLine
from sensing.shape import Shape, Silhouette

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Agreement:
    """Offsets (n,) of the measured midline from the reprojected shape at distances (n,) from the base; NaN where unseen.

    `measured_px` (n, 2) is that midline, NaN where unseen too.
    """

    arc_mm: Array
    offset_px: Array
    measured_px: Array

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(n,) where the camera saw the robot's two edges."""
        return np.isfinite(self.offset_px)

    @property
    def unseen(self) -> NDArray[np.bool_]:
        """(n,) where it did not, with the last places at which it did, so that a line through them joins the others."""
        hidden = ~self.seen
        return np.asarray(hidden | np.append(hidden[1:], False) | np.append(False, hidden[:-1]))

    def stretches_mm(self) -> list[tuple[float, float]]:
        """Begin and length of each stretch that was seen, as far as half way to the next place that was not."""
        edges = np.concatenate(
            [[self.arc_mm[0]], (self.arc_mm[1:] + self.arc_mm[:-1]) / 2, [self.arc_mm[-1]]]
        )
        steps = np.diff(self.seen.astype(int), prepend=0, append=0)
        begins, ends = edges[np.flatnonzero(steps == 1)], edges[np.flatnonzero(steps == -1)]
        return list(zip(begins.tolist(), (ends - begins).tolist(), strict=True))


def agreements(shape: Shape, cameras: tuple[Camera, ...]) -> dict[str, Agreement]:
    """By camera, of those that carry the shape; none where neither normals nor silhouettes were kept."""
    known = {camera.name: camera for camera in cameras}
    names = tuple(shape.evidence.residual_px)
    if isinstance(shape.centreline, FittedLine):
        normals = shape.centreline.fit.normals
        return {
            name: Agreement(
                shape.centreline.arc_mm,
                np.where(valid, residual_px, np.nan),
                np.where(valid[:, None], middle_px, np.nan),
            )
            for name, valid, residual_px, middle_px in zip(
                names, normals.valid, normals.residual_px, normals.middle_px, strict=True
            )
        }
    silhouettes = shape.stages.silhouettes if shape.stages else {}
    return {name: of_skeleton(known[name], shape, silhouettes[name]) for name in names if name in silhouettes}


def of_skeleton(camera: Camera, shape: Shape, silhouette: Silhouette, places: int = 81) -> Agreement:
    """How a silhouette's skeleton agrees: at each of so many places the skeleton pixel nearest to the normal there.

    Seen is a place whose normal passes within a place's distance of a skeleton pixel, no further than the tube is wide.
    """
    arc_mm = np.linspace(0.0, shape.length_mm, places)
    line = camera.project(shape.centreline.at(arc_mm)[0])
    along = np.gradient(line, axis=0)
    step = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    along = along / step[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    away = silhouette.skeleton - line[:, None]
    beside = np.abs(np.einsum("nmi,ni->nm", away, along))
    nearest = (beside + np.linalg.norm(away, axis=2)).argmin(axis=1)
    rows = np.arange(places)
    offset = np.einsum("ni,ni->n", away[rows, nearest], across)
    seen = (beside[rows, nearest] <= np.maximum(step, 1.0)) & (np.abs(offset) <= 2 * silhouette.half_width_px)
    return Agreement(
        arc_mm,
        np.where(seen, offset, np.nan),
        np.where(seen[:, None], silhouette.skeleton[nearest], np.nan),
    )
