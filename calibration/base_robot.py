"""The robot frame from the robot itself: the stage's travel, where its midline begins, and which way its tendons bend it.

Z is the direction in which everything moves with the stage. The origin is where midlines of the known length begin, at the
place that the stage calls zero. The roll about Z is the one with which the robot bends towards most tendons by their known
angles, and exactly away from the others: their signs are wrong. A robot that is not straight at rest, or that hangs, does not disturb it, since both ends of each pull are compared.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.polynomial.polynomial import polyfit
from numpy.typing import NDArray

from calibration.base import Array, Base, Matrix4, Matrix6, PullFound, RobotFound
from calibration.errors import BasePosesError

LEAST_TRAVEL_MM = 5.0
LEAST_BEND_MM = 2.0
"""A pull that moves the tip by less says nothing of its direction: slack, friction and noise are as large."""
LEAST_PULLS = 2
LARGEST_OFF_DEG = 15.0
"""Pulls that disagree by more about the roll are not those of the tendons that they are said to be."""
LARGEST_SCALE_OFF = 0.03
"""The cameras see the stage's travel within this share, or one of them is wrong."""
TRAVEL_FLOOR_MM = 0.01
"""What the cameras see of a travel is no more exact than this: edges, lenses."""
START_FLOOR_MM = 0.03, 0.03, 0.1
"""Nor is the robot's beginning: across, and along the axis, where its length and its tip come in."""
ROLL_FLOOR_RAD = np.radians(0.1)
LEAN_RAD = np.radians(0.5)
"""How far aside of its axis a robot may leave its holder."""
BEGINNING = 0.3
"""The share of the midline that shows where and how it leaves its holder: single points next to the holder are seen worse."""


@dataclass(frozen=True, eq=False)
class Pose:
    """The midline (n, 3) in mm in the rig frame, from base to tip at even steps, while the stage stood at `insertion_mm`."""

    points_mm: Array
    insertion_mm: float = 0.0


@dataclass(frozen=True, eq=False)
class Pull:
    """One tendon or pair pulled to two ends of its way: `most` in the direction that bends the robot towards `angle_rad`.

    The angle is counted from X towards Y. `least` is the other end, or rest where a tendon cannot push.
    """

    name: str
    angle_rad: float
    least: tuple[Pose, ...]
    most: tuple[Pose, ...]


def base_from_robot(pulls: Sequence[Pull], travel: Sequence[Pose], residual_px: Mapping[str, float]) -> Base:
    """The robot frame from the bent robot, and from the unbent one at several places of its stage, if it has one.

    During the `travel` tendons keep their place; it is empty for a robot without a stage, where the direction in which the
    robot leaves its holder stands in. `residual_px` by camera is handed on; the residual in mm is that of where the midlines
    begin. Raises BasePosesError when the poses do not determine the frame or contradict it, also where a sign
    must be wrong and it cannot be told which.
    """
    poses = [*(pose for pull in pulls for pose in (*pull.least, *pull.most)), *travel]
    beginnings = [_beginning(pose) for pose in poses]
    leaving = _mean_direction([direction for _, direction in beginnings])
    stage = _travel(travel) if travel else _Travel(leaving, LEAN_RAD, 0.0, 1.0)
    if leaving @ stage.direction < 0.0:
        raise BasePosesError(
            "the stage says that it goes up while the robot goes down, back into its holder: "
            "servos.stage.mm_per_rad has the wrong sign"
        )
    lifts = [pose.insertion_mm * stage.direction for pose in poses]
    starts = np.array([start - lift for (start, _), lift in zip(beginnings, lifts, strict=True)])
    rough = _frame(stage.direction, starts.mean(axis=0))
    found, roll_rad, roll_sigma_rad = _roll(pulls, rough)
    turned = np.eye(4)
    turned[:2, :2] = [[np.cos(roll_rad), -np.sin(roll_rad)], [np.sin(roll_rad), np.cos(roll_rad)]]
    rig_from_robot = rough @ turned
    off_mm = (starts - starts.mean(axis=0)) @ rig_from_robot[:3, :3]
    sigma_mm = np.hypot(off_mm.std(axis=0) / np.sqrt(len(starts)), START_FLOOR_MM)
    tilt_rad = stage.sigma_rad / np.sqrt(2.0)
    variance = np.square([tilt_rad, tilt_rad, roll_sigma_rad, *sigma_mm])
    return Base(
        way="robot",
        rig_from_robot=msgspec.convert(rig_from_robot.tolist(), Matrix4),
        covariance=msgspec.convert(np.diag(variance).tolist(), Matrix6),
        residual_px=dict(residual_px),
        residual_mm=float(np.sqrt((off_mm**2).sum(axis=1).mean())),
        frame_sets=len(poses),
        robot=RobotFound(
            pulls=found,
            travel_mm=stage.range_mm,
            stage_scale=stage.scale,
            lean_deg=float(np.degrees(np.arccos(min(float(leaving @ stage.direction), 1.0)))),
        ),
    )


@dataclass(frozen=True)
class _Travel:
    """The unit direction (3,) of the stage, its standard deviation, how far it went, and what the cameras saw of it over that."""

    direction: Array
    sigma_rad: float
    range_mm: float
    scale: float


