"""What sensing says: the robot's centreline and its nodal points, in the robot frame."""

import dataclasses
from enum import StrEnum
from typing import ClassVar

import numpy as np
from google.protobuf.message import Message as ProtobufMessage

from messaging.checked import FloatArray, array, items
from messaging.errors import InvalidMessageError
from messaging.generated import nodal_pb2
from messaging.message import Message


class Flag(StrEnum):
    """Why an estimate must not be taken at face value. The vocabulary is fixed: a flag outside it is refused."""

    EPIPOLAR_TANGENCY = "epipolar_tangency"
    """A stretch runs along the epipolar direction, so its depth rests on smoothness and length."""
    MERGED_SILHOUETTE = "merged_silhouette"
    """A camera sees robot where the fitted tube is not: it covers itself, something touches it, or the fit went astray."""
    TIP_UNSEEN = "tip_unseen"
    """Fewer than two cameras see where the robot ends, or its end looks like no tip."""
    LENGTH_MISMATCH = "length_mismatch"
    """The measured length is not the robot's."""
    LARGE_RESIDUAL = "large_residual"
    """The curve does not explain the pictures."""
    LARGE_RAY_GAP = "large_ray_gap"
    """The cameras contradict one another."""
    CALIBRATION_OFF = "calibration_off"
    """The cameras contradict one another in a systematic way: one was moved, or the calibration is off."""
    OUT_OF_VIEW = "out_of_view"
    """A part of the robot lies outside of a camera's picture."""
    HIDDEN = "hidden"
    """Something hides a part of the robot from a camera."""
    CAMERA_LOST = "camera_lost"
    """A camera gave no picture that can be used; the others carry the estimate."""
    BASE_UNKNOWN = "base_unknown"
    """The stage's position at capture is not known; the last known one was used."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ShapeEstimate(Message):
    """The robot's shape in one frame set; with a `refusal`, every array is empty and the reason is in words.

    `method` is the way it was found. `arc_mm` is the distance from the base along `centreline_mm`, `epipolar_angle_rad`
    the centreline's angle at each of these points to the epipolar direction of the two cameras that tell most: at 0 its
    depth rests on what is known beforehand. `length_mm` is measured, `known_length_mm` what the robot should have (0: not
    known), `visible_mm` the length that each camera sees, `camera_residual_px` the RMS distance between the reprojected
    centreline and that camera's midline, `residual_px` over all of them. `ray_gap_mm` is the mean gap between paired
    rays, `ray_bias_mm` by how much one camera's picture seems to lie elsewhere than its calibration says; `insertion_mm`
    the height of the base along +Z. `capture_time_ns` is Unix time; `capture_to_publish_ns` is measured on one monotonic
    clock, so a receiver can judge age without trusting another host's clock. Recordings of older versions hold no method,
    no angles, and nothing by camera.
    """

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.ShapeEstimate

    sequence: int
    capture_time_ns: int
    capture_to_publish_ns: int
    refusal: str
    method: str
    flags: tuple[str, ...] = items("flag")
    arc_mm: FloatArray = array("point")
    centreline_mm: FloatArray = array("point", 3)
    epipolar_angle_rad: FloatArray = array("angle")
    node_names: tuple[str, ...] = items("node")
    node_arc_mm: FloatArray = array("node")
    node_mm: FloatArray = array("node", 3)
    node_covariance_mm2: FloatArray = array("node", 3, 3)
    length_mm: float
    known_length_mm: float
    insertion_mm: float
    ray_gap_mm: float
    ray_bias_mm: float
    residual_px: float
    camera_names: tuple[str, ...] = items("camera")
    camera_residual_px: FloatArray = array("camera")
    visible_mm: FloatArray = array("camera")
    stage_names: tuple[str, ...] = items("stage")
    stage_s: FloatArray = array("stage")

    def __post_init__(self) -> None:
        """Check the flags' vocabulary too."""
        super().__post_init__()
        if unknown := set(self.flags) - set(Flag):
            raise InvalidMessageError(
                f"ShapeEstimate.flags holds {sorted(unknown)}; known are {', '.join(Flag)}"
            )

    @property
    def trusted(self) -> bool:
        """True when there is a shape and nothing speaks against it."""
        return not self.refusal and not self.flags


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Truth(Message):
    """The simulated robot's true centreline at the frame set's mean capture time, for reports only."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.Truth

    capture_time_ns: int
    arc_mm: FloatArray = array("point")
    centreline_mm: FloatArray = array("point", 3)
    insertion_mm: float


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class NodalPoints(Message):
    """Points on the centreline that the user named by their distance from the base: increasing, not negative."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.NodalPoints

    names: tuple[str, ...] = items("node")
    arc_mm: FloatArray = array("node")

    def __post_init__(self) -> None:
        """Refuse what cannot name a point; raises InvalidMessageError."""
        super().__post_init__()
        if not self.names:
            raise InvalidMessageError("nodal points: none given; at least one is needed")
        if len(set(self.names)) != len(self.names) or "" in self.names:
            raise InvalidMessageError(
                f"nodal points: names {list(self.names)} must be different and not empty"
            )
        if self.arc_mm[0] < 0 or (np.diff(self.arc_mm) <= 0).any():
            raise InvalidMessageError(
                f"nodal points: distances {self.arc_mm.tolist()} mm must increase from 0 or more"
            )
