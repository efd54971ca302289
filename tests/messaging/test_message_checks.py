"""What does not fit a message is refused, with words that help."""

import dataclasses

import numpy as np
import pytest
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField

from messaging.control import Action, ActionRequest, ControllerState, State, Target, TendonCommand
from messaging.errors import CodecError, InvalidMessageError
from messaging.frames import CameraCalibration, Frame
from messaging.generated import nodal_pb2
from messaging.shape import Flag, NodalPoints, ShapeEstimate, Truth
from messaging.views import CameraPoseView, CameraView, CentrelineView, LogLine, NodalPointsView

ESTIMATE = ShapeEstimate(
    sequence=7,
    capture_time_ns=1_700_000_000_000_000_000,
    capture_to_publish_ns=9_000_000,
    refusal="",
    method="refined",
    flags=(),
    arc_mm=[0, 40, 80],
    centreline_mm=[[0, 0, 10], [1, 2, 50], [3, 4, 88]],
    epipolar_angle_rad=[0.1, 0.2, 0.3],
    node_names=("middle", "tip"),
    node_arc_mm=[40, 80],
    node_mm=[[1, 2, 50], [3, 4, 88]],
    node_covariance_mm2=[np.eye(3), 2 * np.eye(3)],
    length_mm=80.0,
    known_length_mm=80.0,
    insertion_mm=10.0,
    ray_gap_mm=0.05,
    ray_bias_mm=0.0,
    residual_px=0.3,
    camera_names=("left", "right"),
    camera_residual_px=[0.2, 0.4],
    visible_mm=[80.0, 70.0],
    stage_names=("decode",),
    stage_s=[0.004],
)

CALIBRATION = CameraCalibration(
    camera="left",
    width_px=1920,
    height_px=1080,
    intrinsics=[[1400, 0, 960], [0, 1400, 540], [0, 0, 1]],
    distortion=[0.1, 0, 0, 0, 0],
    camera_from_robot=[[1, 0, 0, 0], [0, 0, -1, 100], [0, 1, 0, 200], [0, 0, 0, 1]],
)


def test_arrays_are_read_only_float64():
    command = TendonCommand(
        time_ns=0, displacement_mm=[1, 2], insertion_mm=0.0, shape_sequence=0, capture_to_command_ns=-1
    )
    assert command.displacement_mm.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        command.displacement_mm[0] = 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"centreline_mm": [[0, 0, 0]]}, ["ShapeEstimate.centreline_mm", "(1, 3)", "point"]),
        ({"arc_mm": [[0, 1, 2]]}, ["ShapeEstimate.arc_mm", "(1, 3)"]),
        ({"node_mm": [[0, 0, float("nan")], [0, 0, 0]]}, ["ShapeEstimate.node_mm", "finite"]),
        ({"node_names": ("tip",)}, ["node_arc_mm", "(2,)"]),
        ({"length_mm": float("inf")}, ["ShapeEstimate.length_mm", "inf"]),
        ({"stage_s": ["fast"]}, ["ShapeEstimate.stage_s", "numbers"]),
        ({"flags": ("fine",)}, ["fine", Flag.TIP_UNSEEN]),
    ],
)
def test_what_does_not_fit_its_shape_is_named(changes, words):
    with pytest.raises(InvalidMessageError) as refused:
        dataclasses.replace(ESTIMATE, **changes)
    assert all(word in str(refused.value) for word in words)


def test_numbers_that_fill_no_shape_are_refused():
    wire = nodal_pb2.Truth(arc_mm=[0, 1], centreline_mm=[0] * 5)
    with pytest.raises(CodecError, match=r"Truth\.centreline_mm carries 5 numbers"):
        Truth.from_bytes(wire.SerializeToString())


def test_an_unknown_word_is_refused_with_those_known():
    with pytest.raises(CodecError, match=r"ActionRequest\.action is 'jump'; known are home, arm"):
        ActionRequest.from_bytes(nodal_pb2.ActionRequest(action="jump").SerializeToString())


