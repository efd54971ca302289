"""Which pixels are the robot: told from the holder, from specks and from nothing at all."""

import numpy as np
import pytest

from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.segmentation import AXIS_MM, BaseView, robot_mask, small_pixels

HEIGHT, WIDTH = 300, 240
PX_PER_MM = 4.0
BASE = BaseView(
    pixel=np.array([120.0, 200.0]),
    axis_pixels=np.column_stack([np.full(len(AXIS_MM), 120.0), 200.0 - PX_PER_MM * AXIS_MM]),
    up=np.array([0.0, -1.0]),
    px_per_mm=PX_PER_MM,
)
ROBOT = (slice(60, 200), slice(114, 127))


def scene(contrast=80.0, noise=2.0):
    """Colour distances of an upright robot whose base is at row 200."""
    distance = np.abs(np.random.default_rng(4).normal(noise, noise / 3, (HEIGHT, WIDTH)))
    distance[ROBOT] = contrast
    return distance


def segmented(distance, base=BASE, holder_radius_mm=25.0):
    return robot_mask("left", distance, base, holder_radius_mm) > 0


def expected():
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[ROBOT] = True
    return mask


def test_the_robot_is_what_stands_out_at_the_base():
    assert np.array_equal(segmented(scene()), expected())


def test_a_holder_joined_to_the_silhouette_is_not_robot():
    distance = scene()
    distance[200:260, 80:160] = 90.0
    mask = segmented(distance)
    assert not mask[201:].any()
    assert np.array_equal(mask[:200], expected()[:200])


def test_the_holder_is_cut_off_along_a_tilted_base_too():
    tilt = np.deg2rad(20)
    up = np.array([np.sin(tilt), -np.cos(tilt)])
    base = BaseView(
        pixel=np.array([120.0, 200.0]),
        axis_pixels=np.array([120.0, 200.0]) + PX_PER_MM * AXIS_MM[:, None] * up,
        up=up,
        px_per_mm=PX_PER_MM,
    )
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    along = (x - 120) * up[0] + (y - 200) * up[1]
    across = (y - 200) * up[0] - (x - 120) * up[1]
    distance = scene()
    distance[ROBOT] = 2.0
    distance[(np.abs(across) < 6) & (along >= 0) & (along < 120)] = 80.0
    distance[(np.abs(across) < 40) & (along < 0) & (along > -50)] = 80.0
    mask = segmented(distance, base)
    assert not mask[along < -1].any()
    assert mask[(np.abs(across) < 5) & (along > 1) & (along < 119)].all()


def test_what_hangs_below_the_base_beside_the_holder_is_robot():
    distance = scene()
    distance[60:72, 20:127] = 80.0
    distance[60:240, 20:32] = 80.0
    mask = segmented(distance, holder_radius_mm=15.0)
    assert mask[60:240, 20:32].all()


def test_specks_and_other_dark_things_are_dropped():
    distance = scene()
    distance[30:34, 30:34] = 90.0
    distance[100:180, 180:220] = 90.0
    assert np.array_equal(segmented(distance), expected())


def test_gaps_are_closed():
    distance = scene()
    distance[120:124, 114:127] = 2.0
    distance[80:83, 119:122] = 2.0
    mask = segmented(distance)
    assert mask[60:200, 116:125].all()


def test_the_threshold_follows_the_noise_and_the_contrast():
    faint = scene(contrast=14.0, noise=2.0)
    assert np.array_equal(segmented(faint), expected())
    shaded = scene()
    shaded[:, 150:] += 20.0
    assert np.array_equal(segmented(shaded), expected())


@pytest.mark.parametrize(
    ("distance", "reason"),
    [
        (
            np.full((HEIGHT, WIDTH), 2.0),
            "nothing stands out from the backdrop where the robot leaves its base",
        ),
        (np.zeros((HEIGHT, WIDTH)), "nothing stands out|no robot|too small"),
        (scene(contrast=8.0), "nothing stands out from the backdrop where the robot leaves its base"),
    ],
    ids=["noise", "one colour", "too faint"],
)
def test_nothing_at_the_base_is_refused_and_the_camera_named(distance, reason):
    with pytest.raises(RefusedError, match=f"camera left: .*({reason})"):
        robot_mask("left", distance, BASE, 25.0)


def test_a_speck_at_the_base_is_too_small_for_a_robot():
    distance = scene()
    distance[ROBOT] = 2.0
    distance[172:188, 118:123] = 80.0
    with pytest.raises(RefusedError, match=r"camera left: .*too small for a robot \(\d+ px\)"):
        robot_mask("left", distance, BASE, 25.0)


def test_a_base_outside_of_the_picture_is_refused():
    away = BaseView(
        pixel=np.array([120.0, 400.0]),
        axis_pixels=np.column_stack([np.full(len(AXIS_MM), 120.0), 400.0 - AXIS_MM]),
        up=np.array([0.0, -1.0]),
        px_per_mm=1.0,
    )
    with pytest.raises(RefusedError, match="camera left: the robot's base is outside the picture"):
        robot_mask("left", scene(), away, 25.0)


@pytest.mark.parametrize("insertion_mm", [0.0, 12.0])
def test_the_base_is_seen_where_it_projects(rig, project, insertion_mm):
    for calibration in rig:
        view = BaseView.of(Camera(calibration), insertion_mm)
        pixels = project(calibration, [[0, 0, insertion_mm], [0, 0, insertion_mm + 8.5]])
        assert view.pixel == pytest.approx(small_pixels(pixels[0]))
        up = pixels[1] - pixels[0]
        assert view.up == pytest.approx(up / np.linalg.norm(up))
        assert view.px_per_mm == pytest.approx(np.linalg.norm(up) / 2 / 8.5)
