"""The plain method from rendered pictures to shapes, against the curves that were photographed."""

import numpy as np
import pytest

from messaging.frames import CameraCalibration
from messaging.shape import Flag
from sensing.errors import NodalPointError, RefusedError
from sensing.plain.method import Plain
from sensing.scene import Scene

NODES_MM = np.arange(10.0, 81.0, 10.0)
POSES = {
    "straight": (0.0, 0.0, 0.0, 0.0),
    "leaning": (0.5, 0.4, 0.3, 0.4),
    "s bend": (0.9, 2.6, 0.9, -0.5),
}
CHI2_95_OF_3 = 7.81


@pytest.fixture(scope="session")
def plainly():
    """Estimate from coded pictures by camera, without anything from before."""

    def _plainly(scene, pictures, insertion_mm=0.0):
        decoded_late = {name: scene.picture(name, data) for name, data in pictures.items()}
        ticks = iter(range(100))
        return Plain(scene).estimate(decoded_late, insertion_mm, None, lambda: float(next(ticks)))

    return _plainly


@pytest.fixture(scope="session")
def shapes(bench, arcs, plainly):
    return {name: plainly(bench.scene(), bench.photograph(arcs(*pose))) for name, pose in POSES.items()}


def errors_mm(shape, points_mm):
    """Errors (8,) of the nodal points, and how many of their ellipsoids of 95 % hold the truth."""
    nodes, covariance = shape.nodes(NODES_MM)
    off = nodes - points_mm[NODES_MM.astype(int)]
    distance2 = np.einsum("ki,kij,kj->k", off, np.linalg.inv(covariance), off)
    return np.linalg.norm(off, axis=1), np.count_nonzero(distance2 < CHI2_95_OF_3)


@pytest.mark.parametrize("name", POSES)
def test_nodal_points_lie_where_the_robot_was(shapes, arcs, name):
    errors, covered = errors_mm(shapes[name], arcs(*POSES[name]))
    assert shapes[name].flags == ()
    assert errors.mean() < 0.3
    assert errors[-1] < 0.8
    assert covered >= 7


@pytest.mark.parametrize("name", POSES)
def test_the_evidence_says_how_the_cameras_agree(shapes, name):
    evidence = shapes[name].evidence
    assert set(evidence.residual_px) == set(evidence.visible_mm) == {"left", "right"}
    assert all(0.2 < residual < 2.5 for residual in evidence.residual_px.values())
    assert all(75 < visible < 83 for visible in evidence.visible_mm.values())
    assert 0 < evidence.ray_gap_mm < 0.1
    assert abs(evidence.ray_bias_mm) < evidence.ray_gap_mm
    assert evidence.epipolar_angle_rad.shape == shapes[name].centreline.arc_mm.shape
    assert np.isfinite(evidence.epipolar_angle_rad).all()


def test_every_step_is_there_to_be_seen(shapes):
    shape = shapes["leaning"]
    assert list(shape.stage_s) == ["decode", "segment", "skeleton", "triangulate", "judge"]
    assert shape.track is None
    silhouette = shape.stages.silhouettes["left"]
    assert silhouette.mask.shape == (1080, 1920)
    columns, rows = silhouette.skeleton.astype(int).T
    assert silhouette.mask[rows, columns].all()
    assert len(shape.stages.points_mm) == len(shape.stages.gaps_mm) > 400


def test_the_same_pictures_give_the_same_bits(bench, arcs, plainly):
    pictures = bench.photograph(arcs(0.5, 1.0))
    one, other = (plainly(bench.scene(), pictures) for _ in range(2))
    assert np.array_equal(one.centreline.points_mm, other.centreline.points_mm)
    assert np.array_equal(one.centreline.covariance_mm2, other.centreline.covariance_mm2)


def test_the_base_goes_up_with_the_stage(bench, arcs, plainly):
    shape = plainly(
        bench.scene(), bench.photograph(arcs(0.4, 2.0, 0.2, 2.0, insertion_mm=6.0)), insertion_mm=6.0
    )
    errors, _ = errors_mm(shape, arcs(0.4, 2.0, 0.2, 2.0, insertion_mm=6.0))
    assert shape.centreline.points_mm[0].tolist() == [0, 0, 6]
    assert errors.max() < 0.8


