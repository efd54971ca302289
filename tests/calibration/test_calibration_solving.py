"""Known cameras, boards at random poses, noisy corners: what is found, how well it knows itself, what is refused."""

import re

import cv2
import msgspec
import numpy as np
import pytest

from calibration import solving
from calibration.base_board import base_from_board
from calibration.corners import Corners
from calibration.errors import ViewsError
from calibration.solving import calibrate
from calibration.views import View

NOISE_PX = 0.05
PINHOLE = {"fx_px": (0, 0), "fy_px": (1, 1), "cx_px": (0, 2), "cy_px": (1, 2)}


def sigmas_off(found, known):
    """Errors of a camera's intrinsics and place in standard deviations."""
    K = np.array(found.intrinsics)
    off = [(K[at] - known.K[at]) / found.sigma[name] for name, at in PINHOLE.items()]
    for name, value, exact in zip(
        ("k1", "k2", "p1", "p2", "k3"), found.distortion, known.distortion, strict=True
    ):
        off.append((value - exact) / found.sigma[name])
    if "x_mm" in found.sigma:
        pose = np.array(found.camera_from_rig)
        for row, name in enumerate(("x_mm", "y_mm", "z_mm")):
            off.append((pose[row, 3] - known.camera_from_rig[row, 3]) / found.sigma[name])
    return np.array(off)


def without(view, camera):
    corners = {name: one for name, one in view.corners.items() if name != camera}
    return View(view.name, corners, {camera: "no marker of DICT_4X4_50 is in sight"}, view.sizes)


@pytest.fixture(scope="module")
def solved():
    """Made once by the first test that asks, with what it was made from."""
    return {}


@pytest.fixture
def two_cameras(known_bench, solved):
    if not solved:
        bench = known_bench(seed=1)
        solved["bench"], solved["calibration"] = bench, calibrate(bench.board, bench.views(25), bench.sizes)
    return solved["bench"], solved["calibration"]


def test_two_cameras_are_found_within_what_they_say_of_themselves(two_cameras):
    bench, found = two_cameras
    for camera in found.cameras.cameras:
        off = sigmas_off(camera, bench.cameras[camera.name])
        assert np.abs(off).max() < 4
        assert camera.rms_px == pytest.approx(NOISE_PX, rel=0.1)
        assert camera.sigma["fx_px"] < 1
    assert np.array_equal(found.cameras.cameras[0].camera_from_rig, np.eye(4))
    assert "x_mm" not in found.cameras.cameras[0].sigma


def test_held_out_views_are_predicted_about_as_well_as_corners_are_found(two_cameras):
    _, found = two_cameras
    for camera in found.cameras.cameras:
        assert camera.rms_px < camera.held_out_rms_px < 3 * NOISE_PX


def test_the_boards_own_squares_are_measured_in_held_out_views(two_cameras):
    _, found = two_cameras
    check = found.cameras.board_check
    assert check.squares > 500
    assert abs(check.mean_error_mm) < 0.001
    assert 0.002 < check.rms_error_mm < 0.02
    assert 0.002 < check.surface_error_mm < 0.02


def test_parameters_name_their_covariance(two_cameras):
    _, found = two_cameras
    sigma = dict(zip(found.parameters, np.sqrt(np.diag(found.covariance)), strict=True))
    for camera in found.cameras.cameras:
        for name, value in camera.sigma.items():
            assert sigma[f"{camera.name}.{name}"] == pytest.approx(value)
    assert len(sigma) == 9 + 15 + 5


def test_residuals_and_poses_are_told_by_view(two_cameras):
    bench, found = two_cameras
    camera = np.array(found.cameras.cameras[1].camera_from_rig)
    one = next(one for one in found.sightings if one.camera == "right")
    pose = camera @ found.rig_from_board[one.view]
    points_mm = bench.board.points_mm[one.corners.ids]
    K, distortion = (
        np.array(getattr(found.cameras.cameras[1], name)) for name in ("intrinsics", "distortion")
    )
    px, _ = cv2.projectPoints(points_mm, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], K, distortion)
    np.testing.assert_allclose(one.corners.px - one.residual_px, px.reshape(-1, 2), atol=0.02)
    assert one.rms_px == pytest.approx(NOISE_PX, rel=0.5)


def test_one_camera_alone(known_bench, known_camera):
    bench = known_bench(cameras={"only": known_camera()})
    found = calibrate(bench.board, bench.views(15, spread=0.15), bench.sizes).cameras
    assert np.abs(sigmas_off(found.cameras[0], bench.cameras["only"])).max() < 4
    assert found.cameras[0].held_out_rms_px < 3 * NOISE_PX
    assert found.board_check is None


def test_cameras_are_chained_through_views_that_neighbours_share(known_bench, known_camera):
    angles = {"a": 0.0, "b": 40.0, "c": 80.0}
    bench = known_bench(cameras={name: known_camera(angle_deg=angle) for name, angle in angles.items()})
    views = bench.views(18)
    views = [without(view, "c" if number % 2 else "a") for number, view in enumerate(views)]
    found = calibrate(bench.board, views, bench.sizes).cameras
    for camera in found.cameras:
        assert np.abs(sigmas_off(camera, bench.cameras[camera.name])).max() < 4