def test_a_state_comes_back_as_a_state():
    wire = nodal_pb2.ControllerState(state="hold")
    assert ControllerState.from_bytes(wire.SerializeToString()).state is State.HOLD
    assert ActionRequest.from_bytes(ActionRequest(action=Action.ARM).to_bytes()).action is Action.ARM


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"names": ()}, "none given"),
        ({"names": ("a", "a")}, "different"),
        ({"names": ("a", "")}, "not empty"),
        ({"arc_mm": [20, 10]}, "increase"),
        ({"arc_mm": [-1, 10]}, "0 or more"),
    ],
)
def test_bad_nodal_points_are_refused(changes, words):
    values = {"names": ("a", "b"), "arc_mm": [10, 20]} | changes
    if not values["names"]:
        values["arc_mm"] = []
    with pytest.raises(InvalidMessageError, match=words):
        NodalPoints(**values)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"node_names": ("tip", "tip"), "weights": [1, 1], "position_mm": np.zeros((2, 2, 3))}, "once each"),
        ({"time_s": [1, 2]}, "start at 0"),
        ({"time_s": [0, 0]}, "increase"),
        ({"weights": [0]}, "one above 0"),
        ({"weights": [-1]}, "0 or more"),
        ({"position_mm": np.full((2, 1, 3), np.nan)}, "finite"),
        ({"position_mm": np.zeros((1, 1, 3))}, "shape"),
        ({"repeat_from_s": 0.7}, "repeats from 0.7 s; that must be a moment of the path before its last"),
    ],
)
def test_targets_that_nothing_could_follow_are_refused(changes, words):
    values = {
        "name": "line",
        "node_names": ("tip",),
        "weights": [1],
        "time_s": [0, 1],
        "position_mm": np.zeros((2, 1, 3)),
        "repeat": False,
    }
    with pytest.raises(InvalidMessageError, match=words):
        Target(**values | changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"width_px": 1}, "1x1080"),
        ({"intrinsics": np.diag([-1400, 1400, 1])}, "focal"),
        ({"intrinsics": np.eye(2)}, "shape"),
        ({"camera_from_robot": np.diag([2, 2, 2, 1])}, "rigid"),
        ({"camera_from_robot": np.diag([1, 1, -1, 1])}, "rigid"),
    ],
)
def test_cameras_that_cannot_be_are_refused(changes, words):
    with pytest.raises(InvalidMessageError, match=words):
        dataclasses.replace(CALIBRATION, **changes)


def test_a_frame_keeps_the_cameras_own_bytes():
    jpeg = bytes(range(256))
    frame = Frame(camera="left", capture_time_ns=1_700_000_000_123_456_789, jpeg=jpeg)
    assert Frame.from_bytes(frame.to_bytes()).jpeg == jpeg
    assert Frame.from_bytes(frame.to_bytes()).capture_time_ns == 1_700_000_000_123_456_789


WIRE_TYPES = {PackedElementField.FLOAT32: "<f4", PackedElementField.UINT8: "u1"}


def test_views_are_in_metres_and_survive_their_bytes():
    for view, points_mm in ((CentrelineView, ESTIMATE.centreline_mm), (NodalPointsView, ESTIMATE.node_mm)):
        cloud = view.from_bytes(view.of(ESTIMATE).to_bytes()).wire
        columns = {
            field.name: np.ndarray(
                len(points_mm), WIRE_TYPES[field.type], cloud.data, field.offset, (cloud.point_stride,)
            )
            for field in cloud.fields
        }
        assert np.column_stack([columns[axis] for axis in "xyz"]) == pytest.approx(points_mm / 1000)
        assert set(columns["alpha"]) == {255}
    camera = CameraView.from_bytes(CameraView.of(CALIBRATION, 7).to_bytes()).wire
    assert (camera.width, camera.height, camera.K[2]) == (1920, 1080, 960)
    pose = CameraPoseView.from_bytes(CameraPoseView.of(CALIBRATION, 7).to_bytes()).wire
    camera_mm = -CALIBRATION.camera_from_robot[:3, :3].T @ CALIBRATION.camera_from_robot[:3, 3]
    moved_m = pose.translation.x, pose.translation.y, pose.translation.z
    assert moved_m == pytest.approx(camera_mm / 1000)
    assert camera.timestamp.ToNanoseconds() == pose.timestamp.ToNanoseconds() == 7


@pytest.mark.parametrize(("level", "wire"), [(0, 1), (10, 1), (20, 2), (30, 3), (40, 4), (50, 5), (90, 5)])
def test_log_levels_are_those_of_foxglove(level, wire):
    line = LogLine.of(time_ns=1, level=level, process="sense", text="hello").wire
    assert (line.level, line.name, line.message) == (wire, "sense", "hello")


def test_an_estimate_is_trusted_only_without_flag_and_refusal():
    assert ESTIMATE.trusted
    assert not dataclasses.replace(ESTIMATE, flags=(Flag.TIP_UNSEEN,)).trusted
    assert not dataclasses.replace(ESTIMATE, refusal="no robot in view").trusted


def test_tuples_of_numbers_become_arrays():
    points = NodalPoints(names=("a", "b"), arc_mm=(10, 20))
    assert isinstance(points.arc_mm, np.ndarray)
    assert not points.arc_mm.flags.writeable