def test_no_wrong_shape_is_published_as_a_good_one(small_bench, arcs, plainly):
    """Seeded poses, the length not known: whatever is off by more than a millimetre is flagged or refused."""
    random = np.random.default_rng(4)
    good = 0
    for _ in range(12):
        points = arcs(*(value for _ in range(2) for value in random.uniform((0, -3), (1.5, 3))))
        try:
            shape = plainly(small_bench.scene(length_mm=None), small_bench.photograph(points))
            errors, _ = errors_mm(shape, points)
        except (RefusedError, NodalPointError):
            continue
        if not shape.flags:
            good += 1
            assert errors.max() < 1.2
    assert good >= 6


def test_a_bend_past_the_epipolar_direction_is_flagged(bench, arcs, plainly):
    """Both cameras see the robot come down again, and descent takes partners from its way up."""
    shape = plainly(bench.scene(length_mm=None), bench.photograph(arcs(1.5, 0.0, 1.5, 0.0)))
    assert Flag.EPIPOLAR_TANGENCY in shape.flags


def test_a_moved_camera_is_flagged(bench, arcs, plainly):
    left, right = bench.rig
    turned = right.camera_from_robot.copy()
    turned[0, 3] += 1.5
    moved = CameraCalibration(
        camera=right.camera,
        width_px=right.width_px,
        height_px=right.height_px,
        intrinsics=right.intrinsics,
        distortion=right.distortion,
        camera_from_robot=turned,
    )
    shape = plainly(Scene.of((left, moved), length_mm=80.0), bench.photograph(arcs(0.5, 0.4)))
    assert Flag.CALIBRATION_OFF in shape.flags


def test_a_wrong_length_is_flagged(bench, arcs, plainly):
    shape = plainly(bench.scene(length_mm=84.0), bench.photograph(arcs(0.5, 0.4)))
    assert shape.flags == (Flag.LENGTH_MISMATCH,)


def test_a_robot_cut_off_by_the_work_area_is_flagged(bench, arcs, plainly):
    points = arcs(0.3, 0.4)
    area = np.array([[700.0, 300.0], [1250.0, 300.0], [1250.0, 1060.0], [700.0, 1060.0]])
    pictures = bench.photograph(points)
    whole = plainly(bench.scene(length_mm=None), pictures)
    top = min(shape.skeleton[:, 1].min() for shape in whole.stages.silhouettes.values())
    area[:2, 1] = top + 80
    cut = Scene.of(bench.rig, work_areas={camera.camera: area for camera in bench.rig})
    assert Flag.OUT_OF_VIEW in plainly(cut, pictures).flags


def test_of_three_cameras_all_are_compared(bench, third_camera, arcs, plainly):
    points = arcs(0.5, 0.4, 0.3, 0.4)
    rig = (*bench.rig, *third_camera.rig)
    pictures = {**bench.photograph(points), **third_camera.photograph(points)}
    shape = plainly(Scene.of(rig, length_mm=80.0), pictures)
    errors, _ = errors_mm(shape, points)
    assert set(shape.evidence.residual_px) == set(shape.stages.silhouettes) == {"left", "right", "above"}
    assert shape.flags == ()
    assert errors.max() < 0.8


def test_a_backdrop_may_be_a_picture_or_a_colour(small_bench, without_robot, arcs, decode, plainly):
    points = arcs(0.5, 0.4)
    pictures = small_bench.photograph(points)
    colour_bgr = np.median(decode(pictures["left"]).reshape(-1, 3), axis=0)
    green = Scene.of(small_bench.rig, colour_rgb=tuple(colour_bgr[::-1]), threshold=45.0)
    for scene in (small_bench.scene(backgrounds=without_robot), green):
        errors, _ = errors_mm(plainly(scene, pictures), points)
        assert errors[:-1].max() < 0.8


def test_a_picture_without_robot_is_refused(small_bench, without_robot, plainly):
    with pytest.raises(RefusedError, match="camera left: nothing stands out from the backdrop"):
        plainly(small_bench.scene(backgrounds=without_robot), without_robot)


def test_a_threshold_above_the_contrast_is_refused(small_bench, arcs, plainly):
    scene = Scene.of(small_bench.rig, threshold=400.0)
    with pytest.raises(RefusedError, match=r"camera left: nothing stands out .*threshold 400"):
        plainly(scene, small_bench.photograph(arcs()))
