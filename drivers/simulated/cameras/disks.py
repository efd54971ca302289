"""The spacer disks: short cylinders across the centreline, seen in exact perspective."""

from dataclasses import dataclass

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Index, Labels
from drivers.simulated.cameras.canvas import Fragments, Window, covered, edge_reach_px
from drivers.simulated.cameras.cells import Cells, cells_reached, in_cells, label_map
from drivers.simulated.cameras.light import Light
from drivers.simulated.cameras.nearest import gather
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.vectors import cross, lengths, units

_CIRCLE = np.linspace(0, 2 * np.pi, 16, endpoint=False)
_SQUARE = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]])
_STEEPEST = np.float32(1e-4)
_TINY = np.float32(1e-9)


@dataclass(frozen=True)
class Disks:
    """k disks, in the camera frame."""

    centre_mm: Array
    """(k, 3)."""
    axis: Array
    """(k, 3) unit vectors."""
    motion_mm: Array
    """(k, 3) while the shutter is open."""
    radius_mm: Array
    """(k,)."""
    half_thickness_mm: float
    colour: Array
    """(3,)."""

    def fragments(
        self, projection: Projection, window: Window, light: Light, lens_blur_px: float
    ) -> Fragments:
        """What the window shows of the disks. A pixel shows one disk, the nearest."""
        labels = self._draw_labels(projection, window, lens_blur_px)
        cells = Cells.labelled(labels, window, projection.width_px)
        # not spread from cells: a disk's edges have corners
        x, y = projection.rays(cells.place_in_picture)
        meeting = self._meet(x, y, cells.part, light)
        px_per_mm = gather(self._scale(projection)[:, None], cells.part)[0]
        cover = covered(meeting.inside_mm * px_per_mm, meeting.motion_mm * px_per_mm, lens_blur_px)
        lit = light.brightness(meeting.towards_lamp).reshape(-1)
        return Fragments(
            index=cells.place.reshape(-1),
            cover=cover.reshape(-1),
            colour=self.colour.astype(np.float32)[:, None] * lit,
            depth_mm=meeting.depth_mm.reshape(-1),
        )

    def _meet(self, x: Flat, y: Flat, disk: Index, light: Light) -> "_Meeting":
        """How rays (x, y, 1), each of x and y (4, m), meet disks (m,).

        `t` mm deeper than a disk's middle the ray is (ex, ey, 0) + t (x, y, 1) from it; of that, height + t slope is
        along the axis, and the square of the rest is shift2 + 2 t mixed + t^2 across2. None of them is large.
        """
        ways = [_across(self.motion_mm, self.axis), _across(light.direction, self.axis)]
        table = [self.axis, self.centre_mm, *ways, self.radius_mm, self.axis @ light.direction]
        rows = gather(np.column_stack(table), disk)
        axis, centre, motion, lamp, (radius, lamp_along) = np.split(rows, [3, 6, 9, 12])
        half = np.float32(self.half_thickness_mm)

        ex, ey = centre[2] * x - centre[0], centre[2] * y - centre[1]
        slope = axis[0] * x + axis[1] * y + axis[2]
        slope = np.where(np.abs(slope) < _STEEPEST, _STEEPEST, slope)
        height = axis[0] * ex + axis[1] * ey
        ray2 = x * x + y * y + 1
        across2 = np.maximum(ray2 - slope * slope, _TINY)
        mixed = ex * x + ey * y - height * slope
        shift2 = ex * ex + ey * ey - height * height

        def part(t: Flat, way: Flat) -> Flat:
            found: Flat = ex * way[0] + ey * way[1] + t * (x * way[0] + y * way[1] + way[2])
            return found

        closest = -mixed / across2
        middle, reach_of_faces = -height / slope, half / np.abs(slope)
        enters = middle - reach_of_faces
        t = np.clip(closest, enters, middle + reach_of_faces)
        beyond = t - closest
        shortest2 = shift2 + mixed * closest
        away2 = np.maximum(shortest2 + beyond * beyond * across2, _TINY)
        away = np.sqrt(away2)
        # where the rim of a face bounds the disk, a slanted view stretches distances from the axis
        slant = beyond * beyond * across2 / away2 * (ray2 / (slope * slope) - 1)
        rim = closest - np.sqrt(np.maximum(radius * radius - shortest2, 0) / across2)
        return _Meeting(
            inside_mm=(radius - away) / np.sqrt(1 + slant),
            motion_mm=part(t, motion) / away,
            depth_mm=centre[2] + np.maximum(rim, enters),
            towards_lamp=np.where(rim < enters, -np.sign(slope) * lamp_along, part(rim, lamp) / radius),
        )

    def _scale(self, projection: Projection) -> Array:
        """(k,) pixels a millimetre at each disk."""
        scale: Array = projection.focal_px / self.centre_mm[:, 2]
        return scale

    def _most_motion_px(self, projection: Projection) -> float:
        moved_px = lengths(self.motion_mm) * self._scale(projection)
        return float(moved_px.max(initial=0))

    def _draw_labels(self, projection: Projection, window: Window, lens_blur_px: float) -> Labels:
        """The surroundings of all disks lie below the disks themselves, nearer ones above farther ones."""
        labels = label_map(window)
        rims = in_cells(projection.to_pixels(self._rims_mm()), window)
        reach = cells_reached(edge_reach_px(self._most_motion_px(projection), lens_blur_px))
        far_first = np.argsort(-self.centre_mm[:, 2]).tolist()
        for around in (reach * _SQUARE, np.zeros((1, 2))):
            outlines = np.rint(rims[:, None] + around[:, None]).astype(np.int32)
            for disk in far_first:
                cv2.fillConvexPoly(labels, cv2.convexHull(outlines[disk].reshape(-1, 2)), disk + 1)
        return labels

    def _rims_mm(self) -> Array:
        """(k, 2 * 16, 3) points on both rims of every disk."""
        first = units(cross(self.axis, np.eye(3)[np.argmin(np.abs(self.axis), axis=1)]))
        second = cross(self.axis, first)
        circle = np.cos(_CIRCLE)[:, None] * first[:, None] + np.sin(_CIRCLE)[:, None] * second[:, None]
        rim = self.centre_mm[:, None] + self.radius_mm[:, None, None] * circle
        half = self.half_thickness_mm * self.axis[:, None]
        return np.concatenate([rim - half, rim + half], axis=1)


@dataclass(frozen=True)
class _Meeting:
    inside_mm: Flat
    """(4, m) from the silhouette to the ray; negative outside."""
    motion_mm: Flat
    """(4, m) of the disk away from its axis towards the ray, while the shutter is open."""
    depth_mm: Flat
    """(4, m)."""
    towards_lamp: Flat
    """(4, m) component of the normal of the surface that is seen."""


def _across(vectors: Array, axis: Array) -> Array:
    """(k, 3) what of vectors (k, 3), or of one (3,), is not along the axes (k, 3)."""
    along: Array = (vectors * axis).sum(axis=1, keepdims=True)
    return vectors - along * axis
