"""What sensing remembers between frame sets, and the messages it makes."""

import numpy as np
import pytest

from messaging.control import TendonState
from messaging.shape import Flag, NodalPoints, ShapeEstimate
from sensing.errors import NodalPointError
from sensing.refined.method import Refined
from sensing.reporting import refusal_message
from sensing.sensor import Sensor
from sensing.set_inputs import SetInputs

POSE = (0.5, 0.4, 0.3, 0.4)
NOW_NS = 1_780_000_000_000_000_000
MIDDLE_AND_TIP = NodalPoints(names=("middle", "tip"), arc_mm=np.array([40.0, 80.0]))


def at_height(insertion_mm, time_ns=NOW_NS):
    return TendonState(
        time_ns=time_ns,
        displacement_mm=np.zeros(4),
        displacement_mm_s=np.zeros(4),
        insertion_mm=insertion_mm,
        insertion_mm_s=0.0,
        current_ma=np.zeros(5),
        temperature_c=np.zeros(5),
        voltage_v=np.zeros(5),
        hardware_error=np.zeros(5),
        torque=True,
    )


@pytest.fixture(scope="module")
def seen(small_bench, arcs):
    return small_bench.photograph(arcs(*POSE))


@pytest.fixture
def sensor(small_bench):
    return Sensor(Refined(small_bench.scene()), MIDDLE_AND_TIP, 80.0, 0.5)


def sense(sensor, pictures, sequence=7):
    return sensor.estimate(pictures, sequence, NOW_NS, lambda: 12_000_000)


def test_an_estimate_says_when_where_and_how_well(sensor, seen, arcs):
    sensor.heard(at_height(0.0))
    estimate = sense(sensor, seen)
    assert estimate.trusted
    assert (estimate.sequence, estimate.capture_time_ns, estimate.capture_to_publish_ns) == (
        7,
        NOW_NS,
        12_000_000,
    )
    assert estimate.node_names == ("middle", "tip")
    assert estimate.node_arc_mm.tolist() == [40.0, 80.0]
    truth = arcs(*POSE)
    assert np.abs(estimate.node_mm - truth[[40, 80]]).max() < 0.3
    assert estimate.node_covariance_mm2.shape == (2, 3, 3)
    assert (np.linalg.eigvalsh(estimate.node_covariance_mm2) > 0).all()
    assert estimate.arc_mm[-1] == estimate.length_mm == pytest.approx(80, abs=0.3)
    assert len(estimate.centreline_mm) == len(estimate.arc_mm)
    assert estimate.insertion_mm == 0
    assert set(estimate.stage_names) == {"decode", "backdrop", "cold_start", "refine", "judge"}
    # seconds, on whatever machine: not ms and not ns
    assert (estimate.stage_s > 0).all()
    assert estimate.stage_s.sum() < 60
    assert ShapeEstimate.from_bytes(estimate.to_bytes()) == estimate


def test_without_stage_reports_the_base_is_unknown(sensor, seen):
    assert Flag.BASE_UNKNOWN in sense(sensor, seen).flags
    sensor.heard(at_height(0.0, NOW_NS - 2_000_000_000))
    assert Flag.BASE_UNKNOWN in sense(sensor, seen).flags
    sensor.heard(at_height(0.0))
    assert sense(sensor, seen).flags == ()


def test_the_stage_lifts_the_base(sensor, small_bench, arcs):
    sensor.heard(at_height(12.0))
    estimate = sense(sensor, small_bench.photograph(arcs(*POSE, insertion_mm=12.0)))
    assert estimate.flags == ()
    assert estimate.insertion_mm == 12
    assert estimate.centreline_mm[0] == pytest.approx([0, 0, 12], abs=0.05)
    assert np.abs(estimate.node_mm - arcs(*POSE, insertion_mm=12.0)[[40, 80]]).max() < 0.3


