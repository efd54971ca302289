"""Where the board is, as cameras that are known see it."""

from collections.abc import Sequence

import numpy as np

from calibration.corners import Array
from calibration.projection import by_pose, moved, project, transformed, undistorted
from calibration.rig import Observation, Rig
from calibration.starting import pose_alone

MOST_STEPS, SETTLED = 20, 1e-9


def board_pose(rig: Rig, observations: Sequence[Observation]) -> Array:
    """`rig_from_board` (4, 4), mm, that explains all observations of one view best; those of `rig`'s own views are not used."""
    best = max(observations, key=lambda one: len(one.px))
    alone, _ = pose_alone(rig.intrinsics[best.camera], best)
    pose: Array = np.linalg.inv(rig.camera_from_rig[best.camera]) @ alone
    for _ in range(MOST_STEPS):
        residuals, jacobians = [], []
        for one in observations:
            camera_from_rig = rig.camera_from_rig[one.camera]
            points_mm = rig.points_mm(one)
            at_camera_mm = transformed(camera_from_rig @ pose, points_mm)
            px, by_point, _ = project(rig.intrinsics[one.camera], at_camera_mm)
            residuals.append((one.px - px).ravel())
            by_step = by_point @ camera_from_rig[:3, :3] @ by_pose(pose, points_mm)
            jacobians.append(by_step.reshape(-1, 6))
        step = np.linalg.lstsq(np.concatenate(jacobians), np.concatenate(residuals), rcond=None)[0]
        pose = moved(pose, step)
        if np.abs(step).max() < SETTLED:
            break
    return pose


def off_px(rig: Rig, rig_from_board: Array, seen: Observation) -> Array:
    """Found minus predicted (n, 2) for the board at `rig_from_board`."""
    points_mm = transformed(rig.camera_from_rig[seen.camera] @ rig_from_board, rig.points_mm(seen))
    return np.asarray(seen.px - project(rig.intrinsics[seen.camera], points_mm)[0])


def triangulated(rig: Rig, cameras: Sequence[int], px: Array) -> Array:
    """Points (n, 3) in the rig frame, mm, nearest to the rays of `px` (m, n, 2) in m cameras."""
    normal, right = np.zeros((px.shape[1], 3, 3)), np.zeros((px.shape[1], 3))
    for camera, seen in zip(cameras, px, strict=True):
        rig_from_camera = np.linalg.inv(rig.camera_from_rig[camera])
        ahead = np.column_stack([undistorted(rig.intrinsics[camera], seen), np.ones(len(seen))])
        ahead = ahead @ rig_from_camera[:3, :3].T
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        across = np.eye(3) - ahead[:, :, None] * ahead[:, None, :]
        normal += across
        right += across @ rig_from_camera[:3, 3]
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])
