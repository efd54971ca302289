"""What the cameras say about a tube: how far its edges and its end are from where they were predicted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.geometry.vectors import lengths
from sensing.pictures.light import Image
from sensing.refined.edges import Walk, contrast, edge_pairs, ends
from sensing.refined.tube import END_LINES, Curve, End, Sides, Tip, end, sides

LEAST_FORESHORTENING = 0.3
"""Below this sine between the tube and the sight the tube is seen nearly end on: what looks like its edges is not."""
CLEAR_FORESHORTENING = 0.7
"""Below this sine parts of the tube begin to hide one another, and edges lose weight."""
WIDTHS = 0.7, 1.45
"""A tube may be this much thinner or, with its disks, thicker than predicted."""
MARGIN_MM = 1.8
"""How far beyond the predicted edges normals reach."""
LEAST_END_FORESHORTENING = 0.2
"""Below this sine the tube hides its own end, or shows nothing else."""
END_MARGIN_MM = 3.2
LEAST_END_MARGIN_PX = 10.0
LEAST_REACH_PX = 2.0
"""An end that is predicted nearer than this to where the search begins is not looked for."""


@dataclass(frozen=True)
class View:
    """One camera's picture (luma) and its backdrop's luma: the whole, or the same part of both that begins at `corner` px."""

    camera: Camera
    picture: Image
    backdrop: Image
    corner: FloatArray

    def shows(self, pixels: FloatArray) -> NDArray[np.bool_]:
        """Which of pixels (n, 2) lie in the camera's picture."""
        (x, y), (width, height) = pixels.T, self.camera.size_px
        return np.asarray(((x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)).T, dtype=np.bool_)


@dataclass(frozen=True)
class Normals:
    """Across the tube, n normals in each of v cameras.

    `residual_px` (v, n) is the offset of the measured middle along `across` (v, n, 2), 0 where it is not `valid` (v, n);
    `direction` (v, n, 3) is its derivative by the curve's point in px/mm. `clearness` (v, n) says how clearly the tube is
    seen, `shown` (v, n) whether it lies in the picture, `middle_px` (v, n, 2) is the measured midline and `radius_mm`
    (v, n) the tube's, or NaN.
    """

    residual_px: FloatArray
    across: FloatArray
    direction: FloatArray
    valid: NDArray[np.bool_]
    clearness: FloatArray
    shown: NDArray[np.bool_]
    middle_px: FloatArray
    radius_mm: FloatArray


@dataclass(frozen=True)
class Ends:
    """The silhouette's end along k parallel lines in each of v cameras.

    `residual_px` (v, k) is how far beyond the predicted outline it is along `onwards` (v, k, 2), 0 in cameras that do not
    see it (`seen` (v,)); `direction` (v, k, 3) its derivative in px/mm by the point that `basis` (CONTROL_POINTS,) gives;
    `mm_per_px` (v,) the scale there.
    """

    residual_px: FloatArray
    onwards: FloatArray
    direction: FloatArray
    seen: NDArray[np.bool_]
    basis: FloatArray
    mm_per_px: FloatArray

    @property
    def outline_px(self) -> float:
        """How far the ends' outlines are from the assumed tip's form, over all cameras that see them.

        It counts by its even part alone: a tilted one says that the tip's direction is off, not its form.
        """
        even = (self.residual_px + self.residual_px[:, ::-1]) / 2
        return float(np.sqrt(even.var(axis=1).sum()))


@dataclass(frozen=True)
class Measurement:
    """All that the cameras say in one round."""

    normals: Normals
    ends: Ends


@dataclass(frozen=True)
class _Projected:
    """A view's pixels: of both edges, the search's start inside the end, and the derivatives of the middle and the end."""

    one: FloatArray
    other: FloatArray
    inside: FloatArray
    outline: FloatArray
    by_middle: FloatArray
    by_end: FloatArray


def measure(views: tuple[View, ...], fitted: Curve, tip: Tip) -> Measurement:
    """Look along normals and beyond the tip of a tube that is nearly where it was."""
    centres = np.array([view.camera.centre_mm for view in views])
    beside, beyond = sides(centres, fitted), end(centres, fitted, tip)
    pixels = [_projected(view.camera, beside, beyond, index) for index, view in enumerate(views)]
    return Measurement(
        _measure_normals(views, fitted, tip, beside, pixels), _measure_ends(views, beyond, pixels)
    )


