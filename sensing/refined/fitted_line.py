"""The fitted spline as a centreline with its own uncertainty."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from messaging.checked import FloatArray
from sensing.geometry import curve
from sensing.refined.refinement import Fit


@dataclass(frozen=True)
class FittedLine:
    """See `sensing.shape.Centreline`."""

    fit: Fit

    @cached_property
    def points_mm(self) -> FloatArray:
        """Points (curve.SAMPLES, 3) from base to tip."""
        return self.fit.curve.points_mm

    @cached_property
    def arc_mm(self) -> FloatArray:
        """Distances (curve.SAMPLES,) from the base along the line."""
        return curve.arc_lengths(self.points_mm)

    def at(self, arc_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (k, 3) and covariances (k, 3, 3) at distances (k,) from the base."""
        control = self.fit.curve.control_mm
        line = curve.FINE_POSITION @ control
        basis = curve.basis(np.interp(arc_mm, curve.arc_lengths(line), curve.FINE_PARAMETER))
        tangent = line[-1] - line[-2]
        beyond = np.maximum(arc_mm - self.arc_mm[-1], 0.0)[:, None] * (tangent / np.linalg.norm(tangent))
        return basis @ control + beyond, self.fit.covariance_mm2(basis)