def test_cameras_that_share_no_view_are_refused_by_name(known_bench):
    bench = known_bench()
    views = [without(view, ("left", "right")[n % 2]) for n, view in enumerate(bench.views(20))]
    with pytest.raises(ViewsError, match="no view shows the board to left and to right at once"):
        calibrate(bench.board, views, bench.sizes)


def test_cameras_that_are_not_asked_for_do_not_count(known_bench):
    bench = known_bench()
    alone = {"right": bench.sizes["right"]}
    views = [*bench.views(12), without(bench.view("left alone", next(bench.poses(1))), "right")]
    found = calibrate(bench.board, views, alone).cameras
    assert [camera.name for camera in found.cameras] == ["right"]
    assert found.views_rejected == {"left alone": "right: no marker of DICT_4X4_50 is in sight"}


def test_too_few_views_are_refused(known_bench):
    bench = known_bench()
    with pytest.raises(ViewsError, match="camera left sees the board in 2 views that differ; at least 3"):
        calibrate(bench.board, bench.views(2), bench.sizes)
    with pytest.raises(ViewsError, match="no views of the board at all"):
        calibrate(bench.board, [], bench.sizes)


@pytest.mark.parametrize("turn_rad", [(0, 0, 0), (0.02, -0.02, 0)], ids=["fronto-parallel", "hardly tilted"])
def test_views_of_one_tilt_leave_the_focal_length_open(known_bench, known_camera, turn_rad):
    bench = known_bench(cameras={"only": known_camera()}, seed=3)
    middle_mm = bench.board.points_mm.mean(axis=0)
    views = []
    for number, pose in enumerate(bench.poses(20, tilt_deg=0, spread=0.1)):
        place_mm = pose[:3, :3] @ middle_mm + pose[:3, 3]
        spun = np.array([0, 0, bench.random.uniform(-0.5, 0.5)])
        pose[:3, :3] = cv2.Rodrigues(np.array(turn_rad, float))[0] @ cv2.Rodrigues(spun)[0]
        pose[:3, 3] = place_mm - pose[:3, :3] @ middle_mm
        views.append(bench.view(f"{number:02d}", pose))
    with pytest.raises(ViewsError, match=r"camera only: the views leave the .* open by .*tilt the board"):
        calibrate(bench.board, views, bench.sizes)


def test_mixed_sizes_are_refused(known_bench):
    bench = known_bench()
    views = bench.views(10)
    views[4] = View("04", views[4].corners, sizes={"left": (1280, 720)})
    with pytest.raises(ViewsError, match="view 04 of camera left is 1280 x 720 px, others are 1920 x 1080"):
        calibrate(bench.board, views, bench.sizes)


def test_the_wrong_board_is_refused_with_what_was_seen(known_bench):
    bench = known_bench()
    missing = dict.fromkeys(bench.cameras, "markers of another board: id 37")
    views = [View(f"{number}", {}, missing, bench.sizes) for number in range(12)]
    with pytest.raises(
        ViewsError, match=r"left has no usable view .* in 12 of 12: markers of another board: id 37"
    ):
        calibrate(bench.board, views, bench.sizes)


def test_a_view_in_which_the_board_moved_between_the_pictures_is_left_away(known_bench):
    bench = known_bench()
    views = bench.views(12)
    shifted = views[5].corners["right"]
    views[5] = View(
        "05",
        {**views[5].corners, "right": Corners(shifted.ids, shifted.px + 6.0, shifted.blur_px)},
        {},
        bench.sizes,
    )
    found = calibrate(bench.board, views, bench.sizes)
    assert list(found.cameras.views_rejected) == ["05"]
    assert "px off where the other views put them" in found.cameras.views_rejected["05"]
    for camera in found.cameras.cameras:
        assert np.abs(sigmas_off(camera, bench.cameras[camera.name])).max() < 4


def test_a_view_with_many_wrong_corners_is_left_away_for_that_reason(known_bench):
    bench = known_bench()
    views = bench.views(12)
    corners = views[5].corners["right"]
    wrong = np.arange(len(corners)) % 5 < 2
    corners.px[wrong] += bench.random.normal(0, 3.0, (np.count_nonzero(wrong), 2))
    (name, reason), *others = calibrate(bench.board, views, bench.sizes).cameras.views_rejected.items()
    assert (name, others) == ("05", [])
    assert re.match(r"right: (19|20) of \d+ corners are", reason)


def test_hundredths_of_a_pixel_are_no_reason_to_leave_a_view_away(known_bench):
    bench = known_bench()
    views = bench.views(12, noise_px=0.004)
    corners = views[5].corners["right"]
    corners.px[:] += bench.random.normal(0, 0.1, corners.px.shape)
    assert calibrate(bench.board, views, bench.sizes).cameras.views_rejected == {}


