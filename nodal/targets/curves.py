"""One nodal point led along a curve: a line, a spline, a circle."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from messaging.control import Target
from nodal.errors import CommandError
from nodal.targets.pace import Pace

Array = NDArray[np.float64]
Place = Sequence[float] | Array

CIRCLE_POINTS = 120
LEVEL = (0.0, 0.0, 1.0)
_CURVE_POINTS = 400


def circle(
    node: str,
    *,
    radius_mm: float,
    period_s: float,
    height_mm: float,
    centre_mm: tuple[float, float],
    axis: tuple[float, float, float] = LEVEL,
) -> Target:
    """One nodal point on a circle round `axis`, again and again; raises CommandError, InvalidMessageError."""
    if not period_s > 0:
        raise CommandError(f"a circle's period is {period_s:g} s; it must be above 0")
    time_s = np.linspace(0, period_s, CIRCLE_POINTS + 1)
    path_mm = on_circle(
        time_s / period_s, radius_mm=radius_mm, height_mm=height_mm, centre_mm=centre_mm, axis=axis
    )
    return _led(node, "circle", time_s, path_mm, repeat=True)


def on_circle(
    turns: Array,
    *,
    radius_mm: float,
    height_mm: float,
    centre_mm: tuple[float, float] = (0.0, 0.0),
    axis: tuple[float, float, float] = LEVEL,
) -> Array:
    """Places (N, 3) in mm after these many turns (N,) of a circle round `axis`, right-handed.

    It begins where it reaches farthest towards +X, or towards +Y when the axis runs along X. Raises CommandError.
    """
    length = math.hypot(*axis)
    if not 0 < length < math.inf:
        raise CommandError(f"a circle's axis is {', '.join(f'{a:g}' for a in axis)}; it must point somewhere")
    normal = np.array(axis) / length
    start = np.eye(3)[0 if abs(normal[0]) < 1 - 1e-9 else 1]
    start -= (start @ normal) * normal
    start /= np.linalg.norm(start)
    angle_rad = 2 * math.pi * turns[:, None]
    centre = np.array([*centre_mm, height_mm])
    places: Array = centre + radius_mm * (
        np.cos(angle_rad) * start + np.sin(angle_rad) * np.cross(normal, start)
    )
    return places


def line(node: str, start_mm: Place, end_mm: Place, pace: Pace, *, repeat: bool = False) -> Target:
    """One nodal point from here to there and, where that is to be repeated, back; raises CommandError."""
    start, end = np.array(start_mm, dtype=np.float64), np.array(end_mm, dtype=np.float64)
    time_s, share = pace.spent(float(np.linalg.norm(end - start)))
    if repeat:
        if len(time_s) == 1:
            raise CommandError("a line that repeats must have some length; its two ends are one place")
        time_s = np.append(time_s, time_s[-1] + time_s[1:])
        share = np.append(share, share[-2::-1])
    return _led(node, "line", time_s, start + share[:, None] * (end - start), repeat=repeat)


def spline(node: str, places_mm: Sequence[Place], pace: Pace, *, closed: bool = False) -> Target:
    """One nodal point along the smooth curve through three places or more; a closed one is run through again and again.

    A cubic spline over the distances between the places, run through evenly by its length, from a stand to a stand unless
    it is closed. Raises CommandError.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  imported late: slow, and only a spline needs it

    knots = np.array(places_mm, dtype=np.float64)
    if closed:
        knots = np.append(knots, knots[:1], axis=0)
    apart_mm = np.linalg.norm(np.diff(knots, axis=0), axis=1)
    if len(places_mm) < 3 or not apart_mm.all():
        raise CommandError(
            f"a spline goes through three places or more, each different from the one before; {len(places_mm)} are given"
            + ("" if apart_mm.all() else ", and two that follow one another are the same")
        )
    distance_mm = np.append(0.0, np.cumsum(apart_mm))
    curve = CubicSpline(distance_mm, knots, bc_type="periodic" if closed else "natural")
    fine_mm = np.linspace(0, distance_mm[-1], _CURVE_POINTS * len(places_mm) + 1)
    run_mm = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(curve(fine_mm), axis=0), axis=1)))
    time_s, share = pace.evenly(float(run_mm[-1])) if closed else pace.spent(float(run_mm[-1]))
    return _led(node, "spline", time_s, curve(np.interp(share * run_mm[-1], run_mm, fine_mm)), repeat=closed)


def _led(node: str, name: str, time_s: Array, path_mm: Array, *, repeat: bool) -> Target:
    return Target(
        name=name,
        node_names=(node,),
        weights=np.ones(1),
        time_s=time_s,
        position_mm=path_mm[:, None],
        repeat=repeat,
    )
