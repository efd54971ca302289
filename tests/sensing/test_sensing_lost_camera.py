"""Three cameras of which one gives no picture that can be used: the two others carry the estimate, and it is flagged."""

import numpy as np
import pytest

from messaging.shape import Flag, NodalPoints
from sensing.memory import SensingMemory
from sensing.refined.method import Refined
from sensing.scene import Scene
from sensing.sensor import Sensor
from sensing.set_inputs import SetInputs
from sensing.step import Clocks, step

POINTS = NodalPoints(names=("middle", "tip"), arc_mm=np.array([40.0, 80.0]))
STILL = Clocks(stage_s=lambda: 0.0, age_ns=lambda: 0)
POSE = (0.7, 0.4, 0.6, 2.4)


@pytest.fixture(scope="module")
def three(bench, third_camera, arcs):
    points = arcs(*POSE)
    return bench.photograph(points) | third_camera.photograph(points)


@pytest.fixture(scope="module")
def scene(bench, third_camera):
    return Scene.of((*bench.rig, *third_camera.rig), length_mm=80.0)


@pytest.fixture(scope="module")
def track(scene, three):
    return stepped(scene, three).track


def stepped(scene, jpegs, before=None):
    inputs = SetInputs(
        jpegs=jpegs, sequence=4, capture_time_ns=1, insertion_mm=0.0, base_known=True, points=POINTS
    )
    return step(Refined(scene), inputs, before, STILL)


def middle_missing(jpeg):
    """Found out only when it is decoded."""
    middle = len(jpeg) // 2
    return jpeg[:middle] + jpeg[middle + 90 :]


DAMAGES = {
    "nothing": lambda _: None,
    "empty": lambda _: b"",
    "cut": lambda jpeg: jpeg[:4000],
    "data missing": middle_missing,
}


def damaged(three, camera, damage):
    frame = DAMAGES[damage](three[camera])
    return {name: jpeg for name, jpeg in {**three, camera: frame}.items() if jpeg is not None}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("warm", [False, True], ids=["cold", "warm"])
def test_the_others_carry_on(scene, three, track, arcs, damage, warm, capfd):
    estimate, _, lost = stepped(scene, damaged(three, "right", damage), track if warm else None)
    assert estimate.refusal == ""
    assert Flag.CAMERA_LOST in estimate.flags
    assert estimate.camera_names == ("left", "above")
    assert np.abs(estimate.node_mm - arcs(*POSE)[[40, 80]]).max() < 0.5
    assert list(lost) == ["right"]
    assert lost["right"].startswith("camera right: ")


def test_the_estimate_is_that_of_a_rig_without_the_camera(scene, three, bench, third_camera):
    """But for the flag."""
    estimate, _, _ = stepped(scene, damaged(three, "right", "nothing"))
    smaller = Scene.of((bench.rig[0], *third_camera.rig), length_mm=80.0)
    alone, _, lost = stepped(smaller, {name: three[name] for name in ("left", "above")})
    assert not lost
    assert np.array_equal(estimate.node_mm, alone.node_mm)
    assert np.array_equal(estimate.node_covariance_mm2, alone.node_covariance_mm2)
    assert set(estimate.flags) == {*alone.flags, Flag.CAMERA_LOST}


def test_two_that_are_lost_are_a_refusal_that_says_why(scene, three, track):
    estimate, after, _ = stepped(scene, {"left": three["left"], "right": b""}, track)
    assert estimate.refusal == "camera right: the picture is empty (0 bytes)"
    assert estimate.flags == (Flag.CAMERA_LOST,)
    assert after is track
    estimate, after, _ = stepped(scene, {"left": three["left"]}, track)
    assert after is None
    assert estimate.refusal == (
        "camera right: no frame in this set; camera above: no frame in this set; "
        "two cameras at least must see the robot"
    )


@pytest.mark.parametrize("found_with_all", [True, False])
def test_a_camera_that_comes_back_is_used_again(scene, three, track, found_with_all):
    before = track if found_with_all else None
    found = stepped(scene, damaged(three, "right", "cut"), before)
    back = stepped(scene, three, found.track)
    assert back.estimate.trusted
    assert back.estimate.camera_names == ("left", "right", "above")
    assert ("cold_start" in back.estimate.stage_names) == (not found_with_all)


@pytest.mark.parametrize("found_with_all", [True, False])
def test_what_is_remembered_goes_through_its_bytes(scene, three, found_with_all):
    sensor = Sensor(Refined(scene), POINTS, 80.0, 0.5)
    first = three if found_with_all else damaged(three, "right", "cut")
    sensor.estimate(first, 0, 1, lambda: 0)
    sensor.estimate(damaged(three, "right", "cut"), 1, 2, lambda: 0)
    assert list(sensor.lost) == ["right"]
    memory = SensingMemory.from_bytes(sensor.memory.to_bytes())
    live = sensor.estimate(damaged(three, "left", "nothing"), 2, 3, lambda: 0)
    again = stepped(scene, damaged(three, "left", "nothing"), memory.track.track(scene)).estimate
    assert np.array_equal(again.node_mm, live.node_mm)
    assert again.camera_names == live.camera_names == ("right", "above")
