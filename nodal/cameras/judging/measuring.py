"""Everything that is measured in one camera's pictures. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass

from nodal.cameras.judging.light import Lighting, lighting_of
from nodal.cameras.judging.sharpness import Edges, edges_in
from nodal.cameras.judging.steadiness import flicker_in, noise_in
from nodal.errors import CommandError
from sensing.pictures.coding import coding_of
from sensing.pictures.light import Image
from sensing.pictures.picture import Picture


@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """What the pictures of one camera show. `picture` (h, w, 3), BGR, is the newest, and `jpeg` its bytes.

    `noise_levels` and `flicker` (a share of the light) are None where there are too few pictures.
    """

    camera: str
    jpeg: bytes
    picture: Image
    edges: Edges
    lighting: Lighting
    noise_levels: float | None
    flicker: float | None

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.picture.shape[1], self.picture.shape[0]

    def figures(self) -> dict[str, float | None]:
        """What was measured, by names that carry units; shares are of 1."""
        return {
            "edge_width_px": self.edges.width_px,
            "backdrop_level": self.lighting.level,
            "clipped_share": self.lighting.clipped_share,
            "contrast_levels": self.lighting.contrast,
            "backdrop_noise_levels": self.lighting.backdrop_noise,
            "darkest_light_share": self.lighting.falloff,
            "standing_out_share": self.lighting.standing_out_share,
            "noise_levels": self.noise_levels,
            "flicker_share": self.flicker,
        }


def look_at(camera: str, jpegs: Sequence[bytes]) -> Look:
    """What these coded pictures of one camera show; raises CommandError without one, UnreadableImageError, ImageSizeError."""
    if not jpegs:
        raise CommandError(f"camera {camera}: there is no picture to look at")
    size_px = coding_of(camera, jpegs[-1]).size_px
    pictures = [Picture(camera, jpeg, size_px) for jpeg in jpegs]
    newest = pictures[-1].colour
    brightness = [picture.luma for picture in pictures]
    edges = edges_in(brightness[-1])
    return Look(
        camera=camera,
        jpeg=jpegs[-1],
        picture=newest,
        edges=edges,
        lighting=lighting_of(newest, edges.places),
        noise_levels=noise_in(brightness),
        flicker=flicker_in(brightness),
    )
