"""Where the robot stands among the cameras, how well that is known, and whether two ways of finding it agree."""

from dataclasses import dataclass
from typing import Literal

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from calibration.camera_set import Row4

Array = NDArray[np.float64]
Row6 = tuple[float, float, float, float, float, float]
Matrix4 = tuple[Row4, Row4, Row4, Row4]
Matrix6 = tuple[Row6, Row6, Row6, Row6, Row6, Row6]
Way = Literal["board", "robot"]

ALLOWED_SIGMAS = 3.0


class PullFound(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What pulling one tendon or pair showed: where it should bend the robot to, and how far aside of that it did, in degrees."""

    name: str
    angle_deg: float
    off_deg: float
    bend_mm: float
    """How far the tip moved between both ends of the pull."""
    reversed: bool = False
    """Whether it bent the robot the opposite way, by most of the others; `off_deg` is from there then."""


class RobotFound(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What else was learnt on the way through the robot itself."""

    pulls: tuple[PullFound, ...]
    travel_mm: float = 0.0
    """How far the stage went; 0 for a robot without one."""
    stage_scale: float = 1.0
    """Travel that the cameras saw, over the stage's own."""
    lean_deg: float = 0.0
    """Between the axis and the direction in which the robot leaves its holder."""


class Base(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The robot frame in the rig frame, found one way: `x_rig = rig_from_robot @ x_robot` on homogeneous points in mm.

    `covariance` is that of a small motion of the robot frame, seen in it: rotations about x, y, z in rad, then shifts along
    x, y, z in mm. Residuals are RMS: in px by camera, and of what should be one place in space in mm.
    """

    way: Way
    rig_from_robot: Matrix4
    covariance: Matrix6
    residual_px: dict[str, float]
    residual_mm: float
    frame_sets: int
    robot: RobotFound | None = None
    made_at: str = ""
    """ISO 8601, UTC."""
    cameras_made_at: str = ""
    """When the cameras were calibrated in whose rig frame this is."""

    @property
    def matrix(self) -> Array:
        """`rig_from_robot` (4, 4)."""
        return np.array(self.rig_from_robot)

    @property
    def origin_sigma_mm(self) -> float:
        """Standard deviation of the origin's distance from where it is said to be."""
        return float(np.sqrt(np.trace(np.array(self.covariance)[3:, 3:])))

    @property
    def axis_sigma_rad(self) -> float:
        """Of the Z axis' direction."""
        return float(np.sqrt(np.trace(np.array(self.covariance)[:2, :2])))

    @property
    def roll_sigma_rad(self) -> float:
        """Of the turn about the Z axis."""
        return float(np.sqrt(self.covariance[2][2]))


class BasesFound(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What base.json holds: the newest result of each way, and which of them the rig was written with."""

    used: Way
    board: Base | None = None
    robot: Base | None = None


@dataclass(frozen=True)
class Difference:
    """How far two robot frames lie apart, and how far they may by their own uncertainties."""

    origin_mm: float
    axis_rad: float
    roll_rad: float
    allowed_origin_mm: float
    allowed_axis_rad: float
    allowed_roll_rad: float

    @property
    def too_large(self) -> tuple[str, ...]:
        """What disagrees: of `origin`, `axis` and `roll`."""
        judged = {
            "origin": (self.origin_mm, self.allowed_origin_mm),
            "axis": (self.axis_rad, self.allowed_axis_rad),
            "roll": (abs(self.roll_rad), self.allowed_roll_rad),
        }
        return tuple(name for name, (apart, allowed) in judged.items() if apart > allowed)


def difference(one: Base, other: Base) -> Difference:
    """From one to the other; the roll is positive where the other is turned from X towards Y."""
    apart = apart_from(one.matrix, other.matrix)
    return Difference(
        origin_mm=apart.origin_mm,
        axis_rad=apart.axis_rad,
        roll_rad=apart.roll_rad,
        allowed_origin_mm=ALLOWED_SIGMAS * float(np.hypot(one.origin_sigma_mm, other.origin_sigma_mm)),
        allowed_axis_rad=ALLOWED_SIGMAS * float(np.hypot(one.axis_sigma_rad, other.axis_sigma_rad)),
        allowed_roll_rad=ALLOWED_SIGMAS * float(np.hypot(one.roll_sigma_rad, other.roll_sigma_rad)),
    )


@dataclass(frozen=True)
class Apart:
    """Between two frames: their origins' distance, their Z axes' angle, and the turn that is left about Z."""

    origin_mm: float
    axis_rad: float
    roll_rad: float


def apart_from(one: Array, other: Array) -> Apart:
    """Between `rig_from_robot` (4, 4) and another."""
    motion = np.linalg.inv(one) @ other
    axis = np.cross([0.0, 0.0, 1.0], motion[:3, 2])
    size = float(np.linalg.norm(axis))
    tilt_rad = float(np.arctan2(size, motion[2, 2]))
    tilt = cv2.Rodrigues(tilt_rad * axis / max(size, 1e-12))[0]
    turn = tilt.T @ motion[:3, :3]
    return Apart(float(np.linalg.norm(motion[:3, 3])), tilt_rad, float(np.arctan2(turn[1, 0], turn[0, 0])))
