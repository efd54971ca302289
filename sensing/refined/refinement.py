"""The smooth curve in space that explains every camera's silhouette at once.

Unknown are the control points of the centreline and its length. Residuals, each over its standard deviation: the offset
of the measured midline along its normal, in every camera; the silhouette's end along the tip's direction; the base's
known place and direction; constant speed, so that the parameter is arc length; and smoothness. Gauss-Newton with
Cauchy weights on what pictures say. Where the pictures say nothing (a stretch along the epipolar direction) the other
terms carry the curve, and its covariance grows.

A tube's silhouette is not symmetric about its axis' image: its contour lies nearer to the camera than the axis by
r^2/D, so edges are predicted from there and the perspective bias of the midline cancels.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Image
from sensing.refined.edges import edge_pairs, ends

EDGE_PX = 0.25
"""Standard deviation of one measured middle, systematic part included."""
END_PX = 0.5
BASE_MM = 0.02
BASE_TANGENT = 0.01
SPEED = 0.004
SMOOTH_MM = 60.0
"""Standard deviation of the change of curvature between neighbouring knots, times the length squared, in mm."""


SMOOTHNESS: FloatArray = np.asarray(np.kron(curve.JUMPS.T @ curve.JUMPS, np.eye(3)) / SMOOTH_MM**2)
LEAST_FORESHORTENING = 0.2
"""Below this sine between the tube and the sight the tube is seen end on: it has no edges and no end."""
CLEAR_FORESHORTENING = 0.5
"""Below this sine parts of the tube begin to hide one another, and edges lose weight."""
END_LINES: FloatArray = np.array([-0.75, -0.4, 0.0, 0.4, 0.75])
END_MARGIN_PX = 25.0
END_SCALE_PX = 4.0
RADIUS_WINDOW = 16
RADIUS_QUANTILE = 0.4


class Tip(StrEnum):
    """How the tube ends: in a half sphere whose apex is the centreline's end, or in a face."""

    ROUND = "round"
    FLAT = "flat"


@dataclass(frozen=True)
class View:
    """One camera's picture (luma) and its backdrop's luma: the whole, or the same part of both that begins at `corner` px."""

    camera: Camera
    picture: Image
    backdrop: Image
    corner: FloatArray


@dataclass(frozen=True)
class Curve:
    """A centreline: control points (n, 3) in mm, its length, and the tube's radius along it at `curve.PARAMETER`."""

    control_mm: FloatArray
    length_mm: float
    radius_mm: FloatArray

    @property
    def points_mm(self) -> FloatArray:
        """Centreline (SAMPLES, 3)."""
        return curve.POSITION @ self.control_mm


@dataclass(frozen=True)
class Prior:
    """What is known before looking: the base's height, and the robot's length if it is (with its spread)."""

    insertion_mm: float
    length_mm: float | None
    length_spread_mm: float = 0.1


@dataclass(frozen=True)
class Patience:
    """How long to go on: at most so many rounds, and no longer once a round moves no control point by more than this."""

    rounds: int
    enough_mm: float


@dataclass(frozen=True)
class ViewFit:
    """How one camera agrees: residual (SAMPLES,) px where `valid` with its derivative (SAMPLES, unknowns), measured
    midline (SAMPLES, 2) in px, the tube's radius (SAMPLES,) in mm or NaN, the silhouette's end (None: unseen), and the
    scale at the tip.
    """

    residual_px: FloatArray
    derivative: FloatArray
    valid: NDArray[np.bool_]
    middle_px: FloatArray
    radius_mm: FloatArray
    end: "EndFit | None"
    mm_per_px: float

    def moved(self, step: FloatArray) -> "ViewFit":
        """The same measurement seen from a curve that moved by `step` (unknowns,), to first order."""
        residual = np.where(self.valid, self.residual_px - self.derivative @ step, 0.0)
        return replace(self, residual_px=residual, end=self.end.moved(step) if self.end else None)


