"""Which pixels are the robot: told from the holder, from specks and from nothing at all."""

import numpy as np
import pytest

from sensing.errors import RefusedError
from sensing.geometry.camera import Camera
from sensing.pictures.backdrop import Backdrop
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import AXIS_MM, BaseView, Limits, robot_mask

HEIGHT, WIDTH = 300, 240
PX_PER_MM = 4.0
BASE = BaseView(
    pixel=np.array([120.0, 200.0]),
    axis_pixels=np.column_stack([np.full(len(AXIS_MM), 120.0), 200.0 - PX_PER_MM * AXIS_MM]),
    up=np.array([0.0, -1.0]),
    px_per_mm=PX_PER_MM,
)
ROBOT = (slice(60, 200), slice(114, 127))


GREY = 150
GREEN = (82, 150, 64)
SHADOW = (slice(80, 190), slice(127, 200))


def scene(contrast=80.0, noise=2.0):
    """Colour distances of an upright robot whose base is at row 200."""
    distance = np.abs(np.random.default_rng(4).normal(noise, noise / 3, (HEIGHT, WIDTH)))
    distance[ROBOT] = contrast
    return distance


def mask_of(distance, base=BASE, **limits):
    """The mask of a picture whose colours are at these distances from grey."""
    picture = np.rint(GREY - distance[..., None] / np.sqrt(3) * np.ones(3)).astype(np.uint8)
    backdrop = Backdrop.from_colour((GREY, GREY, GREY), (WIDTH, HEIGHT))
    known = Limits(**({"holder_radius_mm": 25.0} | limits))
    return robot_mask("left", picture, backdrop, base, known)


def segmented(distance, base=BASE, **limits):
    return mask_of(distance, base, **limits) > 0


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
        (scene(contrast=7.0), "nothing stands out from the backdrop where the robot leaves its base"),
    ],
    ids=["noise", "one colour", "too faint"],
)
def test_nothing_at_the_base_is_refused_and_the_camera_named(distance, reason):
    with pytest.raises(RefusedError, match=f"camera left: .*({reason})"):
        mask_of(distance)


def test_a_speck_at_the_base_is_too_small_for_a_robot():
    distance = scene()
    distance[ROBOT] = 2.0
    distance[172:188, 118:123] = 80.0
    with pytest.raises(
        RefusedError, match=r"camera left: .*too small for a robot \(5.0 mm2; at least 10 mm2\)"
    ):
        mask_of(distance)


def test_a_base_outside_of_the_picture_is_refused():
    away = BaseView(
        pixel=np.array([120.0, 400.0]),
        axis_pixels=np.column_stack([np.full(len(AXIS_MM), 120.0), 400.0 - AXIS_MM]),
        up=np.array([0.0, -1.0]),
        px_per_mm=1.0,
    )
    with pytest.raises(RefusedError, match="camera left: the robot's base is outside the picture"):
        mask_of(scene(), away)


def test_what_lies_outside_of_the_work_area_is_not_robot():
    distance = scene()
    distance[100:120, 20:220] = 90.0
    area = np.array([[90.0, 20], [150, 20], [150, 280], [90, 280]])
    mask = segmented(distance, work_area=area)
    assert not mask[:, :89].any()
    assert not mask[:, 152:].any()
    assert np.array_equal(mask[125:200, 90:150], expected()[125:200, 90:150])


def test_the_robot_is_not_looked_for_beyond_its_length():
    distance = scene()
    distance[20:200, 114:127] = 80.0
    mask = segmented(distance, length_mm=35.0)
    reach = 1.1 * 35.0 * PX_PER_MM
    assert not mask[: int(200 - reach) - 2].any()
    assert mask[int(200 - reach) + 2 : 200, 116:125].all()


def test_a_given_threshold_is_equation_1s():
    distance = scene(contrast=80.0, noise=0.0)
    distance[60:200, 60:114] = 40.0
    assert segmented(distance, threshold=30.0)[100, 80]
    assert not segmented(distance, threshold=50.0)[100, 80]
    with pytest.raises(RefusedError, match="threshold 90"):
        mask_of(distance, threshold=90.0)


def before_green(robot_bgr, shadow_depth):
    """The mask of a robot before green, with a shadow beside it that touches it."""
    picture = np.full((HEIGHT, WIDTH, 3), GREEN, np.float64)
    picture[SHADOW] *= 1 - shadow_depth
    picture[ROBOT] = robot_bgr
    picture += np.random.default_rng(8).normal(0, 1.5, picture.shape)
    backdrop = Backdrop.from_colour(GREEN, (WIDTH, HEIGHT))
    return robot_mask("left", picture.round().astype(np.uint8), backdrop, BASE, Limits(25.0)) > 0


@pytest.mark.parametrize("depth", [0.2, 0.35, 0.5])
def test_a_shadow_that_touches_the_robot_is_backdrop(depth):
    mask = before_green((70, 64, 66), depth)
    assert not mask[SHADOW][:, 4:].any()
    assert mask[ROBOT][5:-5, 2:-2].all()


def test_a_robot_in_a_darker_shade_of_the_backdrops_colour_is_robot():
    assert np.array_equal(before_green((41, 75, 32), 0.0), expected())


def test_glare_on_the_robot_is_no_hole_but_a_loop_has_one():
    distance = scene()
    distance[100:110, 117:123] = 2.0
    assert segmented(distance)[ROBOT].all()
    distance[60:72, 20:127] = distance[60:160, 20:32] = distance[150:160, 20:127] = 80.0
    assert not segmented(distance)[75:145, 35:110].any()


@pytest.mark.parametrize("insertion_mm", [0.0, 12.0])
def test_the_base_is_seen_where_it_projects(rig, project, insertion_mm):
    for calibration in rig:
        view = BaseView.of(Camera(calibration), insertion_mm)
        pixels = project(calibration, [[0, 0, insertion_mm], [0, 0, insertion_mm + 8.5]])
        assert view.pixel == pytest.approx(Grid.of((1920, 1080)).coarse(pixels[0]))
        up = pixels[1] - pixels[0]
        assert view.up == pytest.approx(up / np.linalg.norm(up))
        assert view.px_per_mm == pytest.approx(np.linalg.norm(up) / 2 / 8.5)
