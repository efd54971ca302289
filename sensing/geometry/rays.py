"""Rays of two cameras: how far they pass from one another, where they meet, and how well a pair of cameras can tell."""

import numpy as np

from messaging.checked import FloatArray
from sensing.geometry.camera import Camera
from sensing.geometry.vectors import cross, inner, lengths


def ray_gaps(first: Camera, first_rays: FloatArray, second: Camera, second_rays: FloatArray) -> FloatArray:
    """Gaps (n, m) in mm between rays (n, 3) of one camera and rays (m, 3) of another."""
    # (a x b) . c = (c x a) . b, and the sine of unit vectors' angle is |a x b|: two matrix products do
    baseline = second.centre_mm - first.centre_mm
    product = np.cross(baseline, first_rays) @ second_rays.T
    cosine = first_rays @ second_rays.T
    return np.asarray(np.abs(product) / np.sqrt(np.maximum(1.0 - cosine**2, 1e-12)))


def triangulate(
    first: Camera, first_rays: FloatArray, second: Camera, second_rays: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points (n, 3) midway between paired rays, each (n, 3), and the gaps (n,) between the rays, in mm."""
    across = second.centre_mm - first.centre_mm
    dot = np.einsum("ij,ij->i", first_rays, second_rays)
    along_first, along_second = first_rays @ across, second_rays @ across
    sine2 = np.maximum(1.0 - dot**2, 1e-12)
    reach_first = (along_first - dot * along_second) / sine2
    reach_second = (dot * along_first - along_second) / sine2
    near_first = first.centre_mm + reach_first[:, None] * first_rays
    near_second = second.centre_mm + reach_second[:, None] * second_rays
    return (near_first + near_second) / 2, np.linalg.norm(near_first - near_second, axis=1)


def signed_gaps(first: Camera, first_rays: FloatArray, second: Camera, second_rays: FloatArray) -> FloatArray:
    """Gaps (n,) in mm between paired rays, each (n, 3): positive where the second passes on the side of first x second."""
    normal = cross(first_rays, second_rays)
    return np.asarray(
        normal @ (second.centre_mm - first.centre_mm) / np.maximum(lengths(normal)[:, 0], 1e-12)
    )


def epipolar_angles(first: Camera, second: Camera, points_mm: FloatArray, tangents: FloatArray) -> FloatArray:
    """Angles (n,) in rad between a curve's tangents (n, 3) at points (n, 3) and the epipolar planes of two cameras.

    Where the angle is 0 the curve runs along the epipolar direction, and its depth cannot be told by pairing pixels.
    """
    normals = cross(points_mm - first.centre_mm, points_mm - second.centre_mm)
    size = np.maximum(lengths(normals) * lengths(tangents), 1e-12)
    return np.asarray(np.arcsin(np.minimum(np.abs(inner(normals, tangents)) / size, 1.0))[:, 0])


def best_pair(cameras: tuple[Camera, ...], towards_mm: FloatArray) -> tuple[Camera, Camera]:
    """The two cameras whose sights of a point (3,) are nearest to a right angle: the best two to triangulate with."""
    sights = np.array([towards_mm - camera.centre_mm for camera in cameras])
    sights /= np.linalg.norm(sights, axis=1, keepdims=True)
    cosines = np.abs(sights @ sights.T) + np.eye(len(cameras)) * 2
    first, second = divmod(int(cosines.argmin()), len(cameras))
    return cameras[first], cameras[second]