@dataclass(frozen=True)
class EndFit:
    """The silhouette's end: its mean residual in px, and how far its outline is from the assumed tip's, RMS in px.

    The outline counts by its even part alone: a tilted one says that the tip's direction is off, not its form.
    """

    residual_px: float
    derivative: FloatArray
    outline_px: float

    def moved(self, step: FloatArray) -> "EndFit":
        """The same end seen from a curve that moved by `step` (unknowns,), to first order."""
        return replace(self, residual_px=self.residual_px - float(self.derivative @ step))


@dataclass(frozen=True)
class Fit:
    """A fitted curve with its covariance over (control points, length) and each camera's agreement."""

    curve: Curve
    covariance: FloatArray
    views: tuple[ViewFit, ...]
    cost: float

    def covariance_mm2(self, basis: FloatArray) -> FloatArray:
        """Covariances (k, 3, 3) of the curve's points at these rows (k, CONTROL_POINTS) of the basis."""
        points = self.covariance[:-1, :-1].reshape(curve.CONTROL_POINTS, 3, curve.CONTROL_POINTS, 3)
        covariance = np.einsum("kaij,ka->kij", np.einsum("kb,aibj->kaij", basis, points), basis)
        return np.asarray((covariance + np.swapaxes(covariance, 1, 2)) / 2)

    @property
    def outline_px(self) -> float:
        """How far the ends' outlines are from the assumed tip's, over all cameras that see the end."""
        return float(np.sqrt(sum(view.end.outline_px**2 for view in self.views if view.end)))


@dataclass(frozen=True)
class Outline:
    """Where a camera sees the tube's two edges: points (n, 3) of one, the other and the middle between, robot frame.

    `foreshortening` (n,) is the sine between tube and sight: 1 from the side, 0 end on, where there are no edges.
    """

    middle: FloatArray
    one: FloatArray
    other: FloatArray
    foreshortening: FloatArray


def predicted_outline(camera: Camera, fitted: Curve) -> Outline:
    """The contour generator of the fitted tube as this camera sees it."""
    points = fitted.points_mm
    tangents = curve.VELOCITY @ fitted.control_mm
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    sight = points - camera.centre_mm
    across = sight - np.einsum("ij,ij->i", sight, tangents)[:, None] * tangents
    distance = np.maximum(np.linalg.norm(across, axis=1), 2 * fitted.radius_mm)
    towards = across / distance[:, None]
    sine = fitted.radius_mm / distance
    middle = points - (fitted.radius_mm * sine)[:, None] * towards
    side = (fitted.radius_mm * np.sqrt(1 - sine**2))[:, None] * np.cross(tangents, towards)
    foreshortening = np.linalg.norm(across, axis=1) / np.linalg.norm(sight, axis=1)
    return Outline(middle, middle + side, middle - side, foreshortening)


def refine(views: tuple[View, ...], start: Curve, prior: Prior, tip: Tip, patience: Patience) -> Fit:
    """Gauss-Newton from a starting curve; raises RefusedError when the pictures determine none."""
    fitted = start
    for _ in range(patience.rounds):
        system = _System(prior, fitted)
        measured = tuple(_measure(view, fitted, tip, system) for view in views)
        step, covariance, cost = system.solve()
        fitted = Curve(
            fitted.control_mm + step[:-1].reshape(-1, 3),
            fitted.length_mm + float(step[-1]),
            _radius(measured, fitted),
        )
        measured = tuple(view.moved(step) for view in measured)
        if np.abs(step).max() < patience.enough_mm:
            break
    return Fit(fitted, covariance, measured, cost)


