"""Where the tip is asked to go: within easy reach of the 80 mm robot on its stage."""

import numpy as np
from scipy.interpolate import CubicSpline

from messaging.control import Target
from nodal.targets import circle

TIP = "tip"
CIRCLE = circle(TIP, radius_mm=15.0, period_s=10.0, height_mm=85.0, centre_mm=(0.0, 0.0))
STEP_FROM_MM, STEP_TO_MM = (6.0, -5.0, 86.0), (14.0, 1.0, 86.0)
"""10 mm apart, and neither on the axis."""
REST_MM = ((8.0, -5.0, 86.0), (-12.0, 6.0, 85.0), (2.0, 14.0, 88.0))
SPLINE_MM = ((10, 0, 86), (12, 10, 84), (-4, 13, 88), (-13, -2, 85), (-3, -12, 83), (8, -9, 88))
SPLINE_S = 12.0


def point(place_mm: tuple[float, float, float]) -> Target:
    """The tip held at one place."""
    return Target(
        name="point",
        node_names=(TIP,),
        weights=np.ones(1),
        time_s=np.zeros(1),
        position_mm=np.array([[place_mm]], dtype=np.float64),
        repeat=False,
    )


def spline() -> Target:
    """A closed smooth path of the tip through `SPLINE_MM`."""
    knots = np.array([*SPLINE_MM, SPLINE_MM[0]], dtype=np.float64)
    time_s = np.linspace(0.0, SPLINE_S, 241)
    path = CubicSpline(np.linspace(0.0, SPLINE_S, len(knots)), knots, bc_type="periodic")(time_s)
    return Target(
        name="spline",
        node_names=(TIP,),
        weights=np.ones(1),
        time_s=time_s,
        position_mm=path[:, None],
        repeat=True,
    )
