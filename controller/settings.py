"""Settings of the controller, as they stand in the bench file. Lengths in mm, times in s; angles in degrees, for people."""

from typing import Annotated

import msgspec
import numpy as np

from controller.kinematics import Kinematics
from messaging.settings import RobotSettings

Seconds = Annotated[float, msgspec.Meta(gt=0, le=60)]
Speed = Annotated[float, msgspec.Meta(gt=0, le=500)]
Travel = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]
Degrees = Annotated[float, msgspec.Meta(ge=-360, le=360)]


class SectionTendons(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One section's two tendon pairs: the angle of each pair's first tendon from +X towards +Y, and their distance from the backbone."""

    pair_angle_deg: tuple[Degrees, Degrees]
    pitch_radius_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 4.0


class LimitSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What commands and servos may do. Displacements reach the same way in both directions from the homed zero."""

    displacement_mm: Annotated[float, msgspec.Meta(gt=0, le=200)] = 5.0
    insertion_mm: tuple[Travel, Travel] = (0.0, 40.0)
    displacement_mm_s: Speed = 5.0
    insertion_mm_s: Speed = 20.0
    current_ma: Annotated[float, msgspec.Meta(gt=0, le=6000)] = 1000.0
    current_grace_s: Seconds = 0.1
    """How long a servo may draw more than `current_ma`, as it does for a moment when it starts to move."""
    travel_grace_s: Seconds = 1.0
    """How long the law may push against the end of a travel before that is a fault."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if not self.insertion_mm[0] < self.insertion_mm[1]:
            raise ValueError(
                f"insertion_mm {list(self.insertion_mm)} must go from the lower end to the higher"
            )


class SensingSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """When shapes are trusted."""

    maximum_age_s: Seconds = 0.1
    """An estimate older than this when it arrives is as good as none."""
    timeout_s: Annotated[float, msgspec.Meta(gt=0, le=0.095)] = 0.09
    """Without a trusted estimate for this long the tendons keep their place."""
    hold_at_most_s: Seconds = 1.0
    """After this long without a trusted estimate the hold becomes a fault."""


class HomingSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the straight pose is found: nodal points go to the axis at `node_speed_mm_s` until their RMS distance from it
    stays below `within_mm` for `settle_s`.
    """

    node_speed_mm_s: Speed = 5.0
    within_mm: Annotated[float, msgspec.Meta(gt=0, le=20)] = 0.5
    settle_s: Seconds = 0.5
    timeout_s: Seconds = 20.0


class ResolvedRateSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The law `resolved_rate`; controller/resolved_rate.py tells what is done with the values."""

    feedback_per_s: Annotated[float, msgspec.Meta(gt=0, le=100)] = 8.0
    """Speed per distance with which an error is made good."""
    response_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.04
    """Time constant with which servos and robot follow a command."""
    lost_motion_mm: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.4
    """What backlash and friction swallow when a tendon pair turns round; too little is safe, twice too much is not."""
    engaging_mm: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.05
    """Within how much motion after turning round the lost motion is made up for."""
    damping_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.5
    """Motion of a nodal point per mm of tendon below which the law gives up rather than pull hard."""
    insertion_cost: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.1
    """What a mm of the stage costs beside a mm of tendon, where either would do."""
    posture_per_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.5
    """How fast the tendons go back to zero in directions that move no nodal point."""
    measurement_noise_mm: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.05
    """Standard deviation of one coordinate of a nodal point."""
    offset_drift_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 0.5
    """How far the robot may wander from its model in a second, by itself."""
    gain_drift: Annotated[float, msgspec.Meta(ge=0, le=100)] = 0.3
    """How much the Jacobian may change in a second, in mm per mm."""
    maximum_gain_correction: Annotated[float, msgspec.Meta(ge=0, lt=1)] = 0.5
    """Bound of the Jacobian's correction, as a share of the model's."""


class ControllerSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Everything the controller needs beside the robot. `law` is a name in controller/laws.py."""

    sections: Annotated[tuple[SectionTendons, ...], msgspec.Meta(min_length=1, max_length=8)] = (
        SectionTendons(pair_angle_deg=(0.0, 90.0)),
        SectionTendons(pair_angle_deg=(45.0, 135.0)),
    )
    law: str = "resolved_rate"
    maximum_node_speed_mm_s: Speed = 20.0
    reachable_within_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 1.0
    """How far from where it was asked to be the model may leave a nodal point of a target that is still accepted."""
    relax_mm_s: Speed = 1.0
    """How fast `relax` lets the tendons go."""
    rate_hz: Annotated[float, msgspec.Meta(ge=20, le=1000)] = 200.0
    limits: LimitSettings = LimitSettings()
    sensing: SensingSettings = SensingSettings()
    homing: HomingSettings = HomingSettings()
    resolved_rate: ResolvedRateSettings = ResolvedRateSettings()

    def kinematics(self, robot: RobotSettings) -> Kinematics:
        """The model of this robot; raises ControllerSetupError when the sections do not agree."""
        return Kinematics(
            robot.section_length_mm,
            np.radians([section.pair_angle_deg for section in self.sections]),
            [section.pitch_radius_mm for section in self.sections],
        )
