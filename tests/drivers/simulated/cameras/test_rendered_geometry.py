"""The silhouette of the rendered robot against OpenCV's projection of its surface."""

from functools import lru_cache

import cv2
import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import (
    BodySettings,
    LightSettings,
    SensorSettings,
    SimulatedCamerasSettings,
)
from messaging.frames import CameraCalibration

Array = NDArray[np.float64]

RADIUS_MM = 3.0
UP = np.array([0.0, 0.0, 1.0])
CAMERAS = {camera.camera: camera for camera in default_cameras()}
WHITE_ON_BLACK = SimulatedCamerasSettings(
    body=BodySettings(
        diameter_mm=(2 * RADIUS_MM,),
        tube_colour=((255, 255, 255),),
        disk_spacing_mm=1000.0,
        holder_colour=(0, 0, 0),
    ),
    light=LightSettings(backdrop_colour=(0, 0, 0), ambient=1.0),
    sensor=SensorSettings(lens_blur_px=1.5, noise_levels=0.0),
)


def arc(
    curvature_per_mm: float, heading_rad: float, length_mm: float = 80.0, count: int = 81
) -> tuple[Array, Array]:
    """Points (n, 3) and tangents (n, 3) of a circular arc that rises along +Z and bends towards the heading."""
    angle = curvature_per_mm * np.linspace(0, length_mm, count)
    aside = np.where(angle == 0, 0, (1 - np.cos(angle)) / (curvature_per_mm or 1))
    up = np.sin(angle) / curvature_per_mm if curvature_per_mm else np.linspace(0, length_mm, count)
    heading = np.array([np.cos(heading_rad), np.sin(heading_rad)])
    points = np.column_stack([aside[:, None] * heading, up])
    return points, np.column_stack([np.sin(angle)[:, None] * heading, np.cos(angle)])


@lru_cache
def renderer(name: str, settings: SimulatedCamerasSettings = WHITE_ON_BLACK) -> Renderer:
    return Renderer(CAMERAS[name], np.array([80.0]), settings, seed=1)


def render(
    camera: CameraCalibration, points: Array, settings: SimulatedCamerasSettings = WHITE_ON_BLACK
) -> Array:
    """The whole picture's green levels, 0 to 1, before noise and coding."""
    canvas = renderer(camera.camera, settings).draw(points, points)
    picture = np.zeros((camera.height_px, camera.width_px))
    picture[canvas.window.slices] = canvas.pixels[:, :, 1] / 255
    return picture


def project(camera: CameraCalibration, points_mm: Array) -> Array:
    pose = camera.camera_from_robot
    rotation, _ = cv2.Rodrigues(pose[:3, :3])
    pixels, _ = cv2.projectPoints(points_mm, rotation, pose[:3, 3], camera.intrinsics, camera.distortion)
    return pixels[:, 0]


def surface(points: Array, tangents: Array) -> Array:
    """Dense points of the tube's surface, (n, 720, 3)."""
    first = np.cross(tangents, [0.3, 0.9, 0.1])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(tangents, first)
    turn = np.linspace(0, 2 * np.pi, 720, endpoint=False)[:, None]
    return points[:, None] + RADIUS_MM * (np.cos(turn) * first[:, None] + np.sin(turn) * second[:, None])


def edge_px(picture: Array, start: Array, direction: Array, reach_px: float = 60.0) -> float:
    """How far the silhouette reaches from an inner point along a unit direction."""
    step = 0.02
    along = np.arange(0, reach_px, step) + step / 2
    line = start + along[:, None] * direction
    levels = cv2.remap(picture.astype(np.float32), line.astype(np.float32)[:, None], None, cv2.INTER_LINEAR)
    return float(levels.sum() * step)


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize(("curvature", "heading"), [(0.0, 0.0), (0.012, 0.4), (0.025, 2.6), (0.03, 3.6)])
def test_both_edges_lie_where_the_surface_projects(name: str, curvature: float, heading: float) -> None:
    camera = CAMERAS[name]
    points, _ = arc(curvature, heading)
    picture = render(camera, points)
    fine_points, fine_tangents = arc(curvature, heading, count=1601)
    pixels = project(camera, surface(fine_points, fine_tangents).reshape(-1, 3)).reshape(1601, 720, 2)
    middle = project(camera, points)
    errors, midline_errors = [], []
    for arc_mm in range(8, 72, 4):
        direction = middle[arc_mm + 1] - middle[arc_mm - 1]
        direction /= np.linalg.norm(direction)
        normal = np.array([-direction[1], direction[0]])
        near = pixels[(arc_mm - 6) * 20 : (arc_mm + 6) * 20].reshape(-1, 2) - middle[arc_mm]
        near = near[np.abs(near @ direction) < 0.4]
        sides = [float((near @ (sign * normal)).max()) for sign in (1, -1)]
        seen = [edge_px(picture, middle[arc_mm], sign * normal) for sign in (1, -1)]
        errors += [seen[0] - sides[0], seen[1] - sides[1]]
        midline_errors.append((errors[-2] - errors[-1]) / 2)
    assert np.abs(errors).max() < 0.04, np.round(errors, 3)
    assert np.sqrt(np.mean(np.square(errors))) < 0.02
    assert abs(np.mean(midline_errors)) < 0.01