def _travel(poses: Sequence[Pose]) -> _Travel:
    """By regression of the robot's places on the stage's own, averaged along the midline."""
    place_mm = np.array([pose.insertion_mm for pose in poses])
    range_mm = float(np.ptp(place_mm))
    if range_mm < LEAST_TRAVEL_MM:
        raise BasePosesError(
            f"the stage was seen over {range_mm:.1f} mm of travel; {LEAST_TRAVEL_MM:g} mm are needed for the direction of Z"
        )
    points = np.array([pose.points_mm.mean(axis=0) for pose in poses])
    from_middle = place_mm - place_mm.mean()
    slope = from_middle @ points / (from_middle @ from_middle)
    scale = float(np.linalg.norm(slope))
    if abs(scale - 1.0) > LARGEST_SCALE_OFF:
        raise BasePosesError(
            f"the stage says that it went {range_mm:.1f} mm, and the cameras saw {scale * range_mm:.1f} mm: "
            "correct servos.stage.mm_per_rad, or the board's square_mm and calibrate the cameras anew"
        )
    off = points - points.mean(axis=0) - from_middle[:, None] * slope
    aside = off - np.outer(off @ slope, slope) / scale**2
    spread_mm = float(np.sqrt((aside**2).sum() / max(len(poses) - 2, 1)))
    sigma_rad = spread_mm / float(np.linalg.norm(from_middle))
    return _Travel(slope / scale, float(np.hypot(sigma_rad, 2 * TRAVEL_FLOOR_MM / range_mm)), range_mm, scale)


def _beginning(pose: Pose) -> tuple[Array, Array]:
    """Where a midline begins, and in which direction, (3,) each: of the cubic through its part next to the base."""
    count = max(round(BEGINNING * len(pose.points_mm)), 4)
    start, direction, *_ = polyfit(np.arange(count), pose.points_mm[:count], 3)
    return start, direction / np.linalg.norm(direction)


def _mean_direction(directions: Sequence[Array]) -> Array:
    total = np.sum(directions, axis=0)
    return np.asarray(total / np.linalg.norm(total))


def _frame(axis: Array, origin_mm: Array) -> Array:
    """A frame (4, 4) with this Z axis and origin, and any X."""
    aside = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(aside, axis)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.column_stack([x, np.cross(axis, x), axis])
    frame[:3, 3] = origin_mm
    return frame


def _roll(pulls: Sequence[Pull], rig_from_rough: Array) -> tuple[tuple[PullFound, ...], float, float]:
    """What each pull showed, the turn about Z from the rough frame that fits all of them best, and its standard deviation."""
    bends = [(pull, _bend(pull) @ rig_from_rough[:3, :2]) for pull in pulls]
    seen = [(pull, bend) for pull, bend in bends if np.linalg.norm(bend[-1]) >= LEAST_BEND_MM]
    if len(seen) < LEAST_PULLS:
        raise BasePosesError(
            f"{len(seen)} of {len(pulls)} tendons that were pulled moved the tip by {LEAST_BEND_MM:g} mm or more; "
            f"{LEAST_PULLS} are needed: take out their slack, or pull further"
        )
    turns = [complex(*bend.sum(axis=0)) * np.exp(-1j * pull.angle_rad) for pull, bend in seen]
    roll_rad, signs = _line(np.array(turns), [pull.name for pull, _ in seen])
    off_rad = np.angle(signs * turns * np.exp(-1j * roll_rad))
    if np.abs(off_rad).max() > np.radians(LARGEST_OFF_DEG):
        told = ", ".join(
            f"{pull.name} {off:+.0f}" for (pull, _), off in zip(seen, np.degrees(off_rad), strict=True)
        )
        raise BasePosesError(
            f"tendons do not bend the robot as their angles in controller.sections say; they are off by degrees: {told}; "
            "correct the angles, or what is wired to another place"
        )
    found = tuple(
        PullFound(
            name=pull.name,
            angle_deg=float(np.degrees(pull.angle_rad)),
            off_deg=float(np.degrees(off)),
            bend_mm=float(np.linalg.norm(bend[-1])),
            reversed=bool(sign < 0),
        )
        for (pull, bend), off, sign in zip(seen, off_rad, signs, strict=True)
    )
    sigma_rad = float(np.hypot(off_rad.std() / np.sqrt(len(off_rad) - 1), ROLL_FLOOR_RAD))
    return found, roll_rad, sigma_rad


def _line(turns: NDArray[np.complex128], names: Sequence[str]) -> tuple[float, Array]:
    """The roll that the turns (n,) agree on but for half a turn, and the sign (n,) with which each of them does.

    Most of them are taken to be right; raises BasePosesError where as many say one thing as the opposite.
    """
    roll_rad = float(np.angle((turns**2).sum()) / 2)
    signs = np.where((turns * np.exp(-1j * roll_rad)).real > 0, 1.0, -1.0)
    if signs.sum() == 0:
        one, other = (", ".join(np.array(names)[signs == sign]) for sign in (signs[0], -signs[0]))
        raise BasePosesError(
            f"{one} say that the robot stands one way round, {other} the opposite, so that the signs of either are wrong: turn "
            "mm_per_rad round for those that do not bend the robot towards their angle while `nodal do jog` pulls them"
        )
    return (roll_rad, signs) if signs.sum() > 0 else (roll_rad + np.pi, -signs)


def _bend(pull: Pull) -> Array:
    """How far (n, 3) the midline moved from the pull's least end to its most."""
    least, most = (np.mean([pose.points_mm for pose in end], axis=0) for end in (pull.least, pull.most))
    return np.asarray(most - least)
