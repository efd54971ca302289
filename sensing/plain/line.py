"""From ordered skeleton points to a centreline that runs from the base to the tip, and how exact it is.

A skeleton ends about one half width before the silhouette does. At the base the known pose stands in for the missing
piece; at the tip the line goes straight on to the silhouette's border.
"""

import numpy as np

from messaging.checked import FloatArray
from sensing.geometry.camera import Camera
from sensing.pictures.segmentation import Mask
from sensing.plain.polyline import END_SLOPE, Polyline

SIDEWAYS_PX = 0.6
"""RMS distance of a skeleton pixel from the axis' image: half a pixel, and what perspective moves the middle by."""
ALONG_MM = 0.1
"""And along it: a pixel."""
BASE_MM = 0.02
ARC_SHARE = 0.004
"""Standard deviation of a distance along the line, as a share of it."""
END_SHARE = 0.15
"""Standard deviation of the last piece's length, as a share of it: tips are round or flat."""
LONGEST_END, END_STEP_MM = 3.0, 0.05
LOOSE_MM = 20.0
"""Standard deviation of what nothing speaks about: two rays in one plane with the curve."""


def end_direction(points_mm: FloatArray) -> FloatArray:
    """The unit direction (3,) in which a line of points (n, 3) ends."""
    last = points_mm[-1] - points_mm[max(len(points_mm) - 3, 0)]
    return np.asarray(last / np.linalg.norm(last))


def to_silhouettes_end(
    points_mm: FloatArray, radius_mm: float, cameras: tuple[Camera, ...], masks: tuple[Mask, ...]
) -> float:
    """How far straight on from the last of points (n, 3) the silhouettes reach, in mm, at most LONGEST_END radii.

    A camera counts by how much of that it sees from the side.
    """
    onwards = end_direction(points_mm)
    reach = np.arange(0.0, LONGEST_END * radius_mm, END_STEP_MM)
    places = points_mm[-1] + reach[:, None] * onwards
    total = weights = 0.0
    for camera, mask in zip(cameras, masks, strict=True):
        columns, rows = camera.project(places).round().astype(int).T
        inside = (rows >= 0) & (rows < mask.shape[0]) & (columns >= 0) & (columns < mask.shape[1])
        inside[inside] = mask[rows[inside], columns[inside]] > 0
        left = np.flatnonzero(~inside)
        sight = points_mm[-1] - camera.centre_mm
        sine2 = float(np.sum(np.cross(sight, onwards) ** 2) / np.sum(sight**2))
        total += sine2 * float(reach[left[0]] if left.size else reach[-1])
        weights += sine2
    return max(total / max(weights, 1e-12), END_STEP_MM)


def line_through(
    points_mm: FloatArray, insertion_mm: float, end_mm: float, cameras: tuple[Camera, ...]
) -> Polyline:
    """The line from the base through ordered skeleton points (n, 3) seen by two cameras and `end_mm` straight on."""
    base = np.array([0.0, 0.0, insertion_mm])
    # the robot leaves its base along +Z: half way up it has gone a quarter of the way aside
    rise = (points_mm[0] - base) * (0.25, 0.25, 0.5)
    places = np.vstack([base, base + rise, points_mm, points_mm[-1] + end_mm * end_direction(points_mm)])
    bare = Polyline(places, np.zeros((len(places), 3, 3)))
    seen = _triangulated(cameras, places[1:-1], bare.tangents[1:-1])
    along = bare.tangents[:, :, None] * bare.tangents[:, None, :]
    across = np.eye(3) - along[-1]
    end = seen[-1] + end_mm**2 * (END_SHARE**2 * along[-1] + END_SLOPE**2 * across)
    covariance = np.concatenate([[BASE_MM**2 * np.eye(3)], seen, [end]])
    return Polyline(places, covariance + (ARC_SHARE * bare.arc_mm[:, None, None]) ** 2 * along)


def _triangulated(cameras: tuple[Camera, ...], points_mm: FloatArray, tangents: FloatArray) -> FloatArray:
    """Covariances (n, 3, 3) of points (n, 3) on a line with these unit tangents (n, 3) that cameras see as skeletons.

    Each camera tells where the line is sideways in its picture, and nothing along it. Where the line runs along the
    epipolar direction, all of them tell the same, and the covariance grows.
    """
    information = (tangents[:, :, None] * tangents[:, None, :]) / ALONG_MM**2 + np.eye(3) / LOOSE_MM**2
    for camera in cameras:
        _, jacobian = camera.project_with_jacobian(points_mm)
        along = np.einsum("kij,kj->ki", jacobian, tangents)
        normal = np.column_stack([-along[:, 1], along[:, 0]])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        row = np.einsum("ki,kij->kj", normal, jacobian)
        information += row[:, :, None] * row[:, None, :] / SIDEWAYS_PX**2
    return np.asarray(np.linalg.inv(information))