class _System:
    """The normal equations of one round: unknowns are the control points' coordinates, point by point, then the length."""

    def __init__(self, prior: Prior, fitted: Curve) -> None:
        self.size = 3 * curve.CONTROL_POINTS + 1
        self.matrix = np.zeros((self.size, self.size))
        self.vector = np.zeros(self.size)
        self.cost = 0.0
        self._prior(prior, fitted)

    def add(self, rows: FloatArray, residuals: FloatArray, weights: FloatArray) -> None:
        """Add residuals (k,) = measured - predicted with rows (k, size) and inverse variances (k,)."""
        weighted = rows * weights[:, None]
        self.matrix += rows.T @ weighted
        self.vector += weighted.T @ residuals
        self.cost += float(weights @ residuals**2)

    def solve(self) -> tuple[FloatArray, FloatArray, float]:
        """The step, the covariance and the cost before the step; raises RefusedError."""
        try:
            covariance = np.asarray(np.linalg.inv(self.matrix))
        except np.linalg.LinAlgError as error:
            raise RefusedError(f"the pictures do not determine a curve ({error})") from error
        return np.asarray(covariance @ self.vector), covariance, self.cost

    def point_rows(self, basis: FloatArray, directions: FloatArray) -> FloatArray:
        """Rows for directions (k, 3) at basis rows (k, n): the derivative of direction . position."""
        rows = np.zeros((len(basis), self.size))
        rows[:, :-1] = (basis[:, :, None] * directions[:, None, :]).reshape(len(basis), -1)
        return rows

    def _prior(self, prior: Prior, fitted: Curve) -> None:
        identity = np.eye(3)
        base = self.point_rows(np.repeat(curve.POSITION[:1], 3, axis=0), identity)
        self.add(base, np.array([0, 0, prior.insertion_mm]) - fitted.points_mm[0], np.full(3, BASE_MM**-2))
        velocity = curve.VELOCITY @ fitted.control_mm
        tangent_rows = self.point_rows(np.repeat(curve.VELOCITY[:1], 2, axis=0), identity[:2])
        self.add(tangent_rows, -velocity[0, :2], np.full(2, (BASE_TANGENT * fitted.length_mm) ** -2))
        speed = np.linalg.norm(velocity, axis=1)
        speed_rows = self.point_rows(curve.VELOCITY, velocity / speed[:, None]) / fitted.length_mm
        speed_rows[:, -1] = -speed / fitted.length_mm**2
        self.add(speed_rows, 1 - speed / fitted.length_mm, np.full(len(speed), SPEED**-2))
        self.matrix[:-1, :-1] += SMOOTHNESS
        flat = fitted.control_mm.ravel()
        self.vector[:-1] -= SMOOTHNESS @ flat
        self.cost += float(flat @ SMOOTHNESS @ flat)
        if prior.length_mm is not None:
            row = np.zeros((1, self.size))
            row[0, -1] = 1.0
            self.add(
                row, np.array([prior.length_mm - fitted.length_mm]), np.array([prior.length_spread_mm**-2])
            )


def _measure(view: View, fitted: Curve, tip: Tip, system: _System) -> ViewFit:
    outline = predicted_outline(view.camera, fitted)
    pixels, jacobian = view.camera.project_with_jacobian(
        np.vstack([outline.middle, outline.one, outline.other])
    )
    count = curve.SAMPLES
    first, second = pixels[count : 2 * count], pixels[2 * count :]
    across = first - second
    width = np.linalg.norm(across, axis=1)
    normals = across / np.maximum(width, 1e-9)[:, None]
    pairs = edge_pairs(view.picture, view.backdrop, (first + second) / 2 - view.corner, normals, width / 2)
    ratio = pairs.half_width_px / (width / 2)
    valid = pairs.valid & (ratio > 0.7) & (ratio < 1.45) & (outline.foreshortening > LEAST_FORESHORTENING)
    rows = system.point_rows(curve.POSITION, np.einsum("ij,ijk->ik", normals, jacobian[:count]))
    residual = np.where(valid, pairs.middle_px, 0.0)
    scale = max(2.0 * float(np.median(np.abs(residual[valid]))) if valid.any() else 1.0, 2 * EDGE_PX)
    clearness = np.minimum(outline.foreshortening / CLEAR_FORESHORTENING, 1.0) ** 2
    weights = np.where(valid, clearness * EDGE_PX**-2 / (1 + (residual / scale) ** 2), 0.0)
    system.add(rows, residual, weights)
    end = _measure_end(view, fitted, tip, system)
    return ViewFit(
        residual_px=residual,
        derivative=rows,
        valid=valid,
        middle_px=(first + second) / 2 + residual[:, None] * normals,
        radius_mm=np.where(valid, ratio * fitted.radius_mm, np.nan),
        end=end,
        mm_per_px=2 * float(fitted.radius_mm[-1]) / max(float(width[-1]), 1e-9),
    )


