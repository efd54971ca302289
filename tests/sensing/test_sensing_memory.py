"""What sensing carries from set to set survives its bytes: whoever goes on from there estimates the same, bit for bit."""

import numpy as np
import pytest

from messaging.errors import CodecError
from messaging.shape import NodalPoints
from messaging.snapshot import freeze
from sensing.errors import MemoryMisfitError
from sensing.memory import SensingMemory, TrackMemory
from sensing.pictures.backdrop import Backdrop
from sensing.refined.method import Refined
from sensing.set_inputs import SetInputs
from sensing.step import Clocks, step

POINTS = NodalPoints(names=("middle", "tip"), arc_mm=np.array([40.0, 80.0]))
STILL = Clocks(stage_s=lambda: 0.0, age_ns=lambda: 0)
POSE, MOVED = (0.5, 0.4, 0.3, 0.4), (0.52, 0.41, 0.3, 0.38)


@pytest.fixture(scope="module")
def pictures(small_bench, arcs):
    return [small_bench.photograph(arcs(*pose)) for pose in (POSE, MOVED)]


def inputs(jpegs):
    return SetInputs(
        jpegs=jpegs, sequence=0, capture_time_ns=1, insertion_mm=0.0, base_known=True, points=POINTS
    )


def remembered(track):
    memory = None if track is None else TrackMemory.of(track)
    return SensingMemory.from_bytes(SensingMemory(track=memory, points=POINTS).to_bytes())


@pytest.fixture(scope="module")
def dimmer(without_robot, decode, encode, to_light, to_levels):
    """Background pictures taken when the lamp was weaker."""
    return {
        name: encode(to_levels(0.6 * to_light(decode(data))), ".png") for name, data in without_robot.items()
    }


@pytest.mark.parametrize("backdrop", ["fitted", "picture", "dimmer"])
def test_the_next_estimate_is_the_same_from_memory(small_bench, without_robot, dimmer, pictures, backdrop):
    taken = {"fitted": None, "picture": without_robot, "dimmer": dimmer}
    scene = small_bench.scene(taken[backdrop])
    first, track, _ = step(Refined(scene), inputs(pictures[0]), None, STILL)
    assert first.trusted
    memory = remembered(track)
    assert memory.points == POINTS
    assert bool(memory.track.surfaces) == (backdrop == "fitted")
    assert bool(memory.track.gains) == (backdrop == "dimmer")
    live, live_track, _ = step(Refined(scene), inputs(pictures[1]), track, STILL)
    again, track_again, _ = step(Refined(scene), inputs(pictures[1]), memory.track.track(scene), STILL)
    assert "cold_start" not in live.stage_names
    assert again.to_bytes() == live.to_bytes()
    assert freeze(TrackMemory.of(track_again)) == freeze(TrackMemory.of(live_track))


def test_nothing_seen_is_nothing_remembered(small_bench):
    grey = np.zeros((2, 2), np.uint8)
    refusal, track, _ = step(
        Refined(small_bench.scene()), inputs({"left": b"", "right": grey.tobytes()}), None, STILL
    )
    assert refusal.refusal
    assert track is None
    assert remembered(track).track is None


def test_a_fitted_backdrop_is_made_again_from_its_coefficients(small_bench, pictures):
    scene = small_bench.scene()
    _, track, _ = step(Refined(scene), inputs(pictures[0]), None, STILL)
    camera = scene.cameras[0]
    fitted = track.backdrops[camera.name]
    again = Backdrop.from_surface(fitted.surface, camera.size_px)
    assert np.array_equal(again.picture, fitted.picture)
    assert np.array_equal(again.luma, fitted.luma)


def test_a_memory_of_another_rig_is_refused(small_bench, pictures):
    _, track, _ = step(Refined(small_bench.scene()), inputs(pictures[0]), None, STILL)
    memory = remembered(track).track
    del memory.surfaces["right"]
    with pytest.raises(MemoryMisfitError, match="no backdrop of camera right"):
        memory.track(small_bench.scene())


def test_a_memory_of_something_else_is_refused():
    with pytest.raises(MemoryMisfitError, match="holds a NodalPoints, not sensing's memory"):
        SensingMemory.from_bytes(freeze(POINTS))
    with pytest.raises(CodecError, match="not a snapshot"):
        SensingMemory.from_bytes(b"")
