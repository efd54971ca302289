"""What the cameras saw of a robot whose tendons were moved, as numbers of its model, and how sure they are. Pure.

The model is the one that the controller's belief corrects while it runs (controller/belief.py): bends are
`T (1 + G) q(e) + b`, with a lost motion of each tendon axis and a gain of the stage, and a nodal point is where constant
curvature puts it, plus an offset of its own. Here all of it is fitted to all poses at once, by least squares about the
nominal model.

No real robot is of this model, so what a fit leaves over is mostly not the cameras' noise: it is the same in neighbouring
poses and in neighbouring points. Its covariance over the coordinates of one pose is therefore taken from the residuals
themselves, and the second fit is weighted by it (feasible generalised least squares; Greene, "Econometric Analysis", ch. 9).
Poses that follow one another are alike, too: variances grow by the inflation of an autoregression of first order.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from calibration.errors import RobotPosesError
from calibration.robot_model import Array, Poses, RobotModel

_ROUNDS = 2
_EXPECTED_MM = 0.3
"""What the first fit takes a model to leave over."""
_LEAST_MM = 1e-3
_ENGAGED_SIGMA = 0.6
_OUTLIER = 3.0
"""Standard deviations from which a coordinate counts for less."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Expected:
    """How far robots are from their drawings, as standard deviations: what is not seen is believed to be so."""

    gain_sigma: float = 0.3
    bias_rad: float = 0.15
    lost_motion_mm: float = 0.3
    """Most likely."""
    lost_motion_sigma_mm: float = 0.3
    stage_gain_sigma: float = 0.1
    offset_mm: float = 1.0


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Estimate:
    """A value of any shape, and its standard deviation, of the same shape."""

    value: Array
    sigma: Array


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Identified:
    """A robot, as a correction of its nominal model."""

    gain: Estimate
    """(2 S, 2 S): G, as a share."""
    bias_rad: Estimate
    """(2 S,) at the homed zero: mean over all homings, and how far another homing may be from it."""
    stage_gain: Estimate
    """(1,), or (0,) without a stage."""
    lost_motion_mm: Estimate
    """(D,)."""
    rms_mm: float
    """Distance of nodal points from the model, over the poses that were fitted."""


class Identification:
    """Of one robot, seen at so many nodal points."""

    def __init__(self, model: RobotModel, expected: Expected, arc_mm: Array) -> None:
        """`arc_mm` (k,) of the nodal points."""
        self._model, self._arc_mm, self._expected = model, arc_mm, expected
        self._bends, self._axes = model.coordinates_of_command.shape

    def identified(self, runs: Sequence[Poses]) -> Identified:
        """What these poses say of the robot, each run of them since it was homed; raises RobotPosesError."""
        poses, least = sum(len(run) for run in runs), 2 * (self._bends + 1)
        if poses < least:
            raise RobotPosesError(
                f"{poses} poses of the robot: at least {least} are needed to identify its {self._bends} bends"
            )
        numbers = _Numbers(self._model, self._expected, self._arc_mm, len(runs))
        noise = np.diag(np.concatenate([run.sigma_mm for run in runs]).repeat(3, axis=1).mean(axis=0) ** 2)
        spread, best, inflation = np.eye(len(noise)) * _EXPECTED_MM**2, numbers.nominal, 1.0
        for _ in range(_ROUNDS):
            best, jacobian = self._fitted(numbers, runs, spread + noise, best)
            missed = self._missed_mm(numbers, best, runs)
            spread = _spread(missed, len(best))
            inflation = _inflation(missed, np.linalg.cholesky(np.linalg.inv(spread)))
        sigma = np.sqrt(inflation * np.diag(np.linalg.inv(jacobian.T @ jacobian)))
        sigma = np.minimum(sigma, numbers.sigma)
        return self._robot(numbers, best, sigma, float(np.sqrt(3 * (missed**2).mean())))

    def _robot(self, numbers: "_Numbers", best: Array, sigma: Array, rms_mm: float) -> Identified:
        bends, tendons = self._bends, self._model.tendons

        def estimate(part: slice, shape: tuple[int, ...] = (-1,)) -> Estimate:
            return Estimate(value=best[part].reshape(shape), sigma=sigma[part].reshape(shape))

        gain, lost_motion_mm = estimate(numbers.gain, (bends, bends)), estimate(numbers.lost)
        biases_rad = best[numbers.bias].reshape(-1, bends)
        between_rad = biases_rad.std(axis=0, ddof=1) if len(biases_rad) > 1 else np.zeros(bends)
        # homing may leave each axis anywhere in its lost motion
        play_rad = self._bend_of_command(gain.value)[:, :tendons] * lost_motion_mm.value / np.sqrt(12)
        fitted_rad = sigma[numbers.bias].reshape(-1, bends)
        return Identified(
            gain=gain,
            bias_rad=Estimate(
                value=biases_rad.mean(axis=0),
                sigma=np.sqrt(
                    (fitted_rad**2).mean(axis=0) + np.maximum((play_rad**2).sum(axis=1), between_rad**2)
                ),
            ),
            stage_gain=estimate(numbers.stage),
            lost_motion_mm=lost_motion_mm,
            rms_mm=rms_mm,
        )

    def _fitted(
        self, numbers: "_Numbers", runs: Sequence[Poses], spread: Array, start: Array
    ) -> tuple[Array, Array]:
        root = np.linalg.cholesky(np.linalg.inv(spread))

        def missed(values: Array) -> Array:
            seen = self._missed_mm(numbers, values, runs) @ root
            return np.concatenate([seen.ravel(), (values - numbers.nominal) / numbers.sigma])

        found = least_squares(
            missed,
            start,
            bounds=(numbers.low, numbers.high),
            x_scale=numbers.sigma,
            loss="huber",
            f_scale=_OUTLIER,
        )
        return found.x, found.jac

    def _missed_mm(self, numbers: "_Numbers", values: Array, runs: Sequence[Poses]) -> Array:
        """(n, 3 k) over all runs."""
        gain = values[numbers.gain].reshape(self._bends, self._bends)
        biases_rad = values[numbers.bias].reshape(-1, self._bends)
        engaged = values[numbers.engaged].reshape(-1, self._model.tendons)
        offset_mm = values[numbers.offset].reshape(-1, 3)
        missed = [
            self._nodes_mm(
                run.position_mm, gain, bias_rad, values[numbers.stage], values[numbers.lost], started
            )
            + offset_mm
            - run.node_mm
            for run, bias_rad, started in zip(runs, biases_rad, engaged, strict=True)
        ]
        return np.concatenate(missed).reshape(sum(len(run) for run in runs), -1)

    def foreseen_mm(self, robot: Identified, position_mm: Array) -> Array:
        """(n, k, 3) where this robot's nodal points will be, open loop, while its axes go through `position_mm` (n, A), all of
        the way since it was homed: by the estimates alone, so that nothing is told of how one homing ended.
        """
        return self._nodes_mm(
            position_mm,
            robot.gain.value,
            robot.bias_rad.value,
            robot.stage_gain.value,
            robot.lost_motion_mm.value,
            np.zeros(self._model.tendons),
        )

    def drawn_mm(self, position_mm: Array) -> Array:
        """(n, k, 3) where the drawing has the nodal points of a robot that was homed straight."""
        bends, tendons = np.zeros(self._bends), np.zeros(self._model.tendons)
        stage = np.zeros(self._axes - self._model.tendons)
        return self._nodes_mm(position_mm, np.diag(bends), bends, stage, tendons, tendons)

    def _nodes_mm(
        self,
        position_mm: Array,
        gain: Array,
        bias_rad: Array,
        stage_gain: Array,
        lost_motion_mm: Array,
        engaged: Array,
    ) -> Array:
        """(n, k, 3) where the nodal points of such a robot are while its axes go through `position_mm` (n, A)."""
        lost, started = self._all_axes(lost_motion_mm), self._all_axes(engaged)
        felt = self._model.felt(position_mm, lost, started)
        points = self._model.bent(felt @ self._bend_of_command(gain).T + bias_rad, self._arc_mm)
        for of_stage in stage_gain:
            points[..., 2] += (1 + of_stage) * felt[:, -1:]
        return points

    def _bend_of_command(self, gain: Array) -> Array:
        model = self._model
        return model.bend_of_coordinates @ (np.eye(self._bends) + gain) @ model.coordinates_of_command

    def _all_axes(self, of_tendons: Array) -> Array:
        stage = np.zeros((*of_tendons.shape[:-1], self._axes - self._model.tendons))
        return np.concatenate([of_tendons, stage], axis=-1)


