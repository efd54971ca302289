"""The smooth curve in space that explains every camera's silhouette at once.

Unknown are the control points of the centreline and its length. Residuals, each over its standard deviation: the offset
of the measured midline along its normal, in every camera; the silhouette's end along the tip's direction; the base's
known place and direction; constant speed, so that the parameter is arc length; and smoothness. Gauss-Newton with
Cauchy weights on what pictures say. Where the pictures say nothing (a stretch along the epipolar direction) the other
terms carry the curve, and its covariance grows.
"""

from dataclasses import dataclass, replace

import numpy as np

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.refined.measuring import Ends, Measurement, Normals, View, measure
from sensing.refined.tube import Curve, Tip

EDGE_PX = 0.25
"""Standard deviation of one measured middle, systematic part included."""
END_PX = 0.5
OUTLINE_PX = 0.2
BASE_MM = 0.02
BASE_TANGENT = 0.01
SPEED = 0.004
SMOOTH_MM = 60.0
"""Standard deviation of the change of curvature between neighbouring knots, times the length squared, in mm."""
SMOOTHNESS: FloatArray = np.asarray(np.kron(curve.JUMPS.T @ curve.JUMPS, np.eye(3)) / SMOOTH_MM**2)
END_SCALE_PX = 4.0
RADIUS_WINDOW = 16
RADIUS_QUANTILE = 0.4

UNKNOWNS = 3 * curve.CONTROL_POINTS + 1
"""The control points' coordinates, point by point, then the length."""


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
class Fit:
    """A fitted curve with its covariance over (control points, length), and how the cameras agree with it."""

    curve: Curve
    covariance: FloatArray
    normals: Normals
    ends: Ends
    cost: float

    @property
    def misfit(self) -> float:
        """How badly the assumed tip explains the pictures: the cost, and the form of the end's outline once more.

        An outline is either round or flat, whatever disturbs the rest of the silhouette.
        """
        return self.cost + (self.ends.outline_px / OUTLINE_PX) ** 2

    def covariance_mm2(self, basis: FloatArray) -> FloatArray:
        """Covariances (k, 3, 3) of the curve's points at these rows (k, CONTROL_POINTS) of the basis."""
        points = self.covariance[:-1, :-1].reshape(curve.CONTROL_POINTS, 3, curve.CONTROL_POINTS, 3)
        covariance = np.einsum("kaij,ka->kij", np.einsum("kb,aibj->kaij", basis, points), basis)
        return np.asarray((covariance + np.swapaxes(covariance, 1, 2)) / 2)


def refine(views: tuple[View, ...], start: Curve, prior: Prior, tip: Tip, patience: Patience) -> Fit:
    """Gauss-Newton from a starting curve; raises RefusedError when the pictures determine none."""
    fitted = start
    for _ in range(patience.rounds):
        system = _System()
        _expect(system, prior, fitted)
        seen = measure(views, fitted, tip)
        _listen(system, seen)
        step, covariance = system.solve()
        fitted = Curve(
            fitted.control_mm + step[:-1].reshape(-1, 3),
            fitted.length_mm + float(step[-1]),
            _radius(seen.normals, fitted),
        )
        if np.abs(step).max() < patience.enough_mm:
            break
    moved = step[:-1].reshape(-1, 3)
    return Fit(
        fitted, covariance, _moved_normals(seen.normals, moved), _moved_ends(seen.ends, moved), system.cost
    )


class _System:
    """The normal equations of one round."""

    def __init__(self) -> None:
        self._matrix = np.zeros((UNKNOWNS, UNKNOWNS))
        self._vector = np.zeros(UNKNOWNS)
        self.cost = 0.0

    def add(self, rows: FloatArray, residuals: FloatArray, weights: FloatArray) -> None:
        """Add residuals (k,) = measured - predicted with rows (k, m) over the first m unknowns and inverse variances (k,)."""
        width = rows.shape[1]
        weighted = rows * weights[:, None]
        self._matrix[:width, :width] += rows.T @ weighted
        self._vector[:width] += residuals @ weighted
        self.cost += float(weights @ residuals**2)

    def add_quadratic(self, matrix: FloatArray, at: FloatArray) -> None:
        """Add x^T matrix x over the first m unknowns, which are now `at` (m,)."""
        width = len(matrix)
        self._matrix[:width, :width] += matrix
        self._vector[:width] -= matrix @ at
        self.cost += float(at @ matrix @ at)

    def solve(self) -> tuple[FloatArray, FloatArray]:
        """The step (UNKNOWNS,) and the covariance; raises RefusedError."""
        try:
            covariance = np.asarray(np.linalg.inv(self._matrix))
        except np.linalg.LinAlgError as error:
            raise RefusedError(f"the pictures do not determine a curve ({error})") from error
        return np.asarray(covariance @ self._vector), covariance


