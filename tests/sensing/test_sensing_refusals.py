"""The promise: what cannot be resolved is refused or flagged, and never goes out as a good shape.

Pictures are of the small bench. A shape without flags must be right to a millimetre, ten times the usual error.
"""

import numpy as np
import pytest

from sensing.errors import RefusedError, UnreadableImageError

POSE = (0.9, 2.6, 0.9, -0.5)
NODES_MM = np.arange(10.0, 81.0, 10.0)
HOLDER_BGR = (88, 84, 84)


@pytest.fixture(scope="session")
def seen(small_bench, arcs):
    return small_bench.photograph(arcs(*POSE))


@pytest.fixture(scope="session")
def before(small_bench, seen, look):
    """The shape a frame ago."""
    return look(small_bench.scene(), seen)


@pytest.fixture
def kept(small_bench, look):
    """Estimate, and hold the promise against the truth: returns the flags, or None when it was refused."""

    def _kept(pictures, truth_mm, last=None, length_mm=80.0):
        try:
            shape = look(small_bench.scene(length_mm=length_mm), pictures, last)
        except RefusedError:
            return None
        error = np.linalg.norm(shape.nodes(NODES_MM)[0] - truth_mm[NODES_MM.astype(int)], axis=1)
        assert shape.flags or error.max() < 1.0, f"{error.max():.2f} mm without a flag"
        return shape.flags

    return _kept


@pytest.fixture
def patched(decode, encode, without_robot):
    """A picture in which a rectangle shows the empty scene, or a colour."""

    def _patched(pictures, camera, corner_px, size_px, colour=None):
        picture = decode(pictures[camera])
        x, y = np.maximum(corner_px, 0)
        where = slice(y, max(y, corner_px[1] + size_px[1])), slice(x, max(x, corner_px[0] + size_px[0]))
        picture[where] = decode(without_robot[camera])[where] if colour is None else colour
        return {**pictures, camera: encode(picture)}

    return _patched


@pytest.mark.parametrize("warm", [False, True], ids=["cold", "warm"])
class TestNothingToSee:
    def test_an_empty_scene_is_refused(self, small_bench, without_robot, before, look, warm):
        with pytest.raises(RefusedError, match="camera left: "):
            look(small_bench.scene(without_robot), without_robot, before if warm else None)

    def test_an_empty_scene_is_not_a_shape_without_background_pictures_either(
        self, without_robot, before, kept, arcs, warm
    ):
        flags = kept(without_robot, arcs() + 1e3, before if warm else None)
        assert flags is None or flags

    @pytest.mark.parametrize("level", [0, 128, 255])
    def test_a_single_colour_is_refused(self, small_bench, before, encode, look, warm, level):
        plain = {name: encode(np.full((540, 960, 3), level)) for name in ("left", "right")}
        with pytest.raises(RefusedError, match="camera left: "):
            look(small_bench.scene(), plain, before if warm else None)

    @pytest.mark.parametrize("name", ["left", "right"])
    def test_a_robot_that_one_camera_does_not_see_is_refused_and_the_camera_named(
        self, small_bench, seen, without_robot, before, look, warm, name
    ):
        with pytest.raises(RefusedError, match=f"camera {name}: "):
            look(
                small_bench.scene(without_robot),
                {**seen, name: without_robot[name]},
                before if warm else None,
            )

    def test_noise_is_refused(self, small_bench, before, encode, look, warm):
        rng = np.random.default_rng(3)
        noise = {name: encode(rng.normal(128, 40, (540, 960, 3))) for name in ("left", "right")}
        with pytest.raises(RefusedError, match="camera "):
            look(small_bench.scene(), noise, before if warm else None)

    def test_a_picture_that_cannot_be_read_is_an_error_with_the_cameras_name(
        self, small_bench, seen, before, look, warm
    ):
        cut = {**seen, "right": seen["right"][: len(seen["right"]) // 2]}
        with pytest.raises(UnreadableImageError, match="camera right: "):
            look(small_bench.scene(), cut, before if warm else None)


@pytest.mark.parametrize(
    "pose", [POSE, (0.5, 0.4, 0.3, 0.4), (0.66, 1.97, 0.24, 0.63), (1.3, 2.9, 1.4, 2.4)], ids=str
)
def test_swapped_cameras_are_refused_or_flagged(small_bench, arcs, kept, pose):
    truth = arcs(*pose)
    seen = small_bench.photograph(truth)
    flags = kept({"left": seen["right"], "right": seen["left"]}, truth)
    assert flags is None or flags


@pytest.mark.parametrize("camera", ["left", "right"])
def test_a_robot_partly_out_of_the_picture_is_refused_or_flagged(
    small_bench, seen, arcs, kept, decode, encode, camera
):
    """The camera was turned aside: what it sees is shifted, and the tip is lost."""
    picture = decode(seen[camera])
    shifted = np.roll(picture, -250, axis=0)
    shifted[-250:] = picture[-1]
    assert kept({**seen, camera: encode(shifted)}, arcs(*POSE)) != ()


@pytest.mark.parametrize("shift_px", [8, 12, 25])
def test_a_camera_that_was_turned_is_told(small_bench, seen, arcs, kept, decode, encode, shift_px):
    moved = np.roll(decode(seen["left"]), shift_px, axis=0)
    assert kept({**seen, "left": encode(moved)}, arcs(*POSE)) != ()


def test_a_robot_of_another_length_is_flagged(small_bench, seen, look):
    assert look(small_bench.scene(length_mm=90.0), seen).flags
    assert look(small_bench.scene(length_mm=70.0), seen).flags


def test_a_tip_that_no_camera_sees_is_flagged(seen, arcs, kept, patched, project, small_bench):
    """A screen hides the last 15 mm from both cameras; the robot's length alone says how long it is."""
    truth = arcs(*POSE)
    hidden = seen
    for camera in small_bench.rig:
        corner = project(camera, truth[66:]).min(axis=0) - 15
        size = np.ptp(project(camera, truth[66:]), axis=0) + 30
        hidden = patched(hidden, camera.camera, corner.astype(int), size.astype(int))
    flags = kept(hidden, truth)
    assert flags is None or flags


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["gap", "screen", "dark thing"])
def test_hidden_stretches_and_strange_things_never_give_a_wrong_shape(
    small_bench, seen, before, arcs, kept, patched, project, seed, kind
):
    """A rectangle of backdrop or of the holder's colour over the robot, or a dark thing beside it; cold and warm."""
    rng = np.random.default_rng([seed, len(kind)])
    truth = arcs(*POSE)
    camera = small_bench.rig[int(rng.integers(2))]
    at = project(camera, truth[[int(rng.integers(15, 76))]])[0]
    size = rng.integers(8, 60, 2)
    if kind == "dark thing":
        at = at + rng.choice([-1, 1], 2) * rng.uniform(40, 120, 2)
    corner = (at - size / 2).astype(int)
    pictures = patched(seen, camera.camera, corner, size, None if kind == "gap" else HOLDER_BGR)
    kept(pictures, truth)
    kept(pictures, truth, before)
