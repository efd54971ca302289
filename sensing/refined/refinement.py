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
from sensing.geometry.vectors import lengths, median
from sensing.refined.measuring import Ends, Measurement, Normals, View, measure
from sensing.refined.tube import Curve, Tip

EDGE_PX = 0.25
"""Standard deviation of one measured middle, systematic part included."""
END_PX = 0.5
OUTLINE_PX = 0.2
UNSEEN_END = 25.0
VARIANCE_SHARE = 0.7
"""The deviations above are larger than what is seen, so that the fit is stiff; this share of its variance is."""
BASE_MM = 0.02
BASE_TANGENT = 0.01
SPEED = 0.004
SMOOTH_MM = 60.0
"""Standard deviation of the change of curvature between neighbouring knots, times the length squared, in mm."""
SMOOTHNESS: FloatArray = np.asarray(np.kron(curve.JUMPS.T @ curve.JUMPS, np.eye(3)) / SMOOTH_MM**2)
END_SCALE_PX = 4.0
RADIUS_WINDOW = 16
RADIUS_QUANTILE = 0.4

LENGTH = 3 * curve.CONTROL_POINTS
KNOWN = LENGTH + 1
"""The unknowns: the control points' coordinates, point by point, at LENGTH the length, from KNOWN on two for each camera,
the shift of its picture, which is nearly nothing when the calibration is true."""
SHIFT_PX = 1.0


@dataclass(frozen=True)
class Prior:
    """What is known before looking: the base's height, and the robot's length if it is, with their spreads.

    A base that is not known has infinite ones.
    """

    insertion_mm: float
    length_mm: float | None
    length_spread_mm: float = 0.1
    base_spread_mm: float = BASE_MM
    base_spread_rad: float = BASE_TANGENT


@dataclass(frozen=True)
class Patience:
    """How long to go on: at most so many rounds, and no longer once a round moves no control point by more than this."""

    rounds: int
    enough_mm: float


@dataclass(frozen=True)
class Fit:
    """A fitted curve with its covariance over (control points, length), and how the cameras agree with it.

    `shift_px` (v, 2) is by how much each camera's picture seems to lie elsewhere than its calibration says.
    """

    curve: Curve
    covariance: FloatArray
    shift_px: FloatArray
    normals: Normals
    ends: Ends
    cost: float

    @property
    def misfit(self) -> float:
        """How badly the assumed tip explains the pictures.

        It is the cost, the form of the end's outline once more, since that is either round or flat whatever disturbs the
        rest, and a price for each observation that the curve has no use for: it must not win by looking away.
        """
        missed = np.count_nonzero(~self.normals.valid) + UNSEEN_END * np.count_nonzero(~self.ends.seen)
        return self.cost + (self.ends.outline_px / OUTLINE_PX) ** 2 + float(missed)

    def covariance_mm2(self, basis: FloatArray) -> FloatArray:
        """Covariances (k, 3, 3) of the curve's points at these rows (k, CONTROL_POINTS) of the basis."""
        points = VARIANCE_SHARE * self.covariance[:-1, :-1].reshape(
            curve.CONTROL_POINTS, 3, curve.CONTROL_POINTS, 3
        )
        covariance = np.einsum("kaij,ka->kij", np.einsum("kb,aibj->kaij", basis, points), basis)
        return np.asarray((covariance + np.swapaxes(covariance, 1, 2)) / 2)


def refine(views: tuple[View, ...], start: Curve, prior: Prior, tip: Tip, patience: Patience) -> Fit:
    """Gauss-Newton from a starting curve; raises RefusedError when the pictures determine none."""
    fitted = start
    for _ in range(patience.rounds):
        system = _System(len(views))
        _expect(system, prior, fitted)
        seen = measure(views, fitted, tip)
        _listen(system, seen)
        solution = system.solve(fitted.control_mm)
        moved, longer = solution.step[:LENGTH].reshape(-1, 3), float(solution.step[LENGTH])
        fitted = Curve(fitted.control_mm + moved, fitted.length_mm + longer, _radius(seen.normals, fitted))
        if np.abs(moved).max() < patience.enough_mm:
            break
    normals, ends = _moved_normals(seen.normals, moved), _moved_ends(seen.ends, moved)
    return Fit(fitted, solution.covariance, solution.shift_px(), normals, ends, solution.cost)