def _point_rows(basis: FloatArray, directions: FloatArray) -> FloatArray:
    """Rows (k, 3 CONTROL_POINTS): the derivatives of direction . position, for directions (k, 3) at basis rows (k, n)."""
    return (basis[:, :, None] * directions[:, None, :]).reshape(len(basis), -1)


_AXES = np.eye(3)
_BASE_ROWS = _point_rows(np.repeat(curve.POSITION[:1], 3, axis=0), _AXES)
_BASE_TANGENT_ROWS = _point_rows(np.repeat(curve.VELOCITY[:1], 2, axis=0), _AXES[:2])


def _expect(system: _System, prior: Prior, fitted: Curve) -> None:
    """What is known without looking."""
    base = np.array([0.0, 0.0, prior.insertion_mm])
    system.add(_BASE_ROWS, base - fitted.points_mm[0], np.full(3, BASE_MM**-2))
    velocity = fitted.velocity_mm
    system.add(_BASE_TANGENT_ROWS, -velocity[0, :2], np.full(2, (BASE_TANGENT * fitted.length_mm) ** -2))
    speed = np.sqrt(np.einsum("ij,ij->i", velocity, velocity))
    along = _point_rows(curve.VELOCITY, velocity / speed[:, None]) / fitted.length_mm
    rows = np.column_stack([along, -speed / fitted.length_mm**2])
    system.add(rows, 1 - speed / fitted.length_mm, np.full(len(speed), SPEED**-2))
    system.add_quadratic(SMOOTHNESS, fitted.control_mm.ravel())
    if prior.length_mm is not None:
        row = np.zeros((1, UNKNOWNS))
        row[0, -1] = 1.0
        off = np.array([prior.length_mm - fitted.length_mm])
        system.add(row, off, np.array([prior.length_spread_mm**-2]))


def _listen(system: _System, seen: Measurement) -> None:
    """What the cameras say; a camera's normals lose weight by how far they are off from what its others say."""
    normals, ends = seen.normals, seen.ends
    for residual, direction, valid, clearness in zip(
        normals.residual_px, normals.direction, normals.valid, normals.clearness, strict=True
    ):
        if not valid.any():
            continue
        scale = max(2.0 * float(np.median(np.abs(residual[valid]))), 2 * EDGE_PX)
        weights = np.where(valid, clearness * EDGE_PX**-2 / (1 + (residual / scale) ** 2), 0.0)
        system.add(_point_rows(curve.POSITION, direction), residual, weights)
    if ends.seen.any():
        residual = ends.residual_px[ends.seen].ravel()
        direction = ends.direction[ends.seen].reshape(-1, 3)
        lines = ends.residual_px.shape[1]
        weights = (END_PX**2 * lines) ** -1 / (1 + (residual / END_SCALE_PX) ** 2)
        system.add(_point_rows(np.tile(ends.basis, (len(residual), 1)), direction), residual, weights)


def _moved_normals(normals: Normals, step: FloatArray) -> Normals:
    """The same measurement seen from a curve whose control points moved by `step` (n, 3), to first order."""
    change = np.einsum("vnj,nj->vn", normals.direction, curve.POSITION @ step)
    return replace(normals, residual_px=np.where(normals.valid, normals.residual_px - change, 0.0))


def _moved_ends(ends: Ends, step: FloatArray) -> Ends:
    """The same ends seen from a curve whose control points moved by `step` (n, 3), to first order."""
    change = ends.direction @ (ends.basis @ step)
    return replace(ends, residual_px=np.where(ends.seen[:, None], ends.residual_px - change, 0.0))


def _radius(normals: Normals, fitted: Curve) -> FloatArray:
    """The tube's radius (SAMPLES,) in mm along the curve: a low running quantile of what all cameras measured.

    The window is wider than the pitch of spacer disks, and the quantile low, so that disks do not count.
    """
    margin = RADIUS_WINDOW // 2
    padded = np.pad(normals.radius_mm, ((0, 0), (margin, margin)), constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, RADIUS_WINDOW + 1, axis=1)
    pooled = np.sort(windows.transpose(1, 0, 2).reshape(fitted.radius_mm.size, -1), axis=1)
    known = np.count_nonzero(~np.isnan(pooled), axis=1)
    rank = (RADIUS_QUANTILE * np.maximum(known - 1, 0)).astype(int)
    return np.where(known > 0, pooled[np.arange(len(pooled)), rank], fitted.radius_mm)
