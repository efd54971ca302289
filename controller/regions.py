"""Forbidden regions of the bench, in the robot frame: how far points are from them, and which way leads away. Pure."""

from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Place = tuple[
    Annotated[float, msgspec.Meta(ge=-10_000, le=10_000)],
    Annotated[float, msgspec.Meta(ge=-10_000, le=10_000)],
    Annotated[float, msgspec.Meta(ge=-10_000, le=10_000)],
]


class Sphere(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="sphere"
):
    """`kind = "sphere"`: a ball that the robot must not enter."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    centre_mm: Place
    radius_mm: Annotated[float, msgspec.Meta(gt=0, le=10_000)]


class HalfSpace(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="half_space"
):
    """`kind = "half_space"`: everything behind a plane. `normal` points out of it, to where the robot may be."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    point_mm: Place
    normal: Place

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if not any(self.normal):
            raise ValueError(f"region {self.name}: normal {list(self.normal)} must point somewhere")


Region = Sphere | HalfSpace


class Regions:
    """All forbidden regions, R of them, with their spheres first."""

    def __init__(self, regions: Sequence[Region]) -> None:
        """There may be none."""
        spheres = [region for region in regions if isinstance(region, Sphere)]
        half_spaces = [region for region in regions if isinstance(region, HalfSpace)]
        self.names = (*(sphere.name for sphere in spheres), *(half.name for half in half_spaces))
        self._centre_mm = np.array([sphere.centre_mm for sphere in spheres]).reshape(-1, 3)
        self._radius_mm = np.array([sphere.radius_mm for sphere in spheres])
        normal = np.array([half.normal for half in half_spaces], dtype=np.float64).reshape(-1, 3)
        self._normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        self._offset_mm = (
            self._normal * np.array([half.point_mm for half in half_spaces]).reshape(-1, 3)
        ).sum(axis=1)

    def __len__(self) -> int:
        """How many there are."""
        return len(self.names)

    def clearance(self, point_mm: Array) -> tuple[Array, Array]:
        """For points (..., 3): distance to each region (..., R), negative inside, and the unit way out (..., R, 3)."""
        from_centre = point_mm[..., None, :] - self._centre_mm
        distance = np.linalg.norm(from_centre, axis=-1)
        outward = from_centre / np.maximum(distance, 1e-12)[..., None]
        above = point_mm @ self._normal.T - self._offset_mm
        normals = np.broadcast_to(self._normal, (*above.shape, 3))
        return (
            np.concatenate([distance - self._radius_mm, above], axis=-1),
            np.concatenate([outward, normals], axis=-2),
        )