@pytest.mark.parametrize("name", CAMERAS)
def test_the_midline_of_a_straight_tube_is_biased_by_perspective_as_a_cylinder_is(name: str) -> None:
    """The two contact lines of the view cone stand at arccos(r / distance) either side of the camera's direction."""
    camera = CAMERAS[name]
    points, _ = arc(0.0, 0.0)
    picture = render(camera, points)
    pose = camera.camera_from_robot
    eye = -pose[:3, :3].T @ pose[:3, 3]
    away, towards = np.hypot(eye[0], eye[1]), np.arctan2(eye[1], eye[0])
    contact = towards + np.array([1, -1]) * np.arccos(RADIUS_MM / away)
    for height in (20.0, 45.0, 70.0):
        middle = np.array([0, 0, height])
        axis = project(camera, np.array([middle - UP, middle, middle + UP]))
        direction = (axis[2] - axis[0]) / np.linalg.norm(axis[2] - axis[0])
        normal = np.array([-direction[1], direction[0]])
        expected = []
        for angle in contact:
            foot = np.array([RADIUS_MM * np.cos(angle), RADIUS_MM * np.sin(angle), 0.0])
            line = (
                project(camera, foot + np.linspace(height - 3, height + 3, 601)[:, None] * [0, 0, 1])
                - axis[1]
            )
            expected.append(line[np.argmin(np.abs(line @ direction))] @ normal)
        seen = [edge_px(picture, axis[1], sign * normal) * sign for sign in (1, -1)]
        assert sum(seen) / 2 == pytest.approx(sum(expected) / 2, abs=0.02)


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize(("curvature", "heading"), [(0.0, 0.0), (0.02, 2.6), (0.03, -1.5)])
def test_the_tip_ends_where_its_sphere_does(name: str, curvature: float, heading: float) -> None:
    camera = CAMERAS[name]
    points, _ = arc(curvature, heading)
    picture = render(camera, points)
    centre = arc(curvature, heading, length_mm=80 - RADIUS_MM)[0][-1]
    rng = np.random.default_rng(0)
    normals = rng.standard_normal((400_000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    ball = project(camera, centre + RADIUS_MM * normals)
    start = project(camera, centre[None])[0]
    tip = project(camera, points[-1:])[0]
    direction = (tip - start) / np.linalg.norm(tip - start)
    aside = np.array([-direction[1], direction[0]])
    beam = np.abs((ball - start) @ aside) < 0.4
    assert edge_px(picture, start, direction) == pytest.approx(
        ((ball - start) @ direction)[beam].max(), abs=0.03
    )


def test_a_moving_robot_is_blurred_about_its_mean_pose() -> None:
    points, _ = arc(0.0, 0.0)
    shift = np.array([0.4, 0.0, 0.0])
    still = renderer("left").draw(points, points)
    moving = renderer("left").draw(points - shift, points + shift)
    levels, middle = [], []
    for canvas in (still, moving):
        level = canvas.pixels[600 - canvas.window.top, :, 1] / 255
        columns = np.arange(canvas.window.left, canvas.window.right)
        levels.append(level)
        middle.append(float((level * columns).sum() / level.sum()))
    partial = [int(((level > 0.02) & (level < 0.98)).sum()) for level in levels]
    assert middle[1] == pytest.approx(middle[0], abs=0.02)
    assert levels[1].sum() == pytest.approx(levels[0].sum(), abs=0.05)
    assert partial[1] >= partial[0] + 6


@pytest.mark.parametrize("name", CAMERAS)
def test_the_tube_ends_at_the_collar_in_the_rim_of_its_base(name: str) -> None:
    camera = CAMERAS[name]
    picture = render(camera, arc(0.0, 0.0)[0])
    turn = np.linspace(0, 2 * np.pi, 3600)
    rim = project(camera, RADIUS_MM * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn]))
    start = project(camera, np.array([[0.0, 0.0, 5.0]]))[0]
    for column in (-12.0, 0.0, 12.0):
        begin = start + np.array([column, 0.0])
        beam = np.abs(rim[:, 0] - begin[0]) < 0.1
        expected = rim[beam, 1].max() - begin[1]
        assert edge_px(picture, begin, np.array([0.0, 1.0])) == pytest.approx(expected, abs=0.1)


def test_disks_widen_the_silhouette_by_their_own_height() -> None:
    camera = CAMERAS["left"]
    points, _ = arc(0.0, 0.0)
    body = msgspec.structs.replace(
        WHITE_ON_BLACK.body, disk_spacing_mm=8.0, disk_proud_mm=0.6, disk_colour=(255, 255, 255)
    )
    plain = render(camera, points)
    ringed = render(camera, points, msgspec.structs.replace(WHITE_ON_BLACK, body=body))
    pose = camera.camera_from_robot
    for height in (8.0, 40.0, 72.0):
        at = project(camera, np.array([[0, 0, height]]))[0]
        across = project(camera, np.array([[0, 0, height]]) + pose[0, :3])[0] - at
        scale = float(np.linalg.norm(across))
        across /= scale
        grown = [edge_px(ringed, at, sign * across) - edge_px(plain, at, sign * across) for sign in (1, -1)]
        assert grown == pytest.approx([0.6 * scale] * 2, abs=0.06)


@pytest.mark.parametrize("name", CAMERAS)
def test_the_rays_of_pixels_project_onto_their_centres(name: str) -> None:
    camera = CAMERAS[name]
    projection = Projection(camera)
    columns, rows = np.array([0, 1919, 0, 1919, 960, 1500]), np.array([0, 0, 1079, 1079, 540, 20])
    x, y = projection.rays(rows * 1920 + columns)
    in_camera = np.column_stack([x, y, np.ones_like(x)]).astype(np.float64)
    expected, _ = cv2.projectPoints(in_camera, np.zeros(3), np.zeros(3), camera.intrinsics, camera.distortion)
    np.testing.assert_allclose(np.column_stack([columns, rows]), expected[:, 0], atol=5e-4)
    np.testing.assert_allclose(projection.to_pixels(200 * in_camera), expected[:, 0], atol=1e-6)
