"""What sensing carries from one frame set to the next, in the small form that is logged."""

from dataclasses import dataclass
from typing import Self

from messaging.checked import FloatArray
from messaging.shape import NodalPoints
from messaging.snapshot import freeze, thaw
from sensing.errors import MemoryMisfitError
from sensing.pictures.backdrop import Backdrop
from sensing.refined.track import Track
from sensing.refined.tube import Curve, Tip
from sensing.scene import Scene

PACKAGES = ("sensing", "messaging")


@dataclass(frozen=True, kw_only=True, eq=False)
class TrackMemory:
    """A `Track` without its pictures. Of backdrops that were fitted the coefficients (10, 3) are kept, of others how the light
    has changed (4,), both by camera.
    """

    control_mm: FloatArray
    length_mm: float
    radius_mm: FloatArray
    tip: Tip
    insertion_mm: float
    surfaces: dict[str, FloatArray]
    gains: dict[str, FloatArray]

    @classmethod
    def of(cls, track: Track) -> Self:
        """What has to be kept of this track."""
        return cls(
            control_mm=track.curve.control_mm,
            length_mm=track.curve.length_mm,
            radius_mm=track.curve.radius_mm,
            tip=track.tip,
            insertion_mm=track.insertion_mm,
            surfaces={
                name: backdrop.surface
                for name, backdrop in track.backdrops.items()
                if backdrop.surface is not None
            },
            gains={
                name: backdrop.gains
                for name, backdrop in track.backdrops.items()
                if backdrop.gains is not None
            },
        )

    def track(self, scene: Scene) -> Track:
        """The track in this scene; raises MemoryMisfitError when that has other cameras or backdrops."""
        known = {**scene.backdrops, **self._fitted(scene)}
        for name in self.gains.keys() & known.keys():
            known[name] = known[name].relit(self.gains[name])
        missing = [camera.name for camera in scene.cameras if camera.name not in known]
        # a camera that was lost when the robot was found has none
        if len(scene.cameras) - len(missing) < min(2, len(scene.cameras)):
            raise MemoryMisfitError(f"sensing's memory holds no backdrop of camera {', '.join(missing)}")
        return Track(
            curve=Curve(self.control_mm, self.length_mm, self.radius_mm),
            tip=self.tip,
            insertion_mm=self.insertion_mm,
            backdrops=known,
        )

    def _fitted(self, scene: Scene) -> dict[str, Backdrop]:
        sizes = {camera.name: camera.size_px for camera in scene.cameras}
        return {
            name: Backdrop.from_surface(surface, sizes[name])
            for name, surface in self.surfaces.items()
            if name in sizes
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class SensingMemory:
    """The track, if the robot was seen, and the nodal points that are asked for."""

    track: TrackMemory | None
    points: NodalPoints

    def to_bytes(self) -> bytes:
        """The snapshot of this memory."""
        return freeze(self)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """The memory in this snapshot; raises CodecError, or MemoryMisfitError for a snapshot of something else."""
        memory = thaw(data, PACKAGES)
        if not isinstance(memory, cls):
            raise MemoryMisfitError(f"a snapshot holds a {type(memory).__name__}, not sensing's memory")
        return memory
