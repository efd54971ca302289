"""How the robot stands out from a new background: what sensing will take for its threshold, and whether it sees a shape. Pure."""

from collections.abc import Mapping

import msgspec
import numpy as np

from messaging.shape import Flag, ShapeEstimate
from sensing.errors import RefusedError
from sensing.pictures.backdrop import noise_level
from sensing.pictures.segmentation import BaseView, threshold_at_base
from sensing.scene import Scene


class Contrast(msgspec.Struct, frozen=True, kw_only=True):
    """Of one camera, in levels of equation 1's colour distance: the robot's at its base, the backdrop's, and the T between that
    sensing takes; `refusal` says why there is none.
    """

    camera: str
    robot: float
    backdrop: float
    threshold: float | None
    refusal: str = ""


class RobotSeen(msgspec.Struct, frozen=True, kw_only=True):
    """The robot before the new background: its contrasts, and what speaks against the shape."""

    contrasts: tuple[Contrast, ...]
    refusal: str
    flags: tuple[str, ...]
    length_mm: float

    @property
    def fine(self) -> bool:
        """Whether sensing sees it, and nothing speaks against what it sees; nobody has to say where the stage is."""
        return not self.refusal and not set(self.flags) - {Flag.BASE_UNKNOWN}


def robot_seen(scene: Scene, jpegs: Mapping[str, bytes], estimate: ShapeEstimate) -> RobotSeen:
    """Coded pictures of the robot by camera, and the estimate that sensing makes of them; raises PictureError."""
    contrasts = tuple(_contrast(scene, name, jpegs[name], estimate.insertion_mm) for name in jpegs)
    return RobotSeen(
        contrasts=contrasts,
        refusal=estimate.refusal,
        flags=estimate.flags,
        length_mm=0.0 if estimate.refusal else estimate.length_mm,
    )


def _contrast(scene: Scene, name: str, jpeg: bytes, insertion_mm: float) -> Contrast:
    camera = next(camera for camera in scene.cameras if camera.name == name)
    picture = scene.picture(name, jpeg)
    backdrop = scene.backdrop(picture)
    distance = backdrop.distance(picture.reduced(backdrop.grid.step))
    noise, robot, threshold, refusal = noise_level(distance), 0.0, None, ""
    try:
        base = BaseView.of(camera, insertion_mm, backdrop.grid).axis_in(name, distance.shape)
        robot = float(np.median(distance[base]))
        threshold = threshold_at_base(name, robot, noise, scene.threshold)
    except RefusedError as error:
        refusal = str(error)
    return Contrast(camera=name, robot=robot, backdrop=noise, threshold=threshold, refusal=refusal)
