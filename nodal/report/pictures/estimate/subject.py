"""What the pictures of an estimate are made of, worked out once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from messaging.shape import NodalPoints
from nodal.report.confidence import USUAL
from nodal.report.pictures.estimate.agreement import Agreement, agreements
from nodal.report.pictures.estimate.regions import Region, ellipse_px
from sensing.geometry.camera import Camera
from sensing.method import Method
from sensing.shape import Shape

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Subject:
    """An estimate by this method from these coded pictures, and the nodal points that were asked for."""

    method: Method
    jpegs: Mapping[str, bytes]
    shape: Shape
    nodes: NodalPoints

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """All cameras of the scene."""
        return self.method.scene.cameras

    @cached_property
    def node_mm(self) -> Array:
        """Nodal points (n, 3)."""
        return self.shape.nodes(self.nodes.arc_mm)[0]

    @cached_property
    def node_covariance_mm2(self) -> Array:
        """Their covariances (n, 3, 3)."""
        return self.shape.nodes(self.nodes.arc_mm)[1]

    @cached_property
    def agreements(self) -> dict[str, Agreement]:
        """By camera."""
        return agreements(self.shape, self.cameras)

    def ellipses(self, camera: Camera) -> list[Region]:
        """Where a camera sees each nodal point with the usual confidence."""
        pairs = zip(self.node_mm, self.node_covariance_mm2, strict=True)
        return [ellipse_px(camera, place, covariance, USUAL) for place, covariance in pairs]

    @property
    def ellipsoids(self) -> list[Region]:
        """Where each nodal point lies with the usual confidence."""
        pairs = zip(self.node_mm, self.node_covariance_mm2, strict=True)
        return [Region.of(place, covariance, USUAL) for place, covariance in pairs]

    @property
    def verdict(self) -> str:
        """The method, and its flags."""
        flags = ", ".join(self.shape.flags)
        return (
            f"Method {self.method.name}, flagged: {flags}"
            if flags
            else f"Method {self.method.name}, no flags"
        )

    @property
    def figures(self) -> str:
        """What the evidence comes to, in one line."""
        shape, evidence, known_mm = self.shape, self.shape.evidence, self.method.scene.length_mm
        known = f" (known: {known_mm:g} mm)" if known_mm else ""
        angle = np.degrees(evidence.epipolar_angle_rad.min())
        return (
            f"Length {shape.length_mm:.2f} mm{known} · mean ray gap {evidence.ray_gap_mm:.3f} mm, "
            f"bias {evidence.ray_bias_mm:+.3f} mm · residual {shape.residual_px:.2f} px · "
            f"epipolar angle at least {angle:.0f}°"
        ).replace("-", "−")
