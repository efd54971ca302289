"""The spacer disks: short cylinders across the centreline, seen in exact perspective."""

from dataclasses import dataclass

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Index, Labels
from drivers.simulated.cameras.canvas import Fragments, Window, covered, edge_reach_px
from drivers.simulated.cameras.cells import Cells, cells_reached, in_cells, label_map
from drivers.simulated.cameras.light import Light
from drivers.simulated.cameras.nearest import dot, gather
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
        disk = np.tile(cells.part, len(cells.place))
        x, y = projection.rays(cells.place_in_picture.reshape(-1))
        ray = np.stack([x, y, np.ones_like(x)])
        meeting = self._meet(ray, disk)
        px_per_mm = gather(self._scale(projection)[:, None], disk)[0]
        motion_px = dot(gather(self.motion_mm, disk), meeting.outwards) * px_per_mm
        lit = light.brightness(light.direction.astype(np.float32) @ meeting.normal)
        return Fragments(
            index=cells.place.reshape(-1),
            cover=covered(meeting.inside_mm * px_per_mm, motion_px, lens_blur_px),
            colour=self.colour.astype(np.float32)[:, None] * lit,
            depth_mm=meeting.depth_mm,
        )

    def _meet(self, ray: Flat, disk: Index) -> "_Meeting":
        """How rays (3, m) of third component 1 meet disks (m,)."""
        centre, axis = gather(self.centre_mm, disk), gather(self.axis, disk)
        radius = gather(self.radius_mm[:, None], disk)[0]
        half = np.float32(self.half_thickness_mm)
        # at depth z the ray is z slope - middle along the axis, and z across + shift away from it
        slope = dot(axis, ray)
        slope = np.where(np.abs(slope) < _STEEPEST, _STEEPEST, slope)
        middle = dot(axis, centre)
        across, shift = ray - slope * axis, middle * axis - centre
        across2 = np.maximum(dot(across, across), _TINY)
        closest = -dot(across, shift) / across2
        enters = (middle - half * np.sign(slope)) / slope
        leaves = (middle + half * np.sign(slope)) / slope

        depth = np.clip(closest, enters, leaves)
        away = depth * across + shift
        reach = np.sqrt(dot(away, away))
        outwards = away / np.maximum(reach, _TINY)
        # where the rim of a face bounds the disk, a slanted view stretches distances from the axis
        slant = dot(outwards, across) ** 2 / across2 * (dot(ray, ray) / (slope * slope) - 1)
        inside = (radius - reach) / np.sqrt(1 + slant * (depth != closest))

        shortest2 = reach * reach - (depth - closest) ** 2 * across2
        rim = closest - np.sqrt(np.maximum(radius * radius - shortest2, 0) / across2)
        normal = np.where(rim < enters, -np.sign(slope) * axis, (rim * across + shift) / radius)
        return _Meeting(inside, outwards, np.maximum(rim, enters), normal)

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
    """(m,) from the silhouette to the ray; negative outside."""
    outwards: Flat
    """(3, m) unit vectors from the axis to the ray."""
    depth_mm: Flat
    normal: Flat
    """(3, m) of the surface that is seen."""
