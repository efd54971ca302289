"""The paper's steps as a competent user would write them down with NumPy and scikit-image: the baseline to be beaten.

Full frames, a mask and a skeleton of scikit-image's, every skeleton pixel held against every one of the other picture,
midpoint triangulation, nearest neighbours, linear interpolation. Nothing of it is sensing's code.
"""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label
from skimage.morphology import closing, disk, remove_small_objects, skeletonize

from benchmarks.poses import Array
from messaging.frames import CameraCalibration

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]

SMALLEST_PX = 600
HOLDER_RADIUS_MM = 25.0
APART_MM = 3.0


def decoded(jpeg: bytes) -> Image:
    """BGR picture (h, w, 3)."""
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), dtype=np.uint8)


def nodal_points(
    pictures: Mapping[str, Image],
    backgrounds: Mapping[str, Image],
    rig: Sequence[CameraCalibration],
    arc_mm: Array,
    threshold: float = 45.0,
) -> Array:
    """Points (n, 3) at distances (n,) from the base of a robot that two cameras see; pictures by camera, BGR."""
    skeletons = [
        _skeleton(pictures[camera.camera], backgrounds[camera.camera], camera, threshold) for camera in rig
    ]
    centres, rays = zip(
        *(_rays(camera, pixels) for camera, pixels in zip(rig, skeletons, strict=True)), strict=True
    )
    pairs = {(row, _nearest(centres, ray, rays[1])) for row, ray in enumerate(rays[0])}
    pairs |= {(_nearest(centres[::-1], ray, rays[0]), column) for column, ray in enumerate(rays[1])}
    points = np.array([_midpoint(centres, rays[0][row], rays[1][column]) for row, column in sorted(pairs)])
    line = np.vstack([np.zeros(3), _ordered(points[np.linalg.norm(points, axis=1) > APART_MM])])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    return np.column_stack([np.interp(arc_mm, arc, column) for column in line.T])


def _skeleton(picture: Image, background: Image, camera: CameraCalibration, threshold: float) -> Array:
    """Skeleton pixels (n, 2) as (x, y) of the robot above its base."""
    difference = picture.astype(np.float64) - background.astype(np.float64)
    mask = np.sqrt((difference**2).sum(axis=2)) > threshold
    mask = remove_small_objects(mask, max_size=SMALLEST_PX)
    mask = closing(mask, disk(4))
    base, above = _projected(camera, np.array([[0.0, 0, 0], [0, 0, 6.0]]))
    rows, columns = np.indices(mask.shape)
    up = (above - base) / np.linalg.norm(above - base)
    below = (columns - base[0]) * up[0] + (rows - base[1]) * up[1] < 0
    mask &= ~below
    parts = label(mask)
    robot = parts == parts[round(above[1]), round(above[0])]
    return np.argwhere(skeletonize(robot))[:, ::-1].astype(np.float64)


def _projected(camera: CameraCalibration, points_mm: Array) -> Array:
    pose = camera.camera_from_robot
    pixels, _ = cv2.projectPoints(
        points_mm, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], camera.intrinsics, camera.distortion
    )
    return np.asarray(pixels.reshape(-1, 2))


def _rays(camera: CameraCalibration, pixels: Array) -> tuple[Array, Array]:
    """The camera's centre (3,) and unit directions (n, 3) through pixels (n, 2), in the robot frame."""
    ideal = cv2.undistortPoints(pixels.reshape(-1, 1, 2), camera.intrinsics, camera.distortion).reshape(-1, 2)
    rotation = camera.camera_from_robot[:3, :3]
    directions = np.column_stack([ideal, np.ones(len(ideal))]) @ rotation
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return -rotation.T @ camera.camera_from_robot[:3, 3], directions


def _nearest(centres: Sequence[Array], ray: Array, others: Array) -> int:
    """Which of the other camera's rays (n, 3) passes nearest to a ray (3,)."""
    normals = np.cross(ray, others)
    gaps = np.abs(normals @ (centres[1] - centres[0])) / np.linalg.norm(normals, axis=1)
    return int(gaps.argmin())


def _midpoint(centres: Sequence[Array], ray: Array, other: Array) -> Array:
    sides = np.column_stack([ray, -other])
    reach = np.linalg.lstsq(sides, centres[1] - centres[0], rcond=None)[0]
    return np.asarray((centres[0] + reach[0] * ray + centres[1] + reach[1] * other) / 2)


def _ordered(points_mm: Array) -> Array:
    """From the smallest Z always on to the nearest that remains; what is nearer than APART_MM is a duplicate."""
    left = list(points_mm)
    line = [left.pop(int(np.argmin(points_mm[:, 2])))]
    while left:
        away = np.array([np.linalg.norm(point - line[-1]) for point in left])
        left = [point for point, distance in zip(left, away, strict=True) if distance > APART_MM]
        away = away[away > APART_MM]
        if left:
            line.append(left.pop(int(away.argmin())))
    return np.array(line)
