"""From rendered pictures to shapes, against the curves that were photographed."""

import numpy as np
import pytest

from messaging.shape import NodalPoints
from sensing.errors import NodalPointError
from sensing.refined.tube import Tip
from sensing.scene import Scene
from sensing.shape import covered_nodes

POSES = {
    "straight": (0.0, 0.0, 0.0, 0.0),
    "leaning": (0.5, 0.4, 0.3, 0.4),
    "s bend": (0.9, 2.6, 0.9, -0.5),
    "hook": (1.3, 2.9, 1.4, 2.4),
    "away and back": (0.9, 1.5, 1.2, -2.9),
}
NODES_MM = np.arange(10.0, 81.0, 10.0)


@pytest.fixture(scope="session")
def true_nodes(arcs):
    def _true_nodes(pose, insertion_mm=0.0):
        return arcs(*pose, insertion_mm=insertion_mm)[NODES_MM.astype(int)]

    return _true_nodes


@pytest.fixture(scope="session")
def pictures(bench, arcs):
    return {name: bench.photograph(arcs(*pose)) for name, pose in POSES.items()}


@pytest.fixture(scope="session")
def shapes(bench, pictures, look):
    """Every pose from nothing but two pictures, the robot's length being known."""
    scene = bench.scene()
    return {name: look(scene, seen) for name, seen in pictures.items()}


def errors_mm(shape, nodes_mm):
    return np.linalg.norm(shape.nodes(NODES_MM)[0] - nodes_mm, axis=1)


@pytest.mark.parametrize("name", POSES)
def test_nodal_points_lie_where_the_robot_was(shapes, true_nodes, name):
    shape = shapes[name]
    error = errors_mm(shape, true_nodes(POSES[name]))
    assert shape.flags == ()
    assert error.mean() < 0.1
    assert error[-1] < 0.3
    assert shape.length_mm == pytest.approx(80, abs=0.15)
    assert shape.track.tip is Tip.ROUND
    assert shape.residual_px < 0.4
    assert shape.evidence.ray_gap_mm < 0.1


@pytest.mark.parametrize("name", POSES)
def test_the_centreline_is_ordered_from_the_base_and_even(shapes, name):
    shape = shapes[name]
    assert np.linalg.norm(shape.centreline.points_mm[0]) < 0.03
    assert shape.centreline.arc_mm[0] == 0
    assert shape.centreline.arc_mm[-1] == shape.length_mm
    steps = np.diff(shape.centreline.arc_mm)
    assert steps.max() < 1.02 * steps.min()


@pytest.mark.parametrize("name", POSES)
def test_the_covariance_is_a_covariance_and_tells_of_the_error(shapes, true_nodes, name):
    nodes, covariance = shapes[name].nodes(NODES_MM)
    assert np.array_equal(covariance, covariance.swapaxes(1, 2))
    spread = np.sqrt(np.linalg.eigvalsh(covariance))
    assert (spread > 1e-3).all()
    assert (spread < 0.3).all()
    assert spread[-1].max() > spread[0].max()
    off = nodes - true_nodes(POSES[name])
    mahalanobis = np.sqrt(np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off))
    # systematic parts (shading at the edges, disks) are larger than noise, so the spread is some 3 times too small
    assert mahalanobis.max() < 8


def test_an_unknown_length_is_measured(bench, pictures, look, true_nodes):
    shape = look(bench.scene(length_mm=None), pictures["s bend"])
    assert shape.flags == ()
    assert shape.length_mm == pytest.approx(80, abs=0.3)
    assert errors_mm(shape, true_nodes(POSES["s bend"])).mean() < 0.1


def test_a_background_picture_serves_as_the_backdrop(small_bench, without_robot, arcs, look, true_nodes):
    shape = look(small_bench.scene(without_robot), small_bench.photograph(arcs(*POSES["hook"])))
    assert shape.flags == ()
    assert sorted(shape.track.backdrops) == ["left", "right"]
    error = errors_mm(shape, true_nodes(POSES["hook"]))
    assert error.mean() < 0.1
    assert error[-1] < 0.3


def test_one_backdrop_colour_finds_the_robot(small_bench, arcs, look, true_nodes):
    scene = Scene.of(small_bench.rig, colour_rgb=(62.0, 145.0, 79.0), length_mm=80.0)
    shape = look(scene, small_bench.photograph(arcs(*POSES["leaning"])))
    assert errors_mm(shape, true_nodes(POSES["leaning"])).max() < 0.5


@pytest.mark.parametrize(
    ("before", "tolerance_mm"), [((0.89, 2.59, 0.89, -0.49), 0.05), ((0.88, 2.56, 0.87, -0.46), 0.15)]
)
def test_following_the_shape_before_gives_what_a_fresh_look_gives(
    bench, pictures, shapes, arcs, look, true_nodes, before, tolerance_mm
):
    scene = bench.scene()
    warm = look(scene, pictures["s bend"], look(scene, bench.photograph(arcs(*before))))
    moved = np.linalg.norm(true_nodes(before) - true_nodes(POSES["s bend"]), axis=1)
    assert moved.max() > 8 * tolerance_mm
    assert warm.stages is None
    assert warm.flags == ()
    apart = np.linalg.norm(warm.nodes(NODES_MM)[0] - shapes["s bend"].nodes(NODES_MM)[0], axis=1)
    assert apart.mean() < 0.03
    assert apart.max() < tolerance_mm


