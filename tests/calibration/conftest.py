"""Two known cameras and boards before them: exact corners with noise, and rendered pictures.

Nothing here uses the room's own geometry: projection is OpenCV's, and pictures are made by following rays back to the board.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import pytest

from calibration.board import Board
from calibration.corners import Corners
from calibration.views import View
from messaging.board import BoardSettings

LENS = (0.07, -0.15, 0.0006, -0.0009, 0.025)
FINER = 4
PX_PER_SQUARE = 200
MARGIN_SQUARES = 0.5
PAPER, INK, BACKDROP = 215.0, 35.0, 110.0


@dataclass(frozen=True)
class KnownCamera:
    """`camera_from_rig` (4, 4), mm; `size` is (width, height)."""

    K: np.ndarray
    distortion: np.ndarray
    camera_from_rig: np.ndarray
    size: tuple[int, int]

    def project(self, points_mm):
        """Pixels (n, 2) of points (n, 3) in the rig frame."""
        pose = self.camera_from_rig
        px, _ = cv2.projectPoints(
            points_mm, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], self.K, self.distortion
        )
        return px.reshape(-1, 2)


def pose_of(turn_rad, place_mm):
    """(4, 4)"""
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(np.asarray(turn_rad, float))[0]
    pose[:3, 3] = place_mm
    return pose


def moved(pose, points_mm):
    return points_mm @ pose[:3, :3].T + pose[:3, 3]


def camera(width=1920, height=1080, angle_deg=0.0, lens=LENS, focal=0.75, cameras_apart_mm=200.0):
    """One that looks at a point `cameras_apart_mm` before the first one, turned about it by an angle."""
    turn = pose_of([0, -np.radians(angle_deg), 0], [0, 0, 0])
    to_middle = pose_of([0, 0, 0], [0, 0, -cameras_apart_mm])
    K = np.array([[focal * width, 0, 0.507 * width], [0, focal * width + 1.5, 0.49 * height], [0, 0, 1.0]])
    return KnownCamera(K, np.array(lens), np.linalg.inv(to_middle) @ turn @ to_middle, (width, height))


class KnownBench:
    """Cameras by name, a board, and seeded noise."""

    def __init__(self, cameras, settings=None, seed=0):
        self.cameras = cameras
        self.board = Board(settings or BoardSettings())
        self.random = np.random.default_rng(seed)

    @property
    def sizes(self):
        return {name: camera.size for name, camera in self.cameras.items()}

    def poses(self, count, tilt_deg=35.0, spread=0.25) -> Iterator[np.ndarray]:
        """`rig_from_board` of boards that face between the cameras, tilted and moved at random."""
        middle_mm = self.board.points_mm.mean(axis=0)
        facing = np.mean([np.linalg.inv(one.camera_from_rig)[:3, 3] for one in self.cameras.values()], axis=0)
        towards = np.arctan2(facing[0], 200.0 - facing[2])
        for _ in range(count):
            about = self.random.uniform(0, 2 * np.pi)
            tilt = np.radians(tilt_deg) * np.sqrt(self.random.uniform(0.1, 1))
            pose = pose_of([0, -towards, 0], [0, 0, 0]) @ pose_of(
                [tilt * np.cos(about), tilt * np.sin(about), 0], [0, 0, 0]
            )
            pose = pose @ pose_of([0, 0, self.random.uniform(-0.5, 0.5)], [0, 0, 0])
            away_mm = 200.0 * self.random.uniform(0.85, 1.2)
            place_mm = [*(self.random.uniform(-spread, spread, 2) * [200, 110]), away_mm]
            pose[:3, 3] = place_mm - pose[:3, :3] @ middle_mm
            yield pose

    def true_px(self, name, rig_from_board, ids=slice(None)):
        return self.cameras[name].project(moved(rig_from_board, self.board.points_mm[ids]))

    def view(self, name, rig_from_board, noise_px=0.05, only=None) -> View:
        """Corners as exact as the noise, those that lie in the picture; `only` names the cameras that see the board."""
        corners = {}
        for camera_name, one in self.cameras.items():
            if only is not None and camera_name not in only:
                continue
            px = self.true_px(camera_name, rig_from_board)
            inside = ((px > 2) & (px < np.array(one.size) - 3)).all(axis=1)
            px = px + self.random.normal(0, noise_px, px.shape)
            if np.count_nonzero(inside) >= 8:
                ids = np.flatnonzero(inside)
                corners[camera_name] = Corners(ids, px[inside], np.full(len(ids), 0.7))
        return View(name, corners, sizes=self.sizes)

    def views(self, count, noise_px=0.05, **poses) -> list[View]:
        return [
            self.view(f"{number:02d}", pose, noise_px)
            for number, pose in enumerate(self.poses(count, **poses))
        ]


def sheet(settings):
    """The printed board (grey), PX_PER_SQUARE px a square, with a white margin."""
    columns, rows = settings.squares
    if settings.kind == "chessboard":
        squares = np.kron((np.indices((rows, columns)).sum(axis=0) % 2) * 255, np.ones((PX_PER_SQUARE,) * 2))
    else:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, settings.dictionary))
        board = cv2.aruco.CharucoBoard(settings.squares, settings.square_mm, settings.marker_mm, dictionary)
        board.setLegacyPattern(settings.legacy_pattern)
        squares = board.generateImage((columns * PX_PER_SQUARE, rows * PX_PER_SQUARE))
    margin = int(MARGIN_SQUARES * PX_PER_SQUARE)
    return np.pad(squares.astype(np.uint8), margin, constant_values=255)


@cache
def printed(settings):
    return sheet(settings)


def rendered(known: KnownCamera, settings, rig_from_board, blur_px=0.5, noise_levels=2.0, seed=0):
    """The picture (height, width) of the board: FINER x FINER rays a pixel, followed back through the lens to the paper."""
    width, height = known.size
    px = np.stack(np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float)), axis=-1)
    rays = cv2.undistortPoints(px.reshape(-1, 1, 2), known.K, known.distortion).reshape(height, width, 2)
    by_y, by_x = np.gradient(rays, axis=(0, 1))
    pose = known.camera_from_rig @ rig_from_board
    board_from_ray = np.linalg.inv(np.column_stack([pose[:3, 0], pose[:3, 1], pose[:3, 3]]))
    paper = INK + (PAPER - INK) / 255 * printed(settings)
    picture = np.zeros((height, width))
    offsets = (np.arange(FINER) + 0.5) / FINER - 0.5
    for across, down in itertools.product(offsets, offsets):
        ahead = (rays + across * by_x + down * by_y) @ board_from_ray[:, :2].T + board_from_ray[:, 2]
        squares = ahead[..., :2] / ahead[..., 2:] / settings.square_mm + MARGIN_SQUARES
        cells = (squares * PX_PER_SQUARE - 0.5).astype(np.float32)
        picture += cv2.remap(
            paper.astype(np.float32),
            cells,
            None,
            cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=BACKDROP,
        )
    picture /= FINER**2
    if blur_px:
        picture = cv2.GaussianBlur(picture, (0, 0), blur_px)
    noise = np.random.default_rng(seed).normal(0, noise_levels, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


@pytest.fixture
def known_bench() -> Callable[..., KnownBench]:
    """Two cameras as far apart as on the reference bench, or those that are given."""

    def build(settings=None, seed=0, cameras=None):
        pair = {"left": camera(), "right": camera(angle_deg=55.0, focal=0.752)}
        return KnownBench(cameras or pair, settings, seed)

    return build


@pytest.fixture
def known_camera() -> Callable[..., KnownCamera]:
    return camera


@pytest.fixture
def small_camera() -> KnownCamera:
    """Quick to render."""
    return camera(width=960, height=540)


@pytest.fixture
def render() -> Callable[..., np.ndarray]:
    return rendered


@pytest.fixture
def held() -> Callable[..., np.ndarray]:
    """`rig_from_board` of a board before the first camera, with its middle on the axis or beside it."""

    def pose(settings, turn_rad=(0.3, -0.4, 0.1), middle_mm=(3.0, -2.0, 190.0)):
        result = pose_of(turn_rad, [0, 0, 0])
        columns, rows = settings.squares
        half = settings.square_mm / 2 * np.array([columns, rows, 0])
        result[:3, 3] = np.array(middle_mm) - result[:3, :3] @ half
        return result

    return pose
