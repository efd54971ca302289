"""What is controlled: the model of the robot, the limits of its axes, and where it must not be."""

import dataclasses
from typing import Self

import numpy as np
from numpy.typing import NDArray

from controller.kinematics import Kinematics
from controller.limits import Limits
from controller.regions import Regions
from controller.settings import ControllerSettings
from messaging.settings import RobotSettings

Array = NDArray[np.float64]

_BODY_STEP_MM = (2.0, 5.0)
"""How far apart along the robot it is looked at whether it keeps clear of regions: as far as it keeps clear, within bounds."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Plant:
    """One robot, for everything that plans or decides how it moves."""

    kinematics: Kinematics
    limits: Limits
    regions: Regions
    clearance_mm: float
    """How far the centreline stays away from regions: the robot's radius, and a margin."""
    maximum_node_speed_mm_s: float
    antagonistic: NDArray[np.bool_]
    """(A,) true for axes that pull both ways: pairs, and the stage; false for single tendons, which can go slack."""
    identified: tuple[Array, Array] | None = None
    """What the robot was found to be beyond its kinematics, and the standard deviations, in the order of controller/belief.py."""

    @classmethod
    def of(cls, settings: ControllerSettings, robot: RobotSettings) -> Self:
        """Raises ControllerSetupError when the settings do not fit the robot."""
        kinematics = settings.kinematics(robot)
        identified = settings.identified
        pairs = [bool(section.pair_angle_deg) for section in settings.sections for _ in section.angle_deg]
        return cls(
            kinematics=kinematics,
            limits=Limits(settings.limits, kinematics.tendons, stage=kinematics.stage),
            regions=Regions(settings.forbidden),
            clearance_mm=settings.keep_clear_mm,
            maximum_node_speed_mm_s=settings.maximum_node_speed_mm_s,
            antagonistic=np.array([*pairs, *[True] * kinematics.stage]),
            identified=None if identified is None else identified.stacked(kinematics),
        )

    @property
    def body_arc_mm(self) -> Array:
        """(m,) arc lengths at which the body is looked at, the tip last."""
        length_mm = float(self.kinematics.length_mm.sum())
        step_mm = min(max(self.clearance_mm, _BODY_STEP_MM[0]), _BODY_STEP_MM[1])
        return np.linspace(0.0, length_mm, max(round(length_mm / step_mm), 1) + 1)[1:]