def test_a_motion_too_fast_to_follow_is_not_followed_halfway(bench, pictures, arcs, look, true_nodes):
    scene = bench.scene()
    before = (0.87, 2.54, 0.86, -0.44)
    shape = look(scene, pictures["s bend"], look(scene, bench.photograph(arcs(*before))))
    assert np.linalg.norm(true_nodes(before) - true_nodes(POSES["s bend"]), axis=1).max() > 3.5
    assert shape.flags == ()
    assert errors_mm(shape, true_nodes(POSES["s bend"])).max() < 0.3


def test_a_jump_is_followed_by_looking_afresh(bench, shapes, pictures, look, true_nodes):
    shape = look(bench.scene(), pictures["hook"], shapes["leaning"])
    assert shape.stages is not None
    assert errors_mm(shape, true_nodes(POSES["hook"])).max() < 0.3


def test_three_cameras_are_used_like_two(bench, third_camera, pictures, arcs, look, true_nodes):
    pose = POSES["away and back"]
    rig = (*third_camera.rig, *bench.rig)
    seen = pictures["away and back"] | third_camera.photograph(arcs(*pose))
    shape = look(Scene.of(rig, length_mm=80.0), seen)
    assert shape.flags == ()
    assert len(shape.centreline.fit.normals.valid) == 3
    error = errors_mm(shape, true_nodes(pose))
    assert error.mean() < 0.1
    assert error[-1] < 0.3


def test_the_base_rises_with_the_stage(bench, arcs, look, true_nodes):
    pose, insertion_mm = POSES["leaning"], 15.0
    scene = bench.scene()
    seen = bench.photograph(arcs(*pose, insertion_mm=insertion_mm))
    cold = look(scene, seen, insertion_mm=insertion_mm)
    assert cold.flags == ()
    assert cold.insertion_mm == insertion_mm
    assert cold.centreline.points_mm[0] == pytest.approx([0, 0, insertion_mm], abs=0.03)
    assert errors_mm(cold, true_nodes(pose, insertion_mm)).mean() < 0.1
    lower = bench.photograph(arcs(*pose, insertion_mm=insertion_mm - 9))
    warm = look(scene, lower, cold, insertion_mm=insertion_mm - 9)
    assert warm.stages is None
    assert errors_mm(warm, true_nodes(pose, insertion_mm - 9)).mean() < 0.1


def test_the_same_bytes_give_the_same_numbers(bench, pictures, shapes, look):
    again = look(bench.scene(), pictures["s bend"])
    for one, other in zip(again.nodes(NODES_MM), shapes["s bend"].nodes(NODES_MM), strict=True):
        assert np.array_equal(one, other)
    assert np.array_equal(again.centreline.points_mm, shapes["s bend"].centreline.points_mm)
    assert np.array_equal(again.centreline.fit.covariance, shapes["s bend"].centreline.fit.covariance)
    assert again.evidence.ray_gap_mm == shapes["s bend"].evidence.ray_gap_mm
    assert again.residual_px == shapes["s bend"].residual_px
    warm = [look(bench.scene(), pictures["s bend"], shapes["s bend"]).centreline.points_mm for _ in range(2)]
    assert np.array_equal(*warm)


def test_every_stage_of_a_fresh_look_is_timed_and_kept(shapes):
    shape = shapes["leaning"]
    assert list(shape.stage_s) == ["decode", "backdrop", "cold_start", "refine", "judge"]
    assert shape.stages is not None
    assert sorted(shape.stages.silhouettes) == ["left", "right"]
    assert shape.stages.gaps_mm.mean() < 0.3
    assert len(shape.stages.points_mm) == len(shape.stages.gaps_mm)


def test_points_between_nodes_and_at_the_ends(shapes):
    shape = shapes["hook"]
    nodes, _ = shape.nodes(np.array([0.0, 37.5, shape.length_mm]))
    assert nodes[0] == pytest.approx(shape.centreline.points_mm[0], abs=1e-9)
    assert nodes[2] == pytest.approx(shape.centreline.points_mm[-1], abs=0.01)
    on_line = [np.interp(37.5, shape.centreline.arc_mm, column) for column in shape.centreline.points_mm.T]
    assert nodes[1] == pytest.approx(on_line, abs=0.01)


def test_a_point_beyond_the_robot_is_an_error_with_its_value(shapes):
    with pytest.raises(
        NodalPointError, match=r"nodal point at 92\.5 mm is beyond the robot, .* (79|80)\.\d\d mm long"
    ):
        shapes["straight"].nodes(np.array([10.0, 92.5]))


def test_a_named_point_beyond_the_robot_is_refused_beforehand():
    points = NodalPoints(names=("middle", "tip"), arc_mm=np.array([40.0, 80.5]))
    with pytest.raises(
        NodalPointError, match=r"nodal point tip at 80\.5 mm is beyond the robot; allowed are 0 to 80 mm"
    ):
        covered_nodes(points, 80.0)
    assert covered_nodes(points, 80.5) is points


@pytest.mark.parametrize("tip", ["round", "flat"])
def test_a_round_tip_is_told_from_a_flat_one(bench, arcs, painted, look, tip):
    fine = arcs(0.7, 2.8, 0.5, -2.7)
    places = np.linspace(0, 80, 801)
    fine = np.column_stack([np.interp(places, np.arange(81), column) for column in fine.T])
    seen = {camera.camera: painted(camera, fine, 2.6, tip) for camera in bench.rig}
    shape = look(bench.scene(length_mm=None), seen)
    assert shape.flags == ()
    assert shape.track.tip == tip
    assert np.linalg.norm(shape.centreline.points_mm[-1] - fine[-1]) < 0.3
    assert shape.length_mm == pytest.approx(80, abs=0.3)
    assert np.median(shape.centreline.fit.curve.radius_mm) == pytest.approx(2.6, abs=0.05)
