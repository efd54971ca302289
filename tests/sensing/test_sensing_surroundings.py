"""What lies in and around a fitted tube, and what follows from it. Pictures are of the small bench."""

from dataclasses import replace

import numpy as np
import pytest

from messaging.shape import Flag
from sensing.errors import RefusedError
from sensing.geometry import curve
from sensing.refined.measuring import View
from sensing.refined.quality import HIDDEN_PLACES, longest_run
from sensing.refined.surroundings import look_around
from sensing.refined.tube import Curve

POSE = (0.9, 2.6, 0.9, -0.5)
HOLDER_RADIUS_MM = 25.0


@pytest.fixture(scope="module")
def seen(small_bench, arcs):
    return small_bench.photograph(arcs(*POSE))


@pytest.fixture(scope="module")
def found(small_bench, seen, look):
    return look(small_bench.scene(), seen)


@pytest.fixture(scope="module")
def around(small_bench, seen, found):
    """What lies in and around another curve in the same pictures."""
    scene = small_bench.scene()
    views = tuple(
        View(
            camera,
            scene.picture(camera.name, seen[camera.name]).luma,
            found.track.backdrops[camera.name].luma,
            np.zeros(2),
        )
        for camera in scene.cameras
    )

    def _around(points_mm):
        control = curve.fit_points(points_mm, np.linspace(0, 1, len(points_mm)))
        length = float(curve.arc_lengths(points_mm)[-1])
        other = Curve(control, length, found.track.curve.radius_mm)
        return look_around(views, replace(found.track, curve=other), HOLDER_RADIUS_MM)

    return _around


def test_a_tube_that_fits_is_full_and_has_nothing_beside_it(around, arcs):
    for camera in around(arcs(*POSE)):
        assert not camera.missing.any()
        assert not camera.spilled.any()


def test_a_tube_beside_the_robot_shows_backdrop(around, arcs):
    there = arcs(*POSE) + np.linspace(0, 1, 81)[:, None] * np.array([40.0, 0, 0])
    assert all(longest_run(camera.missing) > 4 * HIDDEN_PLACES for camera in around(there))


def test_a_tube_that_ends_too_soon_has_robot_around_its_end(around, arcs):
    for camera in around(arcs(*POSE)[:70]):
        assert camera.spilled[2 * curve.SAMPLES :].any()
        assert not camera.missing.any()


def test_runs_are_counted_between_what_is_not_raised():
    assert longest_run(np.zeros(5, bool)) == 0
    assert longest_run(np.ones(4, bool)) == 4
    assert longest_run(np.array([1, 0, 1, 1, 0, 1], bool)) == 2


def test_an_object_beside_the_robot_is_told_from_a_warm_start_too(
    small_bench, seen, found, look, decode, encode, project
):
    picture = decode(seen["left"])
    x, y = project(small_bench.rig[0], found.centreline.points_mm[55])[0].astype(int)
    picture[y - 40 : y + 10, x + 14 : x + 40] = (70, 64, 66)
    shape = look(small_bench.scene(), {**seen, "left": encode(picture)}, found)
    assert Flag.MERGED_SILHOUETTE in shape.flags


def test_a_doubtful_shape_is_no_start_for_the_next(small_bench, seen, look):
    doubtful = look(small_bench.scene(length_mm=90.0), seen)
    assert doubtful.flags
    assert doubtful.track is None


@pytest.mark.parametrize("pose", [POSE, (0.66, 1.97, 0.24, 0.63), (1.1, 0.3, 0.5, 1.0)], ids=str)
def test_swapped_cameras_are_named(small_bench, arcs, look, pose):
    taken = small_bench.photograph(arcs(*pose))
    swapped = {"left": taken["right"], "right": taken["left"]}
    with pytest.raises(RefusedError, match="cameras left and right seem to be swapped"):
        look(small_bench.scene(), swapped)


@pytest.mark.parametrize("moved_px", [(3, 0), (-3, 0), (0, 4)], ids=str)
def test_a_picture_that_lies_elsewhere_is_measured_and_told(bench, arcs, look, decode, encode, moved_px):
    """A camera that was turned by a few px: the fit says how far, and the flag that the calibration is off."""
    taken = bench.photograph(arcs(0.5, 0.4, 0.3, 0.4))
    moved = np.roll(decode(taken["left"]), moved_px[::-1], axis=(0, 1))
    shape = look(bench.scene(), {**taken, "left": encode(moved)})
    off = shape.centreline.fit.shift_px[0]
    assert off @ moved_px > 0.3 * np.dot(moved_px, moved_px)
    assert Flag.CALIBRATION_OFF in shape.flags
    assert shape.evidence.ray_bias_mm > 0.1


def test_pictures_that_lie_where_they_should_are_not_doubted(bench, arcs, look):
    shape = look(bench.scene(), bench.photograph(arcs(0.5, 0.4, 0.3, 0.4)))
    assert shape.flags == ()
    assert shape.evidence.ray_bias_mm < 0.06
