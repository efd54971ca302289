"""The other side of the experiment: exact curves, the simulated cameras that photograph them, and a painter of silhouettes.

Nothing here uses sensing's own geometry.
"""

from collections.abc import Mapping
from itertools import pairwise

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import BodySettings, SimulatedCamerasSettings
from messaging.frames import CameraCalibration
from sensing.refined.method import Refined
from sensing.scene import Scene
from sensing.shape import Shape

SECTION_MM = 40.0
LENGTH_MM = 80.0
STEP_MM = 1.0


def _turn(angle_rad, heading_rad):
    """The rotation that bends +Z by an angle towards a heading."""
    return cv2.Rodrigues(angle_rad * np.array([-np.sin(heading_rad), np.cos(heading_rad), 0.0]))[0]


def _section(angle_rad, heading_rad):
    """A circular arc (41, 3) from the origin along +Z, and the frame (3, 3) at its end."""
    angles = angle_rad * np.linspace(0.0, 1.0, 41)
    aside = np.array([(1 - np.cos(a)) / angle_rad if angle_rad else 0.0 for a in angles])
    up = np.array(
        [
            np.sin(a) / angle_rad if angle_rad else s
            for a, s in zip(angles, np.linspace(0, 1, 41), strict=True)
        ]
    )
    points = np.column_stack([aside * np.cos(heading_rad), aside * np.sin(heading_rad), up])
    return SECTION_MM * points, _turn(angle_rad, heading_rad)


def _arcs(first_rad=0.0, first_heading_rad=0.0, second_rad=0.0, second_heading_rad=0.0, insertion_mm=0.0):
    """Two circular arcs of 40 mm one after the other: points (81, 3) in mm, one for each mm of arc length."""
    lower, frame = _section(first_rad, first_heading_rad)
    upper, _ = _section(second_rad, second_heading_rad)
    above = lower[-1] + upper[1:] @ frame.T
    return np.concatenate([lower, above]) + np.array([0.0, 0.0, insertion_mm])


@pytest.fixture(scope="session")
def arcs():
    return _arcs


def _project(calibration, points_mm):
    pose = calibration.camera_from_robot
    rotation = cv2.Rodrigues(pose[:3, :3])[0]
    points = np.asarray(points_mm, dtype=np.float64).reshape(-1, 3)
    return cv2.projectPoints(points, rotation, pose[:3, 3], calibration.intrinsics, calibration.distortion)[
        0
    ][:, 0]


def _smaller(calibration, factor):
    """The same camera with a sensor of fewer, larger pixels; integer coordinates stay pixel centres."""
    intrinsics = calibration.intrinsics.copy()
    intrinsics[:2] /= factor
    intrinsics[:2, 2] += 0.5 / factor - 0.5
    return CameraCalibration(
        camera=calibration.camera,
        width_px=calibration.width_px // factor,
        height_px=calibration.height_px // factor,
        intrinsics=intrinsics,
        distortion=calibration.distortion,
        camera_from_robot=calibration.camera_from_robot,
    )


def _from_above(calibration):
    """A third camera, from between the two and 60 mm higher, looking at the same place."""
    position = np.array([0.0, -190.0, 118.0])
    forward = np.array([0.0, 0.0, 30.0]) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = -pose[:3, :3] @ position
    return CameraCalibration(
        camera="above",
        width_px=calibration.width_px,
        height_px=calibration.height_px,
        intrinsics=calibration.intrinsics,
        distortion=calibration.distortion,
        camera_from_robot=pose,
    )


class Bench:
    """Simulated cameras and what they see. Every picture of the same pose is different: noise goes on."""

    def __init__(self, rig, body=None):
        self.rig = rig
        settings = SimulatedCamerasSettings(body=body or BodySettings())
        self._renderers = {
            camera.camera: Renderer(camera, np.array([SECTION_MM, LENGTH_MM]), settings, seed)
            for seed, camera in enumerate(rig)
        }

    def photograph(self, points_mm):
        """JPEG bytes by camera of the robot along points (81, 3)."""
        return {name: renderer.render(points_mm, points_mm) for name, renderer in self._renderers.items()}

    def scene(self, backgrounds: Mapping[str, bytes] | None = None, length_mm: float | None = LENGTH_MM):
        """A scene of these cameras."""
        return Scene.of(self.rig, backgrounds=backgrounds, length_mm=length_mm)


def encoded(picture, kind=".jpg"):
    """Coded bytes of a picture with levels 0 to 255."""
    return cv2.imencode(kind, np.clip(picture, 0, 255).round().astype(np.uint8))[1].tobytes()


def decoded(data):
    """BGR picture of coded bytes."""
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)


@pytest.fixture(scope="session")
def encode():
    return encoded


@pytest.fixture(scope="session")
def decode():
    return decoded


