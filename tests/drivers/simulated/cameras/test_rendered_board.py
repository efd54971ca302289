"""Boards as the simulated cameras see them, against OpenCV's projection of their corners."""

import itertools

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.errors import SimulatedBoardError
from drivers.simulated.cameras.printed_board import printed_board
from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from messaging.board import BoardPlace, BoardSettings

CAMERAS = {camera.camera: camera for camera in default_cameras()}
SETTINGS = SimulatedCamerasSettings()
ENDS_MM = np.array([40.0, 80.0])
BASE_MM = np.zeros(3)
BOARD = BoardSettings()
AT_BASE = BoardPlace(origin_mm=(-45, 0, 77), x_axis=(1, 0, 0), y_axis=(0, 0, -1)).robot_from_board
CHARUCO = cv2.aruco.CharucoBoard(
    BOARD.squares,
    BOARD.square_mm,
    BOARD.marker_mm,
    cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50),
)


@pytest.fixture(scope="module")
def renderers():
    return {
        name: Renderer(camera, ENDS_MM, SETTINGS, seed=1, board=BOARD) for name, camera in CAMERAS.items()
    }


def turned(rotation_rad, shift_mm=(0, 0, 0)):
    """The board at the base, turned about its middle and moved."""
    pose, middle_mm = AT_BASE.copy(), np.array([45.0, 35.0, 0.0])
    turn, _ = cv2.Rodrigues(np.array(rotation_rad, dtype=float))
    pose[:3, 3] += pose[:3, :3] @ (middle_mm - turn @ middle_mm) + shift_mm
    pose[:3, :3] = pose[:3, :3] @ turn
    return pose


def decoded(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)


def projected(camera, robot_from_board, points_mm):
    camera_from_board = camera.camera_from_robot @ robot_from_board
    turn, _ = cv2.Rodrigues(camera_from_board[:3, :3])
    pixels, _ = cv2.projectPoints(
        points_mm, turn, camera_from_board[:3, 3], camera.intrinsics, camera.distortion
    )
    return pixels[:, 0]


def test_corners_lie_where_they_project(renderers):
    poses = (
        AT_BASE,
        turned((0.4, 0.1, -0.3)),
        turned((-0.3, 0.3, 0.2), (10, -20, 15)),
        turned((0.1, -0.4, 0.5), (-15, 10, -5)),
    )
    errors = []
    for (name, camera), pose in itertools.product(CAMERAS.items(), poses):
        picture = decoded(renderers[name].render_board(BASE_MM, pose, pose))
        corners, ids, _, _ = cv2.aruco.CharucoDetector(CHARUCO).detectBoard(picture)
        assert len(ids) == 48
        expected = projected(camera, pose, CHARUCO.getChessboardCorners()[ids.ravel()])
        errors.append(corners.reshape(-1, 2) - expected)
    errors = np.concatenate(errors)
    assert np.abs(errors.mean(axis=0)).max() < 0.02
    assert np.sqrt((errors**2).mean()) < 0.1


def test_paper_and_ink_are_neither_white_nor_black_and_darken_with_the_tilt(renderers):
    levels = {}
    for name, pose in (("up", turned((0.6, 0, 0))), ("down", turned((-0.6, 0, 0)))):
        picture = decoded(renderers["left"].render_board(BASE_MM, pose, pose))
        paper = projected(CAMERAS["left"], pose, np.array([[15.0, 0.7, 0.0], [75.0, 69.3, 0.0]]))
        ink = projected(CAMERAS["left"], pose, np.array([[5.0, 5.0, 0.0], [85.0, 65.0, 0.0]]))
        levels[name] = [
            np.mean([picture[round(v), round(u)] for u, v in places.tolist()]) for places in (paper, ink)
        ]
    for paper, ink in levels.values():
        assert 3 < ink < 40
        assert 80 < paper < 250
    assert abs(levels["up"][0] - levels["down"][0]) > 40


def test_a_held_board_differs_between_pictures_by_noise_alone(renderers):
    pose = turned((0.1, 0.2, 0.3))
    first, second = (decoded(renderers["right"].render_board(BASE_MM, pose, pose)) for _ in range(2))
    differing = first.astype(float) - second
    assert 0.5 < differing.std() < 5
    assert np.abs(cv2.blur(differing, (25, 25))).max() < 3


def test_a_moving_board_is_blurred_along_its_way(renderers):
    still, moved = turned((0, 0, 0)), turned((0, 0, 0), (3, 0, 0))
    sharp = decoded(renderers["left"].render_board(BASE_MM, still, still))
    blurred = decoded(renderers["left"].render_board(BASE_MM, still, moved))
    edges = [cv2.Sobel(picture[:, :, 1], cv2.CV_32F, 1, 0).max() for picture in (sharp, blurred)]
    assert edges[1] < 0.6 * edges[0]


def test_the_empty_holder_shows_no_robot(renderers):
    empty = decoded(renderers["left"].render_empty(BASE_MM)).astype(float)
    straight_mm = np.column_stack([np.zeros(81), np.zeros(81), np.linspace(0, 80, 81)])
    robot = decoded(renderers["left"].render(straight_mm, straight_mm)).astype(float)
    backdrop = np.array([82.0, 150.0, 64.0])
    u, v = projected(CAMERAS["left"], np.eye(4), np.array([[0.0, 0.0, 50.0]]))[0].round().astype(int)
    assert np.linalg.norm(robot[v, u] - backdrop) > 40
    assert np.linalg.norm(empty[v - 2 : v + 3, u - 2 : u + 3].mean(axis=(0, 1)) - backdrop) < 20
    u, v = projected(CAMERAS["left"], np.eye(4), np.array([[0.0, 0.0, -25.0]]))[0].round().astype(int)
    np.testing.assert_allclose(empty[v, u], robot[v, u], atol=15)


def test_the_back_of_the_board_is_plain_paper_and_one_behind_the_camera_is_not_seen(renderers):
    back = turned((0, np.pi, 0))
    behind = turned((0, 0, 0), (0, -400, 0))
    picture = decoded(renderers["left"].render_board(BASE_MM, back, back))
    corners = projected(CAMERAS["left"], back, np.array([[2.0, 2, 0], [88, 2, 0], [88, 68, 0], [2, 68, 0]]))
    inside = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillConvexPoly(inside, corners.round().astype(np.int32), 1)
    assert picture[inside == 1].std() < 12
    empty = decoded(renderers["left"].render_empty(BASE_MM)).astype(float)
    unseen = decoded(renderers["left"].render_board(BASE_MM, behind, behind))
    assert np.abs(cv2.blur(unseen - empty, (25, 25))).max() < 3


def test_a_chessboard_begins_with_a_black_square():
    board = printed_board(BoardSettings(kind="chessboard", squares=(6, 5), square_mm=20.0))
    column, row, _ = (board.pixels_from_board @ [10.0, 10.0, 1.0]).round().astype(int)
    beside, _, _ = (board.pixels_from_board @ [30.0, 10.0, 1.0]).round().astype(int)
    assert board.levels[row, column] < 50
    assert board.levels[row, beside] > 150


@pytest.mark.parametrize(
    ("board", "reason"),
    [
        (BoardSettings(dictionary="DICT_9X9_7"), "OpenCV does not know it"),
        (BoardSettings(squares=(12, 10)), "need 60 markers; DICT_4X4_50 has 50"),
    ],
)
def test_a_board_that_cannot_be_drawn_is_refused(board, reason):
    with pytest.raises(SimulatedBoardError, match=reason):
        printed_board(board)