def _measure_end(view: View, fitted: Curve, tip: Tip, system: _System) -> EndFit | None:
    """The silhouette's end beyond the tip along a few parallel lines; None when unseen.

    Across the tip's direction in the picture, at x from the middle, a round tip's outline is the sphere's, at
    sqrt(r^2 - x^2) beyond its centre; a flat tip's is the face's, an ellipse as deep as the face is turned towards
    the camera.
    """
    last = fitted.points_mm[-1]
    tangent = curve.VELOCITY[-1] @ fitted.control_mm
    tangent = tangent / np.linalg.norm(tangent)
    radius = float(fitted.radius_mm[-1])
    sight = last - view.camera.centre_mm
    sight = sight / np.linalg.norm(sight)
    onwards = tangent - (tangent @ sight) * sight
    foreshortening = float(np.linalg.norm(onwards))
    if foreshortening < LEAST_FORESHORTENING:
        return None
    onwards = onwards / foreshortening
    across = radius * END_LINES[:, None] * np.cross(sight, onwards)
    depth = radius * np.sqrt(1 - END_LINES**2)[:, None]
    if tip is Tip.ROUND:
        outline = last - radius * tangent + across + depth * onwards
    else:
        outline = last + across + depth * abs(float(tangent @ sight)) * onwards
    inner = last - 1.2 * radius * tangent + across
    pixels, jacobian = view.camera.project_with_jacobian(np.vstack([outline, inner]))
    predicted, starts = pixels[: len(END_LINES)], pixels[len(END_LINES) :]
    directions = predicted - starts
    reach = np.linalg.norm(directions, axis=1)
    if reach.min() < 2:
        return None
    directions = directions / reach[:, None]
    seen, found = ends(view.picture, view.backdrop, starts - view.corner, directions, reach + END_MARGIN_PX)
    if not found.all():
        return None
    residual = seen - reach
    rows = system.point_rows(
        np.repeat(curve.POSITION[-1:], len(END_LINES), axis=0),
        np.einsum("ij,ijk->ik", directions, jacobian[: len(END_LINES)]),
    )
    weights = (END_PX**2 * len(END_LINES)) ** -1 / (1 + (residual / END_SCALE_PX) ** 2)
    system.add(rows, residual, weights)
    even = (residual + residual[::-1]) / 2
    return EndFit(float(residual.mean()), rows.mean(axis=0), float(even.std()))


def _radius(measured: tuple[ViewFit, ...], fitted: Curve) -> FloatArray:
    """The tube's radius (SAMPLES,) in mm along the curve: a low running quantile of what all cameras measured.

    The window is wider than the pitch of spacer disks, and the quantile low, so that disks do not count.
    """
    margin = RADIUS_WINDOW // 2
    radii = np.array([view.radius_mm for view in measured])
    padded = np.pad(radii, ((0, 0), (margin, margin)), constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, RADIUS_WINDOW + 1, axis=1)
    pooled = np.sort(np.moveaxis(windows, 1, 0).reshape(fitted.radius_mm.size, -1), axis=1)
    known = np.count_nonzero(~np.isnan(pooled), axis=1)
    rank = (RADIUS_QUANTILE * np.maximum(known - 1, 0)).astype(int)
    return np.where(known > 0, pooled[np.arange(len(pooled)), rank], fitted.radius_mm)