class _Numbers:
    """Where in the vector of all unknowns each kind stands, what they are expected to be, and their bounds."""

    def __init__(self, model: RobotModel, expected: Expected, arc_mm: Array, runs: int) -> None:
        bends, axes = model.coordinates_of_command.shape
        tendons, stage = model.tendons, axes - model.tendons
        offset_mm = np.maximum(expected.offset_mm * arc_mm / arc_mm.max(), _LEAST_MM)
        kinds = [
            np.full(bends**2, expected.gain_sigma),
            np.full(stage, expected.stage_gain_sigma),
            np.full(tendons, expected.lost_motion_sigma_mm),
            np.repeat(offset_mm, 3),
            np.full(runs * bends, expected.bias_rad),
            np.full(runs * tendons, _ENGAGED_SIGMA),
        ]
        ends = np.cumsum([len(kind) for kind in kinds]).tolist()
        parts = [slice(first, end) for first, end in zip([0, *ends], ends, strict=False)]
        self.gain, self.stage, self.lost, self.offset, self.bias, self.engaged = parts
        self.sigma = np.concatenate(kinds)
        self.nominal = np.zeros(len(self.sigma))
        self.nominal[self.lost] = expected.lost_motion_mm
        self.low, self.high = np.full(len(self.sigma), -np.inf), np.full(len(self.sigma), np.inf)
        self.low[self.lost], self.low[self.engaged], self.high[self.engaged] = 0.0, -1.0, 1.0


def _spread(missed_mm: Array, unknown: int) -> Array:
    """(3 k, 3 k) covariance of what was left over in one pose, of (n, 3 k)."""
    free = max(missed_mm.size - unknown, missed_mm.size // 4) / missed_mm.shape[1]
    spread: Array = missed_mm.T @ missed_mm / free + np.eye(missed_mm.shape[1]) * _LEAST_MM**2
    return spread


def _inflation(missed_mm: Array, root: Array) -> float:
    """By how much variances grow because a pose is missed like the one before it."""
    seen = missed_mm @ root
    alike = float((seen[1:] * seen[:-1]).sum() / max(float((seen**2).sum()), 1e-12))
    alike = min(max(alike, 0.0), 0.9)
    return (1 + alike) / (1 - alike)
