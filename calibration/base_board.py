"""The robot frame from the board in its fixture at the base: the board's pose from all cameras at once."""

from collections.abc import Mapping, Sequence

import msgspec
import numpy as np

from calibration.base import Array, Base, Matrix4, Matrix6
from calibration.camera_set import CalibratedCamera, CameraSet
from calibration.corners import Corners
from calibration.errors import ViewsError
from calibration.posing import board_pose, off_px
from calibration.projection import INTRINSICS, POSE, by_pose, project, transformed
from calibration.rig import BoardShape, Observation, Rig

LEAST_CORNERS = 8
"""Of each camera: fewer lie in one corner of the board, and tell little about where the others are."""
LEAST_SHARE = 0.5
"""A corner counts that is found in at least so many of a camera's pictures."""
FLOOR_PX = 0.02
"""No corner is better known than this, however many pictures are averaged."""


def base_from_board(
    cameras: CameraSet, sets: Sequence[Mapping[str, Corners]], points_mm: Array, robot_from_board: Array
) -> Base:
    """The robot frame, from the corners by camera of sets of pictures of the board that stood still.

    `points_mm` (n, 3) are all corners on the board by their ids; `robot_from_board` (4, 4) is where the fixture holds it.
    The covariance is that of the corners and, where the cameras' parameters have standard deviations, of those; they are
    taken as independent, which makes it larger than it is. Raises ViewsError when a camera does not see the board.
    """
    rig = _rig(cameras, points_mm)
    seen = [_averaged(number, camera.name, sets, points_mm) for number, camera in enumerate(cameras.cameras)]
    rig_from_board = board_pose(rig, seen)
    rig_from_robot = rig_from_board @ np.linalg.inv(robot_from_board)
    off = [off_px(rig, rig_from_board, one) for one in seen]
    covariance = _covariance(cameras, rig, seen, rig_from_board, float(np.mean(np.concatenate(off) ** 2)))
    carried = _carried(rig_from_board, rig_from_robot)
    names = [camera.name for camera in cameras.cameras]
    return Base(
        way="board",
        rig_from_robot=msgspec.convert(rig_from_robot.tolist(), Matrix4),
        covariance=msgspec.convert((carried @ covariance @ carried.T).tolist(), Matrix6),
        residual_px={name: _rms(one) for name, one in zip(names, off, strict=True)},
        residual_mm=_rms(
            np.concatenate([_in_mm(rig, rig_from_board, one, px) for one, px in zip(seen, off, strict=True)])
        ),
        frame_sets=len(sets),
    )


def _rig(cameras: CameraSet, points_mm: Array) -> Rig:
    return Rig(
        intrinsics=np.array([_intrinsics(camera) for camera in cameras.cameras]),
        camera_from_rig=np.array([camera.camera_from_rig for camera in cameras.cameras]),
        rig_from_board=np.empty((0, 4, 4)),
        board=BoardShape.of(points_mm, cameras.board_shape),
    )


def _intrinsics(camera: CalibratedCamera) -> list[float]:
    (fx, _, cx), (_, fy, cy), _ = camera.intrinsics
    return [fx, fy, cx, cy, *camera.distortion]


def _averaged(
    number: int, camera: str, sets: Sequence[Mapping[str, Corners]], points_mm: Array
) -> Observation:
    """The corners that a camera saw in most of its pictures, each where it was on average."""
    found = [seen[camera] for seen in sets if camera in seen]
    count, total = np.zeros(len(points_mm)), np.zeros((len(points_mm), 2))
    for corners in found:
        count[corners.ids] += 1
        total[corners.ids] += corners.px
    ids = np.flatnonzero(count >= max(LEAST_SHARE * len(found), 1))
    if len(ids) < LEAST_CORNERS:
        raise ViewsError(
            f"camera {camera} sees {len(ids)} corners of the board at the base; {LEAST_CORNERS} are needed"
        )
    return Observation(
        camera=number, view=0, ids=ids, points_mm=points_mm[ids], px=total[ids] / count[ids, None]
    )


def _covariance(
    cameras: CameraSet, rig: Rig, seen: Sequence[Observation], rig_from_board: Array, variance_px2: float
) -> Array:
    """Of the board's pose (6, 6), as `projection.moved` takes its steps."""
    by_step, by_camera = [], []
    for one in seen:
        camera_from_rig, at_rig_mm = (
            rig.camera_from_rig[one.camera],
            transformed(rig_from_board, one.points_mm),
        )
        _, by_point, by_intrinsics = project(
            rig.intrinsics[one.camera], transformed(camera_from_rig, at_rig_mm)
        )
        by_board = by_point @ camera_from_rig[:3, :3] @ by_pose(rig_from_board, one.points_mm)
        by_step.append(by_board.reshape(-1, 6))
        by_own = np.concatenate([by_intrinsics, by_point @ by_pose(camera_from_rig, at_rig_mm)], axis=2)
        by_camera.append(by_own.reshape(len(by_step[-1]), -1))
    jacobian = np.concatenate(by_step)
    covariance = max(variance_px2, FLOOR_PX**2) * np.linalg.inv(jacobian.T @ jacobian)
    starts = np.cumsum([0, *(len(rows) for rows in by_step)])
    back = np.linalg.pinv(jacobian)
    for camera, own, begin, end in zip(cameras.cameras, by_camera, starts[:-1], starts[1:], strict=True):
        sigma = np.array([camera.sigma.get(name, 0.0) for name in (*INTRINSICS, *POSE)])
        steps = back[:, begin:end] @ (own * sigma)
        covariance = covariance + steps @ steps.T
    return np.asarray(covariance)


def _carried(rig_from_board: Array, rig_from_robot: Array) -> Array:
    """(6, 6): takes steps of the board's pose to the motions of the robot frame, seen in it, that go with them."""
    turn = rig_from_robot[:3, :3].T
    x, y, z = rig_from_robot[:3, 3] - rig_from_board[:3, 3]
    lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.block([[turn, np.zeros((3, 3))], [turn @ lever, turn]])


def _in_mm(rig: Rig, rig_from_board: Array, seen: Observation, px: Array) -> Array:
    """Offsets (n, 2) in px as what they are at the board."""
    depth_mm = transformed(rig.camera_from_rig[seen.camera] @ rig_from_board, seen.points_mm)[:, 2]
    return np.asarray(px * (depth_mm / rig.intrinsics[seen.camera, 0])[:, None])


def _rms(off: Array) -> float:
    return float(np.sqrt(np.mean(off**2)))
