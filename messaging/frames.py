"""Camera frames, and the cameras that take them."""

import dataclasses
from typing import ClassVar, Self

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from google.protobuf.message import Message as ProtobufMessage

from messaging.checked import Checked, FloatArray, array
from messaging.errors import InvalidMessageError
from messaging.message import Message, parse


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Frame(Message):
    """One camera's picture as the camera coded it (JPEG), with the Unix time of its capture."""

    protobuf: ClassVar[type[ProtobufMessage]] = CompressedImage

    camera: str
    capture_time_ns: int
    jpeg: bytes

    def to_bytes(self) -> bytes:
        """The bytes of a foxglove.CompressedImage around the camera's own JPEG bytes."""
        wire = CompressedImage(frame_id=self.camera, data=self.jpeg, format="jpeg")
        wire.timestamp.FromNanoseconds(self.capture_time_ns)
        return wire.SerializeToString(deterministic=True)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """The frame in a foxglove.CompressedImage; raises CodecError."""
        wire = parse(CompressedImage, data)
        return cls(camera=wire.frame_id, capture_time_ns=wire.timestamp.ToNanoseconds(), jpeg=wire.data)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class CameraCalibration(Checked):
    """One camera of the rig: OpenCV's pinhole model with lens distortion, and its pose in the robot frame.

    `intrinsics` is K (3, 3) in px; `distortion` (5,) is OpenCV's [k1, k2, p1, p2, k3]; integer pixel coordinates are
    pixel centres; `x_camera = camera_from_robot @ x_robot` on homogeneous points in mm. A matrix that is not a rigid
    transform, a focal length that is not positive or a size below 2 px raises InvalidMessageError.
    """

    camera: str
    width_px: int
    height_px: int
    intrinsics: FloatArray = array(3, 3)
    distortion: FloatArray = array(5)
    camera_from_robot: FloatArray = array(4, 4)

    def __post_init__(self) -> None:
        """Check what no camera can be; raises InvalidMessageError."""
        super().__post_init__()
        if min(self.width_px, self.height_px) < 2:
            raise InvalidMessageError(
                f"camera {self.camera}: size {self.width_px}x{self.height_px} px; both must be at least 2"
            )
        focal = self.intrinsics[0, 0], self.intrinsics[1, 1]
        if min(focal) <= 0 or not np.array_equal(self.intrinsics[2], [0, 0, 1]):
            raise InvalidMessageError(
                f"camera {self.camera}: intrinsics {self.intrinsics.tolist()} are not "
                "[[fx, s, cx], [0, fy, cy], [0, 0, 1]] with positive focal lengths"
            )
        rotation = self.camera_from_robot[:3, :3]
        rigid = np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3) and np.linalg.det(rotation) > 0
        if not rigid or not np.allclose(self.camera_from_robot[3], [0, 0, 0, 1]):
            raise InvalidMessageError(
                f"camera {self.camera}: camera_from_robot {self.camera_from_robot.tolist()} is not a rigid transform"
            )
