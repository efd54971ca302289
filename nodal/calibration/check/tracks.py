"""Where each camera's scenery has lain from look to look. Pure."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from messaging.checked import FloatArray
from nodal.calibration.check.looks import Look
from nodal.calibration.check.scenery import Mask, Motion, Scenery
from sensing.errors import PictureError
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.pictures.light import Image
from sensing.pictures.picture import Picture
from sensing.pictures.segmentation import BEYOND_REACH, COLLAR_MM, BaseView
from sensing.scene import Scene

AROUND_ROBOT_MM = 8.0
"""So near to the centreline nothing counts as scenery."""
HOLDER_DEPTH_MM = 10.0
"""Below the base, where the holder's own motion with the stage is worked out."""
CARRIED_FROM_PX = 0.2
CARRIED_SHARE = 0.02
"""Of how far the stage has carried the holder in the picture, so much is uncertain: its faces are nearer than its axis, or farther."""
CLEAR = 2.0
"""Looks that tell the motion worse than the best one by more than this factor do not count."""
STAGE_STEADY_MM = 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Sighting:
    """One look of one camera: `motion` if the holder moves with the stage, and `fixed` if it does not; each None when too little is seen."""

    time_ns: int
    insertion_mm: float
    motion: Motion | None
    fixed: Motion | None


@dataclass(kw_only=True, eq=False)
class Track:
    """All looks of one camera."""

    camera: Camera
    sightings: list[Sighting] = field(default_factory=list)

    @property
    def motions(self) -> list[tuple[int, Motion]]:
        """When, in Unix ns, and how the scenery lay: with the holder carried by the stage or not, whichever is the steadier."""
        carried = [(one, one.motion) for one in self.sightings if one.motion is not None]
        fixed = [(one, one.fixed) for one in self.sightings if one.fixed is not None]
        steadier = min((way for way in (carried, fixed) if way), key=_unrest, default=[])
        best_px = min((motion.sigma_px for _, motion in steadier), default=0.0)
        return [(one.time_ns, motion) for one, motion in steadier if motion.sigma_px <= CLEAR * best_px]


def tracks(
    scene: Scene, references: Mapping[str, Image], reference_mm: float, looks: Iterable[Look]
) -> list[Track]:
    """One for each camera of the scene. `references` are pictures (h, w, 3) without the robot by camera, taken with the stage at
    `reference_mm`. Pictures that cannot be used are left out.
    """
    found = [Track(camera=camera) for camera in scene.cameras]
    sceneries = {
        name: Scenery(np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8))
        for name, picture in references.items()
    }
    for look in looks:
        for track in found:
            camera = track.camera
            try:
                luma = Picture(camera.name, look.jpegs.get(camera.name, b""), camera.size_px).luma
            except PictureError:
                continue
            track.sightings.append(_sighting(scene, camera, sceneries[camera.name], luma, look, reference_mm))
    return found


def _sighting(
    scene: Scene, camera: Camera, scenery: Scenery, luma: Image, look: Look, reference_mm: float
) -> Sighting:
    insertion_mm = look.estimate.insertion_mm
    hidden = _hidden(scene, camera, look)
    carried = _below(scene, camera, reference_mm + COLLAR_MM)
    middle = np.array([[0.0, 0.0, height - HOLDER_DEPTH_MM] for height in (reference_mm, insertion_mm)])
    before, now = camera.project(middle)
    still = scenery.motion(luma, hidden, carried, np.zeros(2))
    moved = still
    if (lifted := float(np.linalg.norm(now - before))) > CARRIED_FROM_PX:
        moved = scenery.motion(luma, hidden, carried, now - before)
        moved = moved and replace(moved, sigma_px=math.hypot(moved.sigma_px, CARRIED_SHARE * lifted))
    return Sighting(time_ns=look.time_ns, insertion_mm=insertion_mm, motion=moved, fixed=still)


def _hidden(scene: Scene, camera: Camera, look: Look) -> Mask:
    """Where the robot is, or, where that is not known, where it can be: (h, w)."""
    width, height = camera.size_px
    mask = np.zeros((height, width), dtype=np.uint8)
    base = BaseView.of(camera, look.estimate.insertion_mm, Grid(camera.size_px, 1))
    if look.estimate.refusal:
        radius = BEYOND_REACH * (scene.length_mm or max(camera.size_px)) * base.px_per_mm
        cv2.circle(mask, np.rint(base.pixel).astype(int).tolist(), int(radius), 255, cv2.FILLED)
        mask[_below(scene, camera, look.estimate.insertion_mm)] = 0
    else:
        line = np.rint(camera.project(np.ascontiguousarray(look.estimate.centreline_mm))).astype(np.int32)
        cv2.polylines(
            mask, [line], isClosed=False, color=255, thickness=int(2 * AROUND_ROBOT_MM * base.px_per_mm)
        )
    return mask > 0


def _below(scene: Scene, camera: Camera, height_mm: float) -> Mask:
    """The holder's strip below a base at this height: (h, w)."""
    width, height = camera.size_px
    mask = np.zeros((height, width), dtype=np.uint8)
    strip = BaseView.of(camera, height_mm, Grid(camera.size_px, 1)).below(
        scene.holder_radius_mm, width + height
    )
    cv2.fillConvexPoly(mask, np.rint(strip).astype(np.int32), 255)
    return mask > 0


def _unrest(way: Sequence[tuple[Sighting, Motion]]) -> float:
    """How much the scenery seems to move: about its mean while the stage moves, else from where it was at first."""
    shifts: FloatArray = np.array([motion.shift_px for _, motion in way])
    stage_mm = np.array([sighting.insertion_mm for sighting, _ in way])
    about = np.median(shifts, axis=0) if np.ptp(stage_mm) > STAGE_STEADY_MM else np.zeros(2)
    return float(np.median(np.linalg.norm(shifts - about, axis=1)))