@pytest.mark.parametrize("spoilt", ["corner", "view"])
def test_what_is_left_after_the_last_weeding_is_solved_for(known_bench, monkeypatch, spoilt):
    monkeypatch.setattr(solving, "WEEDINGS", 1)
    bench = known_bench()
    views = bench.views(12)
    views[3].corners["left"].px[7 if spoilt == "corner" else slice(None)] += 4.0
    found = calibrate(bench.board, views, bench.sizes)
    assert ("03" in found.cameras.views_rejected) == (spoilt == "view")
    assert found.cameras.views_used == len(found.rig_from_board) == 12 - (spoilt == "view")
    for one in found.sightings:
        assert len(one.corners) == len(one.residual_px)
        assert one.rms_px < 2 * NOISE_PX


def test_single_wrong_corners_are_left_away(known_bench):
    bench = known_bench()
    views = bench.views(12)
    views[3].corners["left"].px[7] += 3.0
    found = calibrate(bench.board, views, bench.sizes)
    one = next(one for one in found.sightings if (one.view, one.camera) == ("03", "left"))
    wrong = views[3].corners["left"].ids[7]
    assert wrong not in one.corners.ids
    assert found.cameras.views_rejected == {}


def test_pictures_that_no_camera_explains_are_refused(known_bench):
    bench = known_bench()
    with pytest.raises(ViewsError, match=r"no camera fits the views better than to [5-7]\.\d px"):
        calibrate(bench.board, bench.views(16, noise_px=6.0), bench.sizes)


def test_a_board_that_is_bent_and_printed_askew_is_found_as_it_is_and_harms_nothing(known_bench):
    bench = known_bench()
    flat_mm = bench.board.points_mm.copy()
    across = (flat_mm[:, 0] - flat_mm[:, 0].mean()) / np.ptp(flat_mm[:, 0]) * 2
    bench.board.points_mm[:, 2] = 0.4 * across**2
    bench.board.points_mm[:, :2] += flat_mm[:, 1:2] * [0.003, -0.002]
    views = bench.views(16)
    (at_base,) = bench.poses(1)
    seen = bench.view("at the base", at_base, noise_px=0.01).corners
    bench.board.points_mm[:] = flat_mm
    found = calibrate(bench.board, views, bench.sizes).cameras
    assert found.board_shape["bend_x_mm"] == pytest.approx(0.4, abs=0.01)
    assert found.board_shape["stretch"] == pytest.approx(-0.002, abs=3e-4)
    assert found.board_shape["shear"] == pytest.approx(0.003, abs=3e-4)
    assert abs(found.board_shape["bend_y_mm"]) < 0.01
    assert found.board_check.rms_error_mm < 0.02
    assert found.board_check.surface_error_mm < 0.02
    bases = [
        np.array(base_from_board(cameras, [seen], flat_mm, np.eye(4)).rig_from_robot)
        for cameras in (found, msgspec.structs.replace(found, board_shape={}))
    ]
    as_it_is, as_if_flat = (np.linalg.norm(base[:3, :3] - at_base[:3, :3]) for base in bases)
    assert as_it_is < 2e-3
    assert as_if_flat > 1.3 * as_it_is
    for camera in found.cameras:
        assert camera.rms_px == pytest.approx(NOISE_PX, rel=0.15)
        assert np.abs(sigmas_off(camera, bench.cameras[camera.name])).max() < 4


def test_lengths_are_those_that_the_ruler_measured_along_x_however_long_y_was_printed(known_bench):
    bench = known_bench()
    drawn_mm = bench.board.points_mm.copy()
    bench.board.points_mm[:, 1] *= 0.996
    views = bench.views(16)
    (at_base,) = bench.poses(1)
    seen = bench.view("at the base", at_base, noise_px=0.01).corners
    bench.board.points_mm[:] = drawn_mm
    found = calibrate(bench.board, views, bench.sizes).cameras
    assert found.board_shape["stretch"] == pytest.approx(-0.004, abs=3e-4)
    right = found.cameras[1]
    assert np.abs(sigmas_off(right, bench.cameras["right"])).max() < 4
    baseline_mm, exact_mm = (
        np.linalg.norm(np.array(pose)[:3, 3])
        for pose in (right.camera_from_rig, bench.cameras["right"].camera_from_rig)
    )
    assert baseline_mm == pytest.approx(exact_mm, rel=5e-4)
    base = np.array(base_from_board(found, [seen], drawn_mm, np.eye(4)).rig_from_robot)
    np.testing.assert_allclose(base[:3, 3], at_base[:3, 3], atol=0.1)


def test_errors_that_are_alike_within_a_view_widen_the_bounds(known_bench):
    bench = known_bench()
    views = bench.views(14)
    plain = calibrate(bench.board, views, bench.sizes).cameras
    for view in views:
        for corners in view.corners.values():
            along = corners.px - corners.px.mean(axis=0)
            corners.px[:] += along @ bench.random.normal(0, 1e-3, (2, 2))
    biased = calibrate(bench.board, views, bench.sizes).cameras
    for before, after in zip(plain.cameras, biased.cameras, strict=True):
        noise = after.rms_px / before.rms_px
        assert after.sigma["fx_px"] > 1.5 * noise * before.sigma["fx_px"]
        assert np.abs(sigmas_off(after, bench.cameras[after.name])).max() < 4.5
