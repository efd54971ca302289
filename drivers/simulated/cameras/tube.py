"""The robot's tube, pixel by pixel: the envelope of spheres along the centreline, seen in exact perspective.

For each cell of pixels near the projected centreline the sphere that the ray of its middle meets deepest is sought; the
ray's distance from the sphere's middle, spread to the pixels, says against its radius how much of each is covered. The last sphere is the round tip.
"""

from dataclasses import dataclass

import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Labels, Mask
from drivers.simulated.cameras.canvas import Fragments, Window, covered, edge_reach_px
from drivers.simulated.cameras.cells import Cells, cells_reached, in_cells, spread
from drivers.simulated.cameras.curve import Curve
from drivers.simulated.cameras.light import Light
from drivers.simulated.cameras.nearest import Passage, dot, gather, pass_by
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.strips import Strips
from drivers.simulated.cameras.vectors import cross, lengths, units

_SAMPLES_PER_PIECE = 4
_END_ON = 0.4  # sine of the angle to the view, below which a piece counts as seen end on


@dataclass(frozen=True)
class Tube:
    """A curve with a radius (n,) in mm and a colour (n, 3) at each of its samples."""

    curve: Curve
    radius_mm: Array
    colour: Array

    def fragments(
        self, projection: Projection, window: Window, light: Light, lens_blur_px: float
    ) -> list[Fragments]:
        """What the window shows of the tube: what it may hide of itself, if anything, then what is in front."""
        curve = self.curve
        scale = projection.focal_px / curve.points_mm[:, 2]
        motion_px = float((lengths(curve.motion_mm) * scale).max())
        reach = cells_reached(self.radius_mm * scale + edge_reach_px(motion_px, lens_blur_px))
        pieces = curve.points_mm[::_SAMPLES_PER_PIECE]
        obliquity = lengths(cross(curve.tangents[::_SAMPLES_PER_PIECE], pieces))
        end_on = obliquity < _END_ON * pieces[:, 2]
        strips = Strips(
            middle=in_cells(projection.to_pixels(pieces), window),
            reach=reach[::_SAMPLES_PER_PIECE],
            depth_mm=pieces[:, 2],
            end_on=end_on,
        )
        look = _Look(self, projection, light, end_on)
        return [look.fragments(labels, window, lens_blur_px) for labels in strips.layers(window)]


class _Look:
    """What each sample of the tube looks like from the camera."""

    def __init__(self, tube: Tube, projection: Projection, light: Light, end_on: Mask) -> None:
        curve = tube.curve
        aside = units(cross(curve.tangents, curve.points_mm))
        facing = cross(curve.tangents, aside)
        base_mm = curve.points_mm[np.argmin(np.abs(curve.arc_mm))]
        self._tube = tube
        self._projection = projection
        self._light = light
        self._surface = np.column_stack([tube.radius_mm, aside @ light.direction, facing @ light.direction])
        self._start = _along_pieces(curve, end_on)
        self._end_on = end_on
        self._base_height_mm = np.float32(base_mm @ projection.rotation[:, 2])

    def fragments(self, labels: Labels, window: Window, lens_blur_px: float) -> Fragments:
        """What the tube contributes to the labelled cells of the window."""
        curve, focal_px = self._tube.curve, np.float32(self._projection.focal_px)
        cells = Cells.labelled(labels, window, self._projection.width_px)
        x, y = cells.middle_rays(self._projection)
        start_mm, slope_x, slope_y = gather(self._start, cells.part)
        uncertain = np.flatnonzero(self._end_on[cells.part])
        end_mm = curve.length_mm - float(self._tube.radius_mm[-1]) - float(curve.arc_mm[0])
        passage = pass_by(curve, end_mm, x, y, start_mm + slope_x * x + slope_y * y, uncertain)

        radius_mm, lamp_aside, lamp_facing = gather(self._surface, passage.sample)
        px_per_mm = focal_px / passage.depth_mm
        radius_px = radius_mm * px_per_mm
        outwards, aside = passage.outwards, passage.aside
        distance_px = np.abs(spread(passage.distance_mm * px_per_mm, outwards[:2]))
        sideways = spread(passage.sideways_mm * px_per_mm, aside[:2]) / radius_px
        share = distance_px / radius_px
        facing = np.sqrt(np.maximum(1 - share * share, 0))
        depth_mm = passage.depth_mm - radius_mm / passage.obliquity * facing

        motion_px = dot(gather(curve.motion_mm, passage.sample), outwards) * px_per_mm
        cover = covered(radius_px - distance_px, motion_px, lens_blur_px)
        self._sink_base(cover, passage, depth_mm)
        lit = self._light.brightness(lamp_aside * sideways + lamp_facing * facing)
        return Fragments(
            index=cells.place.reshape(-1),
            cover=cover.reshape(-1),
            colour=(gather(self._tube.colour, passage.sample)[:, None] * lit).reshape(3, -1),
            depth_mm=depth_mm.reshape(-1),
        )

    def _sink_base(self, cover: Flat, passage: Passage, depth_mm: Flat) -> None:
        """Uncover what lies below the plane of the base, inside the holder: cover and depth are (4, m)."""
        above = np.searchsorted(self._tube.curve.arc_mm, 2 * self._tube.radius_mm[0])
        low = np.flatnonzero(passage.sample < above)
        up = self._projection.rotation[:, 2].astype(np.float32)
        rise = up[0] * passage.ray[0][low] + up[1] * passage.ray[1][low] + up[2]
        focal_px = np.float32(self._projection.focal_px)
        rise_px = spread(rise * focal_px, np.repeat(up[:2, None], len(low), axis=1))
        above_px = rise_px - self._base_height_mm * focal_px / depth_mm[:, low]
        cover[:, low] *= np.clip(0.5 + above_px, 0, 1)


def _along_pieces(curve: Curve, end_on: Mask) -> Array:
    """(k, 3) coefficients a, b, c: a ray (x, y, 1) before a piece passes about a + b x + c y mm from the first sample.

    Linear along each piece's picture; of pieces seen end on, the beginning.
    """
    view = curve.points_mm[::_SAMPLES_PER_PIECE]
    view = view[:, :2] / view[:, 2:]
    step = np.diff(view, axis=0)
    step = np.concatenate([step, step[-1:]])
    spacing_mm = _SAMPLES_PER_PIECE * curve.spacing_mm
    slope = spacing_mm * step / np.maximum((step**2).sum(axis=1, keepdims=True), 1e-12)
    slope[end_on] = 0
    return np.column_stack([spacing_mm * np.arange(len(view)) - (slope * view).sum(axis=1), slope])