def _projected(camera: Camera, beside: Sides, beyond: End, index: int) -> _Projected:
    count, lines = curve.SAMPLES, len(END_LINES)
    exact, jacobian = camera.project_with_jacobian(
        np.concatenate([beside.middle[index], beyond.outline[index]])
    )
    places = np.concatenate([beside.one[index], beside.other[index], beyond.inside[index]])
    pixels = camera.project(places)
    return _Projected(
        one=pixels[:count],
        other=pixels[count : 2 * count],
        inside=pixels[-lines:],
        outline=exact[count:],
        by_middle=jacobian[:count],
        by_end=jacobian[count:],
    )


def _measure_normals(
    views: tuple[View, ...], fitted: Curve, tip: Tip, beside: Sides, pixels: list[_Projected]
) -> Normals:
    one, other = (np.array([getattr(view, side) for view in pixels]) for side in ("one", "other"))
    middle, across = (one + other) / 2, one - other
    width = lengths(across)
    normals = across / np.maximum(width, 1e-9)
    half = width[..., 0] / 2
    px_per_mm = half / fitted.radius_mm
    walk = Walk.across(half.ravel(), (MARGIN_MM * px_per_mm).ravel())
    profile = _profiles(views, middle, normals, walk)
    pairs = edge_pairs(profile, walk, half.ravel())
    ratio = pairs.half_width_px.reshape(half.shape) / half
    shown = np.array([view.shows(a) & view.shows(b) for view, a, b in zip(views, one, other, strict=True)])
    valid = (
        pairs.valid.reshape(half.shape)
        & shown
        & (ratio > WIDTHS[0])
        & (ratio < WIDTHS[1])
        & (beside.foreshortening > LEAST_FORESHORTENING)
    )
    if tip is Tip.ROUND:
        # the half sphere has no sides
        valid &= curve.PARAMETER * fitted.length_mm < fitted.length_mm - fitted.radius_mm[-1]
    residual = np.where(valid, pairs.middle_px.reshape(half.shape), 0.0)
    by_middle = np.array([view.by_middle for view in pixels])
    return Normals(
        residual_px=residual,
        across=normals,
        direction=np.einsum("vni,vnij->vnj", normals, by_middle),
        valid=valid,
        clearness=np.minimum(beside.foreshortening / CLEAR_FORESHORTENING, 1.0) ** 2,
        shown=shown,
        middle_px=middle + residual[..., None] * normals,
        radius_mm=np.where(valid, ratio * fitted.radius_mm, np.nan),
    )


def _measure_ends(views: tuple[View, ...], beyond: End, pixels: list[_Projected]) -> Ends:
    starts = np.array([view.inside for view in pixels])
    directions = np.array([view.outline for view in pixels]) - starts
    reach = lengths(directions)[..., 0]
    directions = directions / np.maximum(reach, 1e-9)[..., None]
    by_end = np.array([view.by_end for view in pixels])
    px_per_mm = np.sqrt(np.sum(by_end[:, len(END_LINES) // 2] ** 2, axis=(1, 2)) / 2)
    margin = np.maximum(END_MARGIN_MM * px_per_mm, LEAST_END_MARGIN_PX)
    walk = Walk.onwards((reach + margin[:, None]).ravel())
    profile = _profiles(views, starts, directions, walk)
    distance, found = ends(profile, walk)
    seen = (
        found.reshape(reach.shape).all(axis=1)
        & (beyond.foreshortening >= LEAST_END_FORESHORTENING)
        & (reach.min(axis=1) >= LEAST_REACH_PX)
    )
    residual = np.where(seen[:, None], distance.reshape(reach.shape) - reach, 0.0)
    return Ends(
        residual_px=residual,
        onwards=directions,
        direction=np.einsum("vki,vkij->vkj", directions, by_end),
        seen=seen,
        basis=beyond.basis,
        mm_per_px=1.0 / px_per_mm,
    )


def _profiles(
    views: tuple[View, ...], starts: FloatArray, directions: FloatArray, walk: Walk
) -> NDArray[np.float32]:
    """Contrast (v n, m) along walks from starts (v, n, 2) in px of the whole picture, in unit directions (v, n, 2)."""
    count = starts.shape[1]
    return np.concatenate(
        [
            contrast(
                view.picture, view.backdrop, start - view.corner, direction, walk.part(slice(at, at + count))
            )
            for at, view, start, direction in zip(
                range(0, count * len(views), count), views, starts, directions, strict=True
            )
        ]
    )