@pytest.fixture(scope="session")
def project():
    return _project


@pytest.fixture(scope="session")
def rig():
    return default_cameras()


@pytest.fixture(scope="session")
def bench(rig):
    """The reference bench: two cameras, 1920x1080."""
    return Bench(rig)


@pytest.fixture(scope="session")
def small_bench(rig):
    """The reference bench at 960x540, for what takes many pictures and no tenths of a pixel."""
    return Bench(tuple(_smaller(camera, 2) for camera in rig))


@pytest.fixture(scope="session")
def without_robot(small_bench):
    """What the small bench's cameras see of the holder alone, by camera: the robot is a speck on its top."""
    body = BodySettings(diameter_mm=(0.01, 0.01), disk_spacing_mm=1000.0, disk_proud_mm=0.0)
    return Bench(small_bench.rig, body).photograph(1e-2 * _arcs())


@pytest.fixture(scope="session")
def third_camera(rig):
    """A bench of one more camera, which looks from above."""
    return Bench((_from_above(rig[0]),))


@pytest.fixture(scope="session")
def look():
    """Estimate from coded pictures by camera."""

    def _look(
        scene: Scene, pictures: Mapping[str, bytes], last: Shape | None = None, insertion_mm: float = 0.0
    ) -> Shape:
        decoded_late = {name: scene.picture(name, data) for name, data in pictures.items()}
        ticks = iter(range(1000))
        before = None if last is None else last.track
        return Refined(scene).estimate(decoded_late, insertion_mm, before, lambda: float(next(ticks)))

    return _look


@pytest.fixture(scope="session")
def painted():
    """Silhouettes of a dark tube before a plain backdrop, by projecting its surface: no shading, no disks, any tip."""
    return _painted


FINER = 4
BACKDROP = np.array([82.0, 150.0, 64.0])
ROBOT = np.array([70.0, 64.0, 66.0])


def _painted(calibration, points_mm, radius_mm, tip):
    """JPEG of a tube of one radius, with a `flat` or `round` tip, whose centreline (n, 3) begins in a dark holder."""
    rings = _rings(points_mm, radius_mm, tip)
    pixels = _project(calibration, rings).reshape(len(rings), -1, 2)
    size = calibration.height_px * FINER, calibration.width_px * FINER
    cover = np.zeros(size, np.uint8)
    for lower, upper in pairwise(pixels):
        # (u + 0.5) * FINER - 0.5: the finer grid's integer coordinates are pixel centres too
        hull = cv2.convexHull(((np.vstack([lower, upper]) + 0.5) * FINER - 0.5).astype(np.float32))
        cv2.fillConvexPoly(cover, np.rint(hull * 64).astype(np.int32), 255, cv2.LINE_AA, shift=6)
    holder = points_mm[0] + np.array([[-8, 0, 0], [8, 0, 0], [8, 0, -60], [-8, 0, -60]])
    corners = (_project(calibration, holder) + 0.5) * FINER - 0.5
    cv2.fillConvexPoly(cover, np.rint(corners).astype(np.int32), 255)
    share = cv2.resize(cover, None, fx=1 / FINER, fy=1 / FINER, interpolation=cv2.INTER_AREA) / 255.0
    share = cv2.GaussianBlur(share, (0, 0), 0.7)[..., None]
    light = share * _to_light(ROBOT) + (1 - share) * _to_light(BACKDROP)
    noise = np.random.default_rng(3).normal(0, 1.0, light.shape)
    return encoded(_to_levels(light) + noise)


def _rings(points_mm, radius_mm, tip):
    """Points (n, 32, 3) on the tube's surface, ring by ring; a round tip's rings narrow to the centreline's end."""
    tangents = np.gradient(points_mm, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    tangents[-1] = 2 * tangents[-1] - tangents[-2]
    first = np.cross(tangents, [0.31, 0.9, 0.11])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    turn = np.linspace(0, 2 * np.pi, 32, endpoint=False)[:, None]
    around = np.cos(turn) * first[:, None] + np.sin(turn) * np.cross(tangents, first)[:, None]
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points_mm, axis=0), axis=1))])
    before_end = arc[-1] - arc
    narrow = np.sqrt(np.clip(radius_mm**2 - np.clip(radius_mm - before_end, 0, None) ** 2, 0, None))
    radii = narrow if tip == "round" else np.full(len(arc), radius_mm)
    return points_mm[:, None] + radii[:, None, None] * around


def _to_light(levels):
    code = np.asarray(levels) / 255.0
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def _to_levels(light):
    light = np.clip(light, 0, 1)
    return 255.0 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


@pytest.fixture(scope="session")
def to_levels():
    return _to_levels


@pytest.fixture(scope="session")
def to_light():
    return _to_light
