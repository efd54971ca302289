"""Boards in rendered pictures: exact corners, and the reason whenever there are none."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.board import Board
from calibration.corners import Corners, Missing
from calibration.errors import BoardError
from calibration.saddles import refine
from messaging.board import BoardSettings

CHARUCO = BoardSettings()
CHESSBOARD = BoardSettings(kind="chessboard", squares=(9, 6))


def true_px(camera, board, rig_from_board, ids):
    points_mm = board.points_mm[ids] @ rig_from_board[:3, :3].T + rig_from_board[:3, 3]
    return camera.project(points_mm)


def stuck_on(marker):
    """84 x 84 px"""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    printed = np.pad(cv2.aruco.generateImageMarker(dictionary, marker, 60), 12, constant_values=255)
    return (30 + 0.7 * printed).astype(np.uint8)


@pytest.mark.parametrize("printed", [CHARUCO, CHESSBOARD], ids=["charuco", "chessboard"])
def test_corners_lie_where_they_are_in_pixel_centre_coordinates(small_camera, render, held, printed):
    board, pose = Board(printed), held(printed)
    found = board.find(render(small_camera, printed, pose))
    off_px = found.px - true_px(small_camera, board, pose, found.ids)
    assert len(found) == len(board.points_mm)
    assert np.sqrt(np.mean(off_px**2)) < 0.03
    assert np.abs(off_px.mean(axis=0)).max() < 0.01


def test_corners_are_exact_where_the_squares_are_small(known_camera, render, held):
    camera, board = known_camera(640, 360), Board(CHARUCO)
    pose = held(CHARUCO, middle_mm=(3, -2, 250))
    found = board.find(render(camera, CHARUCO, pose))
    assert len(found) > 40
    assert np.abs(found.px - true_px(camera, board, pose, found.ids)).max() < 0.2


def test_a_part_of_the_board_is_enough(small_camera, render, held):
    board, pose = Board(CHARUCO), held(CHARUCO)
    picture = render(small_camera, CHARUCO, pose)
    picture[:, : small_camera.size[0] // 2] = 110
    found = board.find(picture)
    assert 8 <= len(found) < len(board.points_mm)
    assert np.abs(found.px - true_px(small_camera, board, pose, found.ids)).max() < 0.25


def test_colour_pictures_are_as_good_as_grey_ones(small_camera, render, held):
    grey = render(small_camera, CHARUCO, held(CHARUCO))
    board = Board(CHARUCO)
    np.testing.assert_allclose(
        board.find(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)).px, board.find(grey).px, atol=0.01
    )


def test_the_blur_of_a_picture_is_measured(small_camera, render, held):
    board, pose = Board(CHARUCO), held(CHARUCO)
    sharp, blurred = (
        float(np.median(board.find(render(small_camera, CHARUCO, pose, blur_px=blur_px)).blur_px))
        for blur_px in (0.5, 1.5)
    )
    assert sharp == pytest.approx(0.5, abs=0.15)
    assert blurred == pytest.approx(1.5, abs=0.25)


@pytest.mark.parametrize("quarter_turns", [0, 1, 2])
def test_a_chessboard_is_numbered_from_the_same_corner_however_it_is_turned(
    small_camera, render, held, quarter_turns
):
    board = Board(CHESSBOARD)
    pose = held(CHESSBOARD, turn_rad=(0, 0, quarter_turns * np.pi / 2), middle_mm=(0, 0, 250))
    found = board.find(render(small_camera, CHESSBOARD, pose))
    assert np.abs(found.px - true_px(small_camera, board, pose, found.ids)).max() < 0.2


@pytest.mark.parametrize(
    ("shown", "reason"),
    [
        (
            BoardSettings(squares=(10, 8)),
            "another layout: the markers do not lie as on a board of 9 x 7 squares",
        ),
        (
            BoardSettings(squares=(8, 6)),
            "another layout: the markers do not lie as on a board of 9 x 7 squares",
        ),
        (BoardSettings(squares=(7, 9)), "another layout: the markers do not lie"),
        (BoardSettings(marker_mm=5), "another layout: markers are 0.4"),
        (BoardSettings(dictionary="DICT_6X6_50"), "no marker of DICT_4X4_50 is in sight"),
        (CHESSBOARD, "no marker of DICT_4X4_50 is in sight"),
    ],
    ids=["more squares", "fewer squares", "turned", "markers of another size", "dictionary", "chessboard"],
)
def test_another_board_is_named_as_what_it_is(small_camera, render, held, shown, reason):
    found = Board(CHARUCO).find(render(small_camera, shown, held(shown)))
    assert isinstance(found, Missing)
    assert reason in found.reason


@pytest.mark.parametrize("marker", [40, 3], ids=["foreign", "like one of its own"])
def test_one_marker_more_in_the_picture_does_no_harm(small_camera, render, held, marker):
    board, pose = Board(CHARUCO), held(CHARUCO)
    picture = render(small_camera, CHARUCO, pose)
    alone = board.find(picture)
    picture[10:94, 800:884] = stuck_on(marker)
    found = board.find(picture)
    assert found.ids.tolist() == alone.ids.tolist()
    np.testing.assert_allclose(found.px, alone.px, atol=1e-3)


def test_markers_of_another_board_are_named_when_they_are_the_more(small_camera):
    picture = np.full((540, 960), 110, np.uint8)
    for number, marker in enumerate((3, 40, 44)):
        picture[200:284, 100 + 200 * number : 184 + 200 * number] = stuck_on(marker)
    assert "markers of another board: id 40, 44" in Board(CHARUCO).find(picture).reason


def test_too_few_corners_are_no_view(small_camera, render, held):
    picture = render(small_camera, CHARUCO, held(CHARUCO))
    picture[:, 395:] = 110
    found = Board(CHARUCO).find(picture)
    assert isinstance(found, Missing)
    assert "8 are needed" in found.reason or "hardly a corner" in found.reason


def test_a_chessboard_that_is_partly_hidden_is_no_view(small_camera, render, held):
    picture = render(small_camera, CHESSBOARD, held(CHESSBOARD))
    picture[:, 480:] = 110
    assert "8 x 5 inner corners" in Board(CHESSBOARD).find(picture).reason


@pytest.mark.parametrize(
    ("impossible", "reason"),
    [
        ({"dictionary": "DICT_9X9_50"}, "DICT_9X9_50 is unknown; known are DICT_4X4_100"),
        ({"squares": (12, 10)}, "has 50 markers, a board of 12 x 10 squares needs 60"),
        ({"kind": "chessboard", "squares": (9, 7)}, "looks the same upside down"),
    ],
)
def test_impossible_boards_are_refused(impossible, reason):
    with pytest.raises(BoardError, match=reason):
        Board(BoardSettings(**impossible))


@settings(max_examples=15, deadline=None)
@given(
    st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)),
    st.floats(0, np.pi),
    st.floats(np.radians(50), np.radians(130)),
    st.floats(0.5, 2.0),
)
def test_a_crossing_is_found_wherever_its_edges_run(place, turn, between, blur_px):
    middle = np.array([20.0, 20.0]) + place
    directions = np.array([[np.cos(a), np.sin(a)] for a in (turn, turn + between)])
    finer = 20
    fine = (np.arange(41 * finer) + 0.5) / finer - 0.5
    x, y = np.meshgrid(fine, fine)
    away = [(x - middle[0]) * -d[1] + (y - middle[1]) * d[0] for d in directions]
    exact = np.where(away[0] * away[1] > 0, np.float32(200), np.float32(40))
    blurred = cv2.GaussianBlur(exact, (0, 0), blur_px * finer)
    picture = np.rint(blurred.reshape(41, finer, 41, finer).mean(axis=(1, 3))).astype(np.uint8)
    fitted = refine(picture, np.array([[20.0, 20.0]]), 40 * directions[None], 0.4, 0.1)
    assert fitted.sound.all()
    np.testing.assert_allclose(fitted.px[0], middle, atol=0.05)


def test_where_nothing_crosses_no_crossing_is_sound():
    flat = np.full((81, 81), 128, np.uint8)
    edge = flat.copy()
    edge[:, 40:] = 30
    for picture in (flat, edge):
        fitted = refine(picture, np.array([[40.0, 40.0]]), 60 * np.eye(2)[None], 0.4, 0.1)
        assert not fitted.sound.any()


def test_corners_can_be_chosen():
    corners = Corners(np.arange(3), np.arange(6.0).reshape(3, 2), np.ones(3))
    assert corners.only(np.array([True, False, True])).ids.tolist() == [0, 2]
