"""The ways to a shape, behind one interface."""

from collections.abc import Callable, Mapping
from typing import ClassVar, Protocol

from messaging.frames import CameraCalibration
from messaging.settings import RobotSettings
from sensing.pictures.picture import Picture
from sensing.plain.method import Plain
from sensing.refined.method import Refined
from sensing.refined.track import Track
from sensing.scene import Scene
from sensing.settings import MethodName, SensingSettings
from sensing.shape import Shape


class Method(Protocol):
    """Finds the robot's shape in one set of pictures after the other. It keeps nothing itself."""

    name: ClassVar[MethodName]

    def __init__(self, scene: Scene) -> None: ...

    @property
    def scene(self) -> Scene:
        """What does not change from frame to frame."""

    def estimate(
        self,
        pictures: Mapping[str, Picture],
        insertion_mm: float,
        last: Track | None,
        clock: Callable[[], float],
    ) -> Shape:
        """The shape in one set of pictures, one at least for each of the scene's cameras.

        `last` is the track of the set before, or None; `clock` gives seconds and is read only for `stage_s`. Raises
        RefusedError when no shape can be resolved, PictureError for a bad one.
        """


METHODS: Mapping[MethodName, type[Method]] = {method.name: method for method in (Refined, Plain)}


def bench_method(
    settings: SensingSettings,
    robot: RobotSettings,
    calibrations: tuple[CameraCalibration, ...],
    backgrounds: Mapping[str, bytes],
) -> Method:
    """The method that a bench file chooses, for its scene; raises as `Scene.of` does."""
    return METHODS[settings.method](Scene.on_bench(settings, robot, calibrations, backgrounds))