class _System:
    """The normal equations of one round, gathered row by row and solved at once."""

    def __init__(self, cameras: int) -> None:
        self.size = KNOWN + 2 * cameras
        self._rows: list[FloatArray] = []
        self._residuals: list[FloatArray] = []
        self._weights: list[FloatArray] = []

    def add(self, residuals: FloatArray, weights: FloatArray, *blocks: tuple[int, FloatArray]) -> None:
        """Add residuals (k,) = measured - predicted with inverse variances (k,).

        Their rows are 0 but for blocks of columns (k, m), each over the unknowns from a place on.
        """
        rows = np.zeros((len(residuals), self.size))
        for at, columns in blocks:
            rows[:, at : at + columns.shape[1]] = columns
        self._rows.append(rows)
        self._residuals.append(residuals)
        self._weights.append(weights)

    def solve(self, control_mm: FloatArray) -> "_Solution":
        """The best step from these control points; raises RefusedError when there is none."""
        rows, residuals = np.concatenate(self._rows), np.concatenate(self._residuals)
        weights = np.concatenate(self._weights)
        weighted = rows * weights[:, None]
        matrix, vector = rows.T @ weighted, residuals @ weighted
        at = control_mm.ravel()
        rough = SMOOTHNESS @ at
        matrix[:LENGTH, :LENGTH] += SMOOTHNESS
        vector[:LENGTH] -= rough
        try:
            covariance = np.asarray(np.linalg.inv(matrix[:KNOWN, :KNOWN]))
        except np.linalg.LinAlgError as error:
            raise RefusedError(f"the pictures do not determine a curve ({error})") from error
        step = np.asarray(covariance @ vector[:KNOWN])
        return _Solution(step, covariance, float(weights @ residuals**2 + at @ rough), matrix, vector)


@dataclass(frozen=True)
class _Solution:
    """A step (KNOWN,), its covariance, the cost before it, and the equations with the pictures' shifts that it left out."""

    step: FloatArray
    covariance: FloatArray
    cost: float
    matrix: FloatArray
    vector: FloatArray

    def shift_px(self) -> FloatArray:
        """By how much (v, 2) each camera's picture would have to move for all to agree best, if they may."""
        cross, own = self.matrix[KNOWN:, :KNOWN], self.matrix[KNOWN:, KNOWN:]
        left = own - cross @ self.covariance @ cross.T
        return np.asarray(np.linalg.solve(left, self.vector[KNOWN:] - cross @ self.step)).reshape(-1, 2)


def _by_points(basis: FloatArray, directions: FloatArray) -> tuple[int, FloatArray]:
    """The block of the derivatives of direction . position, for directions (k, 3) at basis rows (k, n)."""
    return 0, (basis[:, :, None] * directions[:, None, :]).reshape(len(basis), -1)


def _by_shift(camera: int, directions: FloatArray) -> tuple[int, FloatArray]:
    """The block of the derivatives by a camera's shift, for directions (k, 2) in its picture."""
    return KNOWN + 2 * camera, directions


_AXES = np.eye(3)
_BY_BASE = _by_points(np.repeat(curve.POSITION[:1], 3, axis=0), _AXES)
_BY_BASE_TANGENT = _by_points(np.repeat(curve.VELOCITY[:1], 2, axis=0), _AXES[:2])


def _expect(system: _System, prior: Prior, fitted: Curve) -> None:
    """What is known without looking."""
    base = np.array([0.0, 0.0, prior.insertion_mm])
    system.add(base - fitted.points_mm[0], np.full(3, prior.base_spread_mm**-2), _BY_BASE)
    velocity = fitted.velocity_mm
    spread_mm = prior.base_spread_rad * fitted.length_mm
    system.add(-velocity[0, :2], np.full(2, spread_mm**-2), _BY_BASE_TANGENT)
    speed = lengths(velocity)[:, 0]
    by_points = _by_points(curve.VELOCITY, velocity / (speed * fitted.length_mm)[:, None])
    by_length = LENGTH, -speed[:, None] / fitted.length_mm**2
    system.add(1 - speed / fitted.length_mm, np.full(len(speed), SPEED**-2), by_points, by_length)
    if prior.length_mm is not None:
        off = np.array([prior.length_mm - fitted.length_mm])
        system.add(off, np.array([prior.length_spread_mm**-2]), (LENGTH, np.ones((1, 1))))
    shifts = system.size - KNOWN
    system.add(np.zeros(shifts), np.full(shifts, SHIFT_PX**-2), (KNOWN, np.eye(shifts)))


def _listen(system: _System, seen: Measurement) -> None:
    """What the cameras say; what is off by more than most of a camera's normals loses weight."""
    normals, ends = seen.normals, seen.ends
    off = np.abs(normals.residual_px)
    typical = np.array([median(o[v]) if v.any() else 0.0 for o, v in zip(off, normals.valid, strict=True)])
    scale = np.maximum(2.0 * typical, 2 * EDGE_PX)[:, None]
    weights = np.where(normals.valid, normals.clearness * EDGE_PX**-2 / (1 + (off / scale) ** 2), 0.0)
    for camera, weight in enumerate(weights):
        by_points = _by_points(curve.POSITION, normals.direction[camera])
        system.add(normals.residual_px[camera], weight, by_points, _by_shift(camera, normals.across[camera]))
    for camera in np.flatnonzero(ends.seen).tolist():
        residual = ends.residual_px[camera]
        basis = np.broadcast_to(ends.basis, (len(residual), curve.CONTROL_POINTS))
        weight = (END_PX**2 * len(residual)) ** -1 / (1 + (residual / END_SCALE_PX) ** 2)
        by_points = _by_points(basis, ends.direction[camera])
        system.add(residual, weight, by_points, _by_shift(camera, ends.onwards[camera]))


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
