"""Nodal points that another program measured, as the controller takes them in. Pure."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from controller.cycle import Sighting
from messaging.errors import InvalidMessageError
from messaging.shape import ShapeEstimate

_NO_POINTS = np.zeros((0, 3))
_NONE = np.zeros(0)


def sighting_of(
    names: tuple[str, ...],
    arc_mm: ArrayLike,
    node_mm: ArrayLike,
    *,
    age_s: float,
    standard_deviation_mm: float,
    insertion_mm: float = 0.0,
) -> Sighting:
    """These points as they were seen `age_s` ago; raises InvalidMessageError when sizes differ or a value is not finite.

    `arc_mm` (k,) is each point's distance from the base along the centreline, `node_mm` (k, 3) its place in the robot
    frame, `insertion_mm` how far the base had been moved along +Z.
    """
    if not math.isfinite(age_s):
        raise InvalidMessageError(f"points seen {age_s} s ago; the age must be finite")
    covariance: NDArray[np.float64] = np.diag(np.full(3, standard_deviation_mm**2))
    shape = ShapeEstimate(
        sequence=0,
        capture_time_ns=0,
        capture_to_publish_ns=round(age_s * 1e9),
        refusal="",
        method="given",
        arc_mm=_NONE,
        flags=(),
        centreline_mm=_NO_POINTS,
        epipolar_angle_rad=_NONE,
        node_names=names,
        node_arc_mm=np.asarray(arc_mm, dtype=np.float64),
        node_mm=np.asarray(node_mm, dtype=np.float64),
        node_covariance_mm2=np.tile(covariance, (len(names), 1, 1)),
        length_mm=0.0,
        known_length_mm=0.0,
        insertion_mm=insertion_mm,
        ray_gap_mm=0.0,
        ray_bias_mm=0.0,
        residual_px=0.0,
        camera_names=(),
        camera_residual_px=_NONE,
        visible_mm=_NONE,
        stage_names=(),
        stage_s=_NONE,
    )
    return Sighting(shape=shape, age_s=age_s)
