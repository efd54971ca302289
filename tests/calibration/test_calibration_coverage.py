"""What is taken, refused and asked for while a person moves the board; and which of many views are solved."""

import numpy as np
import pytest

from calibration.corners import Corners
from calibration.coverage import Coverage
from calibration.errors import ViewsError
from calibration.picking import pick
from calibration.views import View, find_view


def blurred(view, camera, blur_px):
    corners = dict(view.corners)
    one = corners[camera]
    corners[camera] = Corners(one.ids, one.px, np.full(len(one), blur_px))
    return View(view.name, corners, view.missing, view.sizes)


def test_nothing_is_covered_before_a_view(known_bench):
    bench = known_bench()
    coverage = Coverage(bench.board, bench.sizes)
    assert not coverage.enough
    assert coverage.missing() == (
        "more views that left and right both see: 0 of 12",
        "left: has not seen the board yet",
        "right: has not seen the board yet",
    )


def test_views_all_over_are_enough_and_what_was_missing_shrinks(known_bench):
    bench = known_bench(seed=2)
    coverage = Coverage(bench.board, bench.sizes)
    asked = []
    for view in bench.views(120, spread=0.55):
        coverage.offer(view)
        asked.append(len(coverage.missing()))
        if coverage.enough:
            break
    assert coverage.enough
    assert 20 <= len(coverage.views) < 120
    assert asked[0] > asked[len(asked) // 2] > asked[-1] == 0


def test_the_same_view_again_is_refused_and_named(known_bench):
    bench = known_bench()
    coverage = Coverage(bench.board, bench.sizes)
    (pose,) = bench.poses(1)
    assert coverage.offer(bench.view("first", pose)).taken
    verdict = coverage.offer(bench.view("second", pose))
    assert not verdict.taken
    assert verdict.reason == "shows the same as view first: move or tilt the board"
    assert len(coverage.views) == 1


def test_a_blurred_view_is_refused(known_bench):
    bench = known_bench()
    coverage = Coverage(bench.board, bench.sizes)
    sharp, moving = bench.views(2)
    coverage.offer(sharp)
    verdict = coverage.offer(blurred(moving, "right", 2.5))
    assert not verdict.taken
    assert verdict.reason == "right: blurred over 2.5 px: hold the board still"


def test_a_view_without_the_board_says_why(known_bench):
    bench = known_bench()
    coverage = Coverage(bench.board, bench.sizes)
    verdict = coverage.offer(View("none", {}, {"left": "no marker of DICT_4X4_50 is in sight"}, bench.sizes))
    assert not verdict.taken
    assert verdict.reason == "left: no marker of DICT_4X4_50 is in sight"


def test_one_tilt_and_one_place_are_named_as_what_they_are(known_bench, known_camera):
    bench = known_bench(cameras={"only": known_camera()})
    coverage = Coverage(bench.board, bench.sizes)
    for number, pose in enumerate(bench.poses(6, tilt_deg=2, spread=0.15)):
        coverage.offer(bench.view(f"{number}", pose))
    words = " | ".join(coverage.missing())
    assert "only: tilt the board more about its vertical axis" in words
    assert "only: tilt the board more about its horizontal axis" in words
    assert "only: nothing in the upper right of the picture" in words
    assert "only: nothing in the middle of the picture" not in words
    assert f"only: more views: {len(coverage.views)} of 20" in words


def test_the_grid_counts_corners_where_they_lie(known_bench):
    bench = known_bench()
    coverage = Coverage(bench.board, bench.sizes)
    ids = np.arange(9)
    px = np.stack(np.meshgrid([100, 960, 1800], [100, 540, 1000]), axis=-1).reshape(-1, 2).astype(float)
    coverage.offer(View("spread", {"left": Corners(ids[:8], px[:8], np.full(8, 0.7))}, {}, bench.sizes))
    assert coverage.grid("left").tolist() == [[1, 1, 1], [1, 1, 1], [1, 1, 0]]
    assert coverage.grid("right").sum() == 0


def test_of_a_whole_recording_few_different_views_are_picked(known_bench):
    bench = known_bench(seed=4)
    views = []
    for number, pose in enumerate(bench.poses(40)):
        views += [bench.view(f"{number}-{again}", pose) for again in range(6)]
    picked = pick(bench.board, views, bench.sizes, most=30)
    assert len(picked.views) == 30
    assert len({view.name.split("-")[0] for view in picked.views}) == 30
    assert len(picked.rejected) == len(views) - 30
    assert any(reason.startswith("shows the same as view") for reason in picked.rejected.values())
    spread = np.ptp(np.concatenate([view.corners["left"].px for view in views]), axis=0)
    kept = np.ptp(np.concatenate([view.corners["left"].px for view in picked.views]), axis=0)
    assert (kept > 0.95 * spread).all()


def test_blurred_views_are_not_picked_and_both_blurs_are_said(known_bench):
    bench = known_bench()
    views = bench.views(8)
    views[2] = blurred(views[2], "left", 3.0)
    picked = pick(bench.board, views, bench.sizes)
    assert [view.name for view in picked.views] == ["00", "01", "03", "04", "05", "06", "07"]
    assert picked.rejected["02"].startswith("left: blurred over 3.0 px, where 0.7 px is possible")


def test_views_that_are_all_alike_are_too_few(known_bench):
    bench = known_bench()
    (pose,) = bench.poses(1)
    with pytest.raises(ViewsError, match="1 views that differ"):
        pick(bench.board, [bench.view(f"{number}", pose) for number in range(20)], bench.sizes)


def test_a_view_is_found_in_the_pictures_of_all_cameras(known_bench, small_camera, render, held):
    bench = known_bench(cameras={"left": small_camera, "right": small_camera})
    settings = bench.board.settings
    picture = render(small_camera, settings, held(settings))
    view = find_view(bench.board, "both", {"left": picture, "right": np.full_like(picture, 90)})
    assert set(view.corners) == {"left"}
    assert view.missing == {"right": "no marker of DICT_4X4_50 is in sight"}
    assert view.sizes == {"left": (960, 540), "right": (960, 540)}
    assert view.blur_px["left"] == pytest.approx(0.5, abs=0.15)
