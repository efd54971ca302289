"""From skeletons to the centreline (METHOD steps 5 to 9), with all that has to be kept to judge it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from messaging.checked import FloatArray
from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.geometry.rays import ray_gaps, signed_gaps, triangulate
from sensing.pictures.segmentation import Mask
from sensing.plain.line import line_through, to_silhouettes_end
from sensing.plain.order import end_of_line, ordered
from sensing.plain.pairing import all_pairs
from sensing.plain.polyline import Polyline
from sensing.plain.skeleton import Skeleton

LEAST_POINTS = 5
BASE_RADII = 2.0
"""As near to the base, in the robot's radii, the holder's rim spoils the skeleton, and the base's known pose stands in."""
APART_RADII = 1.0
"""Points that are nearer to one another, in the robot's radii, are duplicates: their noise would lengthen the line."""


@dataclass(frozen=True)
class Trace:
    """A line and what it came from.

    `pair` are the two cameras it was triangulated with; `points_mm` (k, 3) are all skeleton points in space, `gaps_mm`
    (k,) the gaps between their rays with sign. `walk_px` (n, 2) is
    how far along each of the two skeletons the line's points are from the skeleton's beginning, `radius_mm` the robot's.
    """

    line: Polyline
    pair: tuple[Camera, Camera]
    points_mm: FloatArray
    gaps_mm: FloatArray
    walk_px: FloatArray
    radius_mm: float
    insertion_mm: float


def traced(
    pair: tuple[Camera, Camera],
    skeletons: Mapping[str, Skeleton],
    masks: Mapping[str, Mask],
    insertion_mm: float,
) -> Trace:
    """Pair, triangulate, order; raises RefusedError when too few points are left for a line.

    The cameras are calibrated in the robot frame, so points are in it at once (METHOD step 7).
    """
    first, second = pair
    seen = skeletons[first.name], skeletons[second.name]
    rays = [camera.rays(skeleton.pixels) for camera, skeleton in zip(pair, seen, strict=True)]
    pairs = all_pairs(ray_gaps(first, rays[0], second, rays[1]), *seen)
    one, other = rays[0][pairs[:, 0]], rays[1][pairs[:, 1]]
    points, _ = triangulate(first, one, second, other)
    half_width_mm = np.mean(
        [
            skeleton.depth_px[column] / camera.px_per_mm(points)
            for camera, skeleton, column in zip(pair, seen, pairs.T, strict=True)
        ],
        axis=0,
    )
    radius_mm = float(np.median(half_width_mm))
    base = np.array([0.0, 0.0, insertion_mm])
    far = np.flatnonzero(np.linalg.norm(points - base, axis=1) > BASE_RADII * radius_mm)
    taken = far[ordered(points[far], APART_RADII * radius_mm)] if far.size else far
    if len(taken) < LEAST_POINTS:
        raise RefusedError(
            f"cameras {first.name} and {second.name} share only {len(taken)} points of a skeleton; "
            f"{LEAST_POINTS} are needed"
        )
    taken[-1] = end_of_line(points, taken, APART_RADII * radius_mm)
    end_mm = to_silhouettes_end(points[taken], radius_mm, pair, (masks[first.name], masks[second.name]))
    return Trace(
        line=line_through(points[taken], insertion_mm, end_mm, pair),
        pair=pair,
        points_mm=points,
        gaps_mm=signed_gaps(first, one, second, other),
        walk_px=np.column_stack(
            [skeleton.reach_px[column] for skeleton, column in zip(seen, pairs[taken].T, strict=True)]
        ),
        radius_mm=radius_mm,
        insertion_mm=insertion_mm,
    )
