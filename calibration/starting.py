"""Where bundle adjustment starts: each camera by itself, then the cameras among one another through views that they share."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np

from calibration.bundle import adjust
from calibration.corners import Array
from calibration.errors import ViewsError
from calibration.projection import matrix, project, transformed
from calibration.rig import Observation, Prior, Rig
from calibration.views import Size

FOCAL_LENGTHS = np.geomspace(0.35, 5.0, 24)
"""In widths of the picture: from 110 degrees of view to 11."""
SEARCHED_VIEWS = 12

Poses = dict[int, Array]
"""`camera_from_board` (4, 4), mm, by the number of the view."""


def starting_rig(
    names: Sequence[str], sizes: Mapping[str, Size], observations: Sequence[Observation], prior: Prior
) -> Rig:
    """A rig near the solution; raises ViewsError where cameras share no view. Every camera has views, every view a camera."""
    intrinsics, poses = [], []
    for camera, name in enumerate(names):
        own = [one for one in observations if one.camera == camera]
        alone, seen = _alone(sizes[name], own, prior)
        intrinsics.append(alone)
        poses.append(seen)
    camera_from_rig = _linked(names, poses)
    rig_from_board = {}
    for one in sorted(observations, key=lambda one: len(one.px)):
        rig_from_board[one.view] = np.linalg.inv(camera_from_rig[one.camera]) @ poses[one.camera][one.view]
    return Rig(
        np.array(intrinsics),
        np.array(camera_from_rig),
        np.array([rig_from_board[view] for view in sorted(rig_from_board)]),
    )


def _alone(size: Size, observations: Sequence[Observation], prior: Prior) -> tuple[Array, Poses]:
    """The intrinsics (9,) of one camera and the board's poses in its frame, from its own views."""
    width, height = size
    few = observations[:: max(1, len(observations) // SEARCHED_VIEWS)]
    tried = [
        np.array([share * width, share * width, (width - 1) / 2.0, (height - 1) / 2.0, 0, 0, 0, 0, 0])
        for share in FOCAL_LENGTHS
    ]
    errors = [np.median([pose_alone(intrinsics, one)[1] for one in few]) for intrinsics in tried]
    best = tried[int(np.argmin(errors))]
    start = Rig(best[None], np.eye(4)[None], np.array([pose_alone(best, one)[0] for one in observations]))
    numbered = [replace(one, camera=0, view=number) for number, one in enumerate(observations)]
    alone = adjust(start, numbered, prior).rig
    return alone.intrinsics[0], dict(
        zip((one.view for one in observations), alone.rig_from_board, strict=True)
    )


def pose_alone(intrinsics: Array, seen: Observation) -> tuple[Array, float]:
    """`camera_from_board` (4, 4), mm, and its RMS in px, from one camera's corners (IPPE; Collins and Bartoli, 2014)."""
    # OpenCV refuses every second row of an array
    points_mm, px = np.ascontiguousarray(seen.points_mm), np.ascontiguousarray(seen.px)
    _, turns, shifts, _ = cv2.solvePnPGeneric(
        points_mm, px, matrix(intrinsics), intrinsics[4:], flags=cv2.SOLVEPNP_IPPE
    )
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(turns[0])[0]
    pose[:3, 3] = np.ravel(shifts[0])
    predicted_px = project(intrinsics, transformed(pose, seen.points_mm))[0]
    return pose, float(np.sqrt(np.mean((predicted_px - seen.px) ** 2)))


def _linked(names: Sequence[str], poses: Sequence[Poses]) -> list[Array]:
    """`camera_from_rig` of each camera, from the first one outwards, always over the most shared views."""
    found = {0: np.eye(4)}
    while len(found) < len(names):
        shared, known, new = max(
            (len(poses[known].keys() & poses[new].keys()), -known, -new)
            for known in found
            for new in range(len(names))
            if new not in found
        )
        known, new = -known, -new
        if not shared:
            placed = " and ".join(names[camera] for camera in sorted(found))
            others = " and ".join(name for camera, name in enumerate(names) if camera not in found)
            raise ViewsError(
                f"no view shows the board to {placed} and to {others} at once, so nothing says how they stand to "
                "one another: hold the board where both see it"
            )
        found[new] = _typical(poses[new], poses[known]) @ found[known]
    return [found[camera] for camera in range(len(names))]


def _typical(ahead: Poses, behind: Poses) -> Array:
    """The change of frames that agrees best with those of all shared views, so that a flipped pose counts for nothing."""
    changes = np.array([ahead[view] @ np.linalg.inv(behind[view]) for view in ahead.keys() & behind.keys()])
    distance_mm = np.median(np.linalg.norm([behind[view][:3, 3] for view in behind], axis=1))
    apart = changes[:, None, :3] - changes[None, :, :3]
    apart_mm = np.linalg.norm(apart[..., :3] * distance_mm, axis=(2, 3)) + np.linalg.norm(
        apart[..., 3], axis=2
    )
    return np.asarray(changes[np.argmin(np.median(apart_mm, axis=1))])