def test_a_shape_is_followed_and_a_bad_frame_loses_nothing(sensor, seen):
    sensor.heard(at_height(0.0))
    first, second = sense(sensor, seen), sense(sensor, seen, 8)
    assert "cold_start" in first.stage_names
    assert "cold_start" not in second.stage_names
    bad = sense(sensor, {**seen, "right": seen["right"][:5000]}, 9)
    assert bad.refusal.startswith("camera right: the JPEG of 5000 bytes is cut off")
    assert not bad.trusted
    assert bad.sequence == 9
    assert len(bad.centreline_mm) == len(bad.node_mm) == 0
    third = sense(sensor, seen, 10)
    assert third.trusted
    assert "cold_start" not in third.stage_names
    assert np.abs(third.node_mm - first.node_mm).max() < 0.05


def test_a_robot_that_was_not_there_is_found_anew(sensor, seen, without_robot):
    sensor.heard(at_height(0.0))
    first = sense(sensor, seen)
    assert sense(sensor, without_robot, 8).refusal
    assert sensor.memory.track is None
    third = sense(sensor, seen, 9)
    assert "cold_start" in third.stage_names
    assert np.abs(third.node_mm - first.node_mm).max() == 0


@pytest.mark.parametrize("damage", ["empty", "words", "black", "other size"])
def test_a_bad_frame_is_a_refusal_that_names_the_camera(sensor, seen, encode, damage):
    frame = {
        "empty": b"",
        "words": b"not a picture",
        "black": encode(np.zeros((540, 960, 3))),
        "other size": encode(np.zeros((480, 640, 3))),
    }[damage]
    estimate = sense(sensor, {**seen, "left": frame})
    assert estimate.refusal.startswith("camera left: ")
    assert ShapeEstimate.from_bytes(estimate.to_bytes()) == estimate


@pytest.mark.parametrize("hidden_from_px", [430, 455, 480])
def test_a_view_in_which_the_curve_is_nowhere_seen_is_refused_and_not_a_broken_message(
    sensor, seen, decode, encode, hidden_from_px
):
    """Half of a picture is black: the robot seems to be a wall."""
    picture = decode(seen["left"])
    picture[:, hidden_from_px:] = 0
    estimate = sense(sensor, {**seen, "left": encode(picture)})
    assert not estimate.trusted
    assert np.isfinite(estimate.ray_gap_mm)


def test_a_refusal_carries_the_height_and_nothing_else(small_bench):
    inputs = SetInputs(
        jpegs={},
        sequence=3,
        capture_time_ns=NOW_NS,
        insertion_mm=4.0,
        base_known=True,
        points=MIDDLE_AND_TIP,
    )
    message = refusal_message(NodalPointError("why"), inputs, Refined(small_bench.scene()), 5)
    assert message.refusal == "why"
    assert message.insertion_mm == 4
    assert message.flags == (Flag.CAMERA_LOST,)
    assert message.node_names == message.stage_names == ()
    assert len(message.arc_mm) == 0


def test_nodal_points_are_changed_while_running(sensor, seen):
    sensor.heard(at_height(0.0))
    sense(sensor, seen)
    sensor.name_points(NodalPoints(names=("a", "b", "c"), arc_mm=np.array([10.0, 20.5, 79.0])))
    estimate = sense(sensor, seen)
    assert estimate.node_names == ("a", "b", "c")
    assert estimate.node_arc_mm.tolist() == [10.0, 20.5, 79.0]
    assert estimate.node_mm.shape == (3, 3)


def test_a_nodal_point_beyond_the_robot_is_refused_and_the_old_ones_stay(sensor, seen):
    with pytest.raises(
        NodalPointError, match=r"nodal point far at 81 mm is beyond the robot; allowed are 0 to 80 mm"
    ):
        sensor.name_points(NodalPoints(names=("far",), arc_mm=np.array([81.0])))
    assert sense(sensor, seen).node_names == ("middle", "tip")


def test_a_sensor_is_not_made_with_points_beyond_the_robot(small_bench):
    with pytest.raises(
        NodalPointError, match="nodal point tip at 80 mm is beyond the robot; allowed are 0 to 60 mm"
    ):
        Sensor(Refined(small_bench.scene()), MIDDLE_AND_TIP, 60.0, 0.5)
