"""What viewers draw: estimates and cameras in Foxglove's well-known schemas, written and never read back here."""

import dataclasses
from typing import Any, ClassVar, Self

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration as FoxgloveCalibration
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from google.protobuf.message import Message as ProtobufMessage

from messaging.checked import FloatArray
from messaging.control import ControllerState, Target
from messaging.frames import CameraCalibration
from messaging.message import Message, parse
from messaging.shape import ShapeEstimate

ROBOT_FRAME = "robot"
METRES_PER_MM = 1e-3

AXES, PARTS = ("x", "y", "z"), ("red", "green", "blue", "alpha")
POINT = np.dtype([*((axis, "<f4") for axis in AXES), *((part, "u1") for part in PARTS)])

Colour = tuple[int, int, int]
MEASURED: Colour = (88, 200, 255)
NODE: Colour = (232, 62, 86)
DESIRED: Colour = (126, 211, 112)
PATH: Colour = (196, 202, 206)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class View(Message):
    """A message in a well-known schema; `wire` is its protobuf object. Lengths are in m, as those schemas ask."""

    wire: Any

    def to_bytes(self) -> bytes:
        """The protobuf bytes."""
        data: bytes = self.wire.SerializeToString(deterministic=True)
        return data

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """The view in these bytes; raises CodecError."""
        return cls(wire=parse(cls.protobuf, data))


class CentrelineView(View):
    """A ShapeEstimate's centreline as foxglove.PointCloud."""

    protobuf: ClassVar[type[ProtobufMessage]] = PointCloud

    @classmethod
    def of(cls, estimate: ShapeEstimate) -> Self:
        """Points in the robot frame at the capture time."""
        return cls(wire=_cloud(estimate.centreline_mm, MEASURED, estimate.capture_time_ns))


class NodalPointsView(View):
    """A ShapeEstimate's nodal points as foxglove.PointCloud."""

    protobuf: ClassVar[type[ProtobufMessage]] = PointCloud

    @classmethod
    def of(cls, estimate: ShapeEstimate) -> Self:
        """Points in the robot frame at the capture time."""
        return cls(wire=_cloud(estimate.node_mm, NODE, estimate.capture_time_ns))


class TargetPathView(View):
    """The places that a Target leads its weighted nodal points through as foxglove.PointCloud."""

    protobuf: ClassVar[type[ProtobufMessage]] = PointCloud

    @classmethod
    def of(cls, target: Target, time_ns: int) -> Self:
        """Points in the robot frame, from the Unix time when the target was accepted."""
        places_mm = target.position_mm[:, target.weights > 0].reshape(-1, 3)
        return cls(wire=_cloud(places_mm, PATH, time_ns))


class DesiredPointsView(View):
    """Where a ControllerState's nodal points should be as foxglove.PointCloud."""

    protobuf: ClassVar[type[ProtobufMessage]] = PointCloud

    @classmethod
    def of(cls, state: ControllerState) -> Self:
        """Points in the robot frame at the time of the controller's cycle."""
        return cls(wire=_cloud(state.desired_mm, DESIRED, state.time_ns))


class CameraView(View):
    """A camera's intrinsics as foxglove.CameraCalibration."""

    protobuf: ClassVar[type[ProtobufMessage]] = FoxgloveCalibration

    @classmethod
    def of(cls, calibration: CameraCalibration, time_ns: int) -> Self:
        """K, distortion and size, as they are at this Unix time; the pose is a CameraPoseView."""
        wire = FoxgloveCalibration(
            frame_id=calibration.camera,
            width=calibration.width_px,
            height=calibration.height_px,
            distortion_model="plumb_bob",
            D=calibration.distortion,
            K=calibration.intrinsics.ravel(),
            R=np.eye(3).ravel(),
            P=np.hstack([calibration.intrinsics, np.zeros((3, 1))]).ravel(),
        )
        wire.timestamp.FromNanoseconds(time_ns)
        return cls(wire=wire)


class CameraPoseView(View):
    """A camera's pose in the robot frame as foxglove.FrameTransform."""

    protobuf: ClassVar[type[ProtobufMessage]] = FrameTransform

    @classmethod
    def of(cls, calibration: CameraCalibration, time_ns: int) -> Self:
        """The transform that takes camera coordinates to the robot frame, as it is at this Unix time."""
        from scipy.spatial.transform import Rotation  # noqa: PLC0415  imported late: slow, and only sensing needs it

        robot_from_camera = np.linalg.inv(calibration.camera_from_robot)
        wire = FrameTransform(parent_frame_id=ROBOT_FRAME, child_frame_id=calibration.camera)
        x, y, z = robot_from_camera[:3, 3] * METRES_PER_MM
        wire.translation.x, wire.translation.y, wire.translation.z = x, y, z
        x, y, z, w = Rotation.from_matrix(robot_from_camera[:3, :3]).as_quat()
        wire.rotation.x, wire.rotation.y, wire.rotation.z, wire.rotation.w = x, y, z, w
        wire.timestamp.FromNanoseconds(time_ns)
        return cls(wire=wire)


class LogLine(View):
    """A line of a process's log as foxglove.Log."""

    protobuf: ClassVar[type[ProtobufMessage]] = Log

    @classmethod
    def of(cls, *, time_ns: int, level: int, process: str, text: str) -> Self:
        """`level` is a number of Python's logging module (DEBUG 10 to CRITICAL 50)."""
        wire = Log(level=min(max(level // 10, 1), 5), message=text, name=process)  # type: ignore[arg-type]
        wire.timestamp.FromNanoseconds(time_ns)
        return cls(wire=wire)


def _cloud(points_mm: FloatArray, colour: Colour, time_ns: int) -> PointCloud:
    """Points (N, 3), each with its colour: without one, viewers paint every cloud alike, by height."""
    points = np.empty(len(points_mm), POINT)
    for axis, along_mm in zip(AXES, points_mm.T, strict=True):
        points[axis] = along_mm * METRES_PER_MM
    for part, value in zip(PARTS, (*colour, 255), strict=True):
        points[part] = value
    wire = PointCloud(frame_id=ROBOT_FRAME, point_stride=POINT.itemsize, data=points.tobytes())
    for number, axis in enumerate(AXES):
        wire.fields.add(name=axis, offset=4 * number, type=PackedElementField.FLOAT32)
    for number, part in enumerate(PARTS):
        wire.fields.add(name=part, offset=4 * len(AXES) + number, type=PackedElementField.UINT8)
    wire.pose.orientation.w = 1.0
    wire.timestamp.FromNanoseconds(time_ns)
    return wire
