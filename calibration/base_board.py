"""The robot frame from the board in its fixture at the base: the board's pose from all cameras at once."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import msgspec
import numpy as np
from scipy.optimize import least_squares

from calibration.base import Array, Base, Matrix4, Matrix6
from calibration.camera_set import CalibratedCamera, CameraSet
from calibration.corners import Corners
from calibration.errors import ViewsError

LEAST_CORNERS = 8
"""Of each camera: fewer lie in one corner of the board, and tell little about where the others are."""
LEAST_SHARE = 0.5
"""A corner counts that is found in at least so many of a camera's pictures."""
STEP_RAD, STEP_MM = 1e-5, 1e-3
INTRINSICS = {"fx_px": (0, 0), "fy_px": (1, 1), "cx_px": (0, 2), "cy_px": (1, 2)}
DISTORTION = ("k1", "k2", "p1", "p2", "k3")
POSE = ("rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "x_mm", "y_mm", "z_mm")
FLOOR_PX = 0.02
"""No corner is better known than this, however many pictures are averaged."""


@dataclass(frozen=True)
class _Seen:
    """The corners that a camera saw: on the board (n, 3) in mm, and in its pictures (n, 2), in px, on average."""

    camera: CalibratedCamera
    points_mm: Array
    px: Array


def base_from_board(
    cameras: CameraSet, sets: Sequence[Mapping[str, Corners]], points_mm: Array, robot_from_board: Array
) -> Base:
    """The robot frame, from the corners by camera of sets of pictures of the board that stood still.

    `points_mm` (n, 3) are all corners on the board by their ids; `robot_from_board` (4, 4) is where the fixture holds it.
    The covariance is that of the corners and, where the cameras' parameters have standard deviations, of those; they are
    taken as independent, which makes it larger than it is. Raises ViewsError when a camera does not see the board.
    """
    seen = [_averaged(camera, sets, points_mm) for camera in cameras.cameras]
    start = _start(max(seen, key=lambda one: len(one.px)))
    solution = least_squares(lambda pose: _residuals(seen, pose), start, method="lm", x_scale="jac")
    rig_from_board = _matrix(solution.x)
    jacobian = _jacobian(seen, rig_from_board)
    off_px = _off(seen, rig_from_board)
    variance = max(float(np.mean(off_px**2)), FLOOR_PX**2)
    covariance = variance * np.linalg.inv(jacobian.T @ jacobian)
    back = np.linalg.pinv(jacobian)
    for changed in _changed(seen):
        step = back @ (_off(changed, rig_from_board) - off_px)
        covariance = covariance + np.outer(step, step)
    carried = _adjoint(robot_from_board)
    rig_from_robot = rig_from_board @ np.linalg.inv(robot_from_board)
    return Base(
        way="board",
        rig_from_robot=msgspec.convert(rig_from_robot.tolist(), Matrix4),
        covariance=msgspec.convert((carried @ covariance @ carried.T).tolist(), Matrix6),
        residual_px={one.camera.name: _rms(_off([one], rig_from_board)) for one in seen},
        residual_mm=_rms(np.concatenate([_off_mm(one, rig_from_board) for one in seen])),
        frame_sets=len(sets),
    )


def _averaged(camera: CalibratedCamera, sets: Sequence[Mapping[str, Corners]], points_mm: Array) -> _Seen:
    found = [seen[camera.name] for seen in sets if camera.name in seen]
    count, total = np.zeros(len(points_mm)), np.zeros((len(points_mm), 2))
    for corners in found:
        count[corners.ids] += 1
        total[corners.ids] += corners.px
    ids = np.flatnonzero(count >= max(LEAST_SHARE * len(found), 1))
    if len(ids) < LEAST_CORNERS:
        raise ViewsError(
            f"camera {camera.name} sees {len(ids)} corners of the board at the base; {LEAST_CORNERS} are needed"
        )
    return _Seen(camera, points_mm[ids], total[ids] / count[ids, None])


def _start(seen: _Seen) -> Array:
    """The pose (6,) of the board in the rig frame as one camera sees it: its rotation vector, then its place in mm."""
    camera = seen.camera
    _, rotation, place = cv2.solvePnP(
        seen.points_mm,
        seen.px,
        np.array(camera.intrinsics),
        np.array(camera.distortion),
        flags=cv2.SOLVEPNP_IPPE,
    )
    camera_from_board = _matrix(np.concatenate([rotation.ravel(), place.ravel()]))
    rig_from_board = np.linalg.inv(np.array(camera.camera_from_rig)) @ camera_from_board
    return np.concatenate([cv2.Rodrigues(rig_from_board[:3, :3])[0].ravel(), rig_from_board[:3, 3]])


def _matrix(pose: Array) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(pose[:3])[0]
    matrix[:3, 3] = pose[3:]
    return matrix


def _residuals(seen: Sequence[_Seen], pose: Array) -> Array:
    return _off(seen, _matrix(pose))


def _off(seen: Sequence[_Seen], rig_from_board: Array) -> Array:
    """How far (2 n,) in px corners are from where this pose (4, 4) says they are, all cameras after one another."""
    return np.concatenate([(one.px - _project(one, rig_from_board)).ravel() for one in seen])


def _project(one: _Seen, rig_from_board: Array) -> Array:
    camera = one.camera
    pose = np.array(camera.camera_from_rig) @ rig_from_board
    px, _ = cv2.projectPoints(
        one.points_mm,
        cv2.Rodrigues(pose[:3, :3])[0],
        pose[:3, 3],
        np.array(camera.intrinsics),
        np.array(camera.distortion),
    )
    return np.asarray(px.reshape(-1, 2), np.float64)


def _off_mm(one: _Seen, rig_from_board: Array) -> Array:
    """The same in mm at the board, (2 n,)."""
    camera = one.camera
    pose = np.array(camera.camera_from_rig) @ rig_from_board
    depth = (one.points_mm @ pose[:3, :3].T + pose[:3, 3])[:, 2]
    return np.asarray(
        ((one.px - _project(one, rig_from_board)) * (depth / camera.intrinsics[0][0])[:, None]).ravel()
    )


def _jacobian(seen: Sequence[_Seen], rig_from_board: Array) -> Array:
    """Derivatives (2 n, 6) of where corners appear, by a small motion of the board in its own frame."""
    steps = np.repeat([STEP_RAD, STEP_MM], 3)
    return np.column_stack(
        [
            (_off(seen, rig_from_board @ _matrix(-by)) - _off(seen, rig_from_board @ _matrix(by)))
            / (2 * step)
            for by, step in zip(np.diag(steps), steps, strict=True)
        ]
    )


def _adjoint(other_from_board: Array) -> Array:
    """Takes small motions (6,) of the board, in its own frame, to the same motions in another frame that moves with it."""
    turn, (x, y, z) = other_from_board[:3, :3], other_from_board[:3, 3]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block([[turn, np.zeros((3, 3))], [cross @ turn, turn]])


def _changed(seen: Sequence[_Seen]) -> Iterator[list[_Seen]]:
    """The same with one parameter of one camera off by its standard deviation, for each that has one."""
    for place, one in enumerate(seen):
        for name, sigma in one.camera.sigma.items():
            changed = list(seen)
            changed[place] = replace(one, camera=_off_by(one.camera, name, sigma))
            yield changed


def _off_by(camera: CalibratedCamera, name: str, sigma: float) -> CalibratedCamera:
    """The camera with one parameter changed; rotations are about the camera's own axes."""
    intrinsics, distortion = np.array(camera.intrinsics), np.array(camera.distortion)
    motion = np.zeros(6)
    if name in INTRINSICS:
        intrinsics[INTRINSICS[name]] += sigma
    elif name in DISTORTION:
        distortion[DISTORTION.index(name)] += sigma
    elif name in POSE:
        motion[POSE.index(name)] = sigma
    changed = {
        "intrinsics": intrinsics.tolist(),
        "distortion": distortion.tolist(),
        "camera_from_rig": (_matrix(motion) @ np.array(camera.camera_from_rig)).tolist(),
    }
    return msgspec.convert(msgspec.structs.asdict(camera) | changed, CalibratedCamera)


def _rms(off: Array) -> float:
    return float(np.sqrt(np.mean(off**2)))
