"""Settings of the controller, as they stand in the bench file. Lengths in mm, times in s; angles in degrees, for people."""

from typing import Annotated, Any

import msgspec
import numpy as np

from controller.history import KEPT_S
from controller.identified import Drawing, IdentifiedSettings
from controller.kinematics import Kinematics
from controller.regions import Region
from messaging.settings import RobotSettings

Seconds = Annotated[float, msgspec.Meta(gt=0, le=60)]
Speed = Annotated[float, msgspec.Meta(gt=0, le=500)]
Travel = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]
Degrees = Annotated[float, msgspec.Meta(ge=-360, le=360)]

_SHORTEST_HEARTBEAT_S = 0.3


class SectionTendons(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One section's tendons: antagonistic pairs, each on one servo, by the angle of the pair's first tendon from +X towards
    +Y, or single tendons, each on a servo of its own; and their distance from the backbone.
    """

    pair_angle_deg: Annotated[tuple[Degrees, ...], msgspec.Meta(max_length=8)] = ()
    tendon_angle_deg: Annotated[tuple[Degrees, ...], msgspec.Meta(max_length=8)] = ()
    pitch_radius_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 4.0

    @property
    def angle_deg(self) -> tuple[float, ...]:
        """Of what is pulled, in the order of the axes."""
        return self.pair_angle_deg or self.tendon_angle_deg

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        pairs, single = len(self.pair_angle_deg), len(self.tendon_angle_deg)
        if (pairs > 0) == (single > 0) or pairs == 1 or 0 < single < 3:
            raise ValueError(
                f"a section has {pairs} pair_angle_deg and {single} tendon_angle_deg; "
                "it needs either two pairs or more, or three single tendons or more"
            )


class LimitSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What commands and servos may do. Displacements reach the same way in both directions from the homed zero."""

    displacement_mm: Annotated[float, msgspec.Meta(gt=0, le=200)] = 5.0
    insertion_mm: tuple[Travel, Travel] = (0.0, 40.0)
    displacement_mm_s: Speed = 5.0
    insertion_mm_s: Speed = 20.0
    current_ma: Annotated[float, msgspec.Meta(gt=0, le=6000)] = 800.0
    current_grace_s: Seconds = 0.1
    """How long a servo may draw more than `current_ma`, as it does for a moment when it starts to move."""
    least_tension_ma: Annotated[float, msgspec.Meta(gt=0, le=6000)] = 40.0
    """Current below which a single tendon counts as slack; pairs keep one another tight."""
    tightening_mm_s: Speed = 0.5
    """How fast slack is taken out of single tendons."""
    travel_grace_s: Seconds = 1.0
    """How long the law may push against the end of a travel before that is a fault."""
    following_mm: Annotated[float, msgspec.Meta(gt=0, le=200)] = 3.0
    """How far a servo may stand from where it was sent, unless it comes nearer."""
    following_grace_s: Seconds = 0.5
    """How long it may stand further."""
    temperature_c: Annotated[float, msgspec.Meta(gt=0, le=150)] = 70.0
    """How hot a servo may become."""
    voltage_v: tuple[Annotated[float, msgspec.Meta(ge=0)], Annotated[float, msgspec.Meta(le=100)]] = (
        9.0,
        16.0,
    )
    """Between which voltages a servo's supply must be."""
    voltage_grace_s: Seconds = 0.5
    """How long it may be elsewhere, as when many servos start to move at once."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if not self.voltage_v[0] < self.voltage_v[1]:
            raise ValueError(f"voltage_v {list(self.voltage_v)} must go from the lower bound to the higher")
        if not self.insertion_mm[0] < self.insertion_mm[1]:
            raise ValueError(
                f"insertion_mm {list(self.insertion_mm)} must go from the lower end to the higher"
            )


class SensingSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """When shapes are trusted."""

    maximum_age_s: Annotated[float, msgspec.Meta(gt=0, le=KEPT_S)] = 0.1
    """An estimate older than this when it arrives is as good as none."""
    timeout_s: Annotated[float, msgspec.Meta(gt=0, le=0.5)] = 0.09
    """Without a trusted estimate for this long the tendons keep their place; cameras at 10 Hz need more than 0.2 s."""
    hold_at_most_s: Seconds = 1.0
    """After this long without a trusted estimate the hold becomes a fault."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if self.timeout_s >= self.hold_at_most_s:
            raise ValueError(
                f"timeout_s {self.timeout_s:g} must be less than hold_at_most_s {self.hold_at_most_s:g}: "
                "the tendons hold before that becomes a fault"
            )


class HomingSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How zero is found: first the slack of each axis, then the straight pose.

    Each tendon pair is pulled one way and the other at `probe_mm_s`, at most `search_mm` each way, until the cameras see
    nodal points move by `seen_mm`, or further if they say of themselves that they see no better, or the current rises by
    `current_rise_ma`. A single tendon is tightened until the cameras see as much, or its current rises by `tension_ma`. Then
    nodal points go to the axis at `node_speed_mm_s` until their RMS distance from the axis stays below `within_mm` for
    `settle_s`, within `timeout_s`.
    """

    find_slack: bool = True
    """False calls the place where the robot stands the middle of all slack."""
    probe_mm_s: Annotated[float, msgspec.Meta(gt=0, le=10)] = 1.0
    search_mm: Annotated[float, msgspec.Meta(gt=0, le=50)] = 3.0
    seen_mm: Annotated[float, msgspec.Meta(gt=0, le=20)] = 0.5
    current_rise_ma: Annotated[float, msgspec.Meta(gt=0, le=6000)] = 300.0
    tension_ma: Annotated[float, msgspec.Meta(gt=0, le=6000)] = 80.0
    node_speed_mm_s: Speed = 5.0
    within_mm: Annotated[float, msgspec.Meta(gt=0, le=20)] = 0.5
    settle_s: Seconds = 0.5
    timeout_s: Seconds = 20.0


class JogSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How one axis may be moved by hand: `nodal do jog`."""

    at_most_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 5.0
    """The longest single move."""
    mm_s: Annotated[float, msgspec.Meta(gt=0, le=20)] = 1.0


class OperatorSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What happens when nobody is there any more."""

    heartbeat_s: Annotated[float, msgspec.Meta(ge=0, le=60)] = 0.0
    """Without an operator's heartbeat for this long the tendons hold: targets, homing and jogs end. 0 needs no heartbeat."""
    hold_s: Seconds = 10.0
    """After this long without a heartbeat in any state with torque the tendons are let go."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if 0 < self.heartbeat_s < _SHORTEST_HEARTBEAT_S:
            raise ValueError(
                f"heartbeat_s {self.heartbeat_s:g} must be 0, or at least {_SHORTEST_HEARTBEAT_S:g}: "
                "`nodal do watch` gives one every 0.1 s"
            )


class RealTimeSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the control loop asks of the kernel; docs/real-time.md says what it gains, and what allows it."""

    fifo_priority: Annotated[int, msgspec.Meta(ge=0, le=99)] = 0
    """SCHED_FIFO with this priority for the loop's thread alone; 0 leaves it an ordinary one."""
    lock_memory: bool = False
    """Keep all memory of the process in RAM, so that no cycle waits for a page."""
    cpus: tuple[Annotated[int, msgspec.Meta(ge=0, le=4095)], ...] = ()
    """The cores on which the loop's thread may run; empty leaves that to the kernel."""


class ControllerSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Everything the controller needs beside the robot.

    `law` names a file of controller/laws, or `law_file` is the path of another; `tuning` holds that law's own settings.
    No part of the robot's centreline comes nearer than `keep_clear_mm` to a region in `forbidden`.
    """

    sections: Annotated[tuple[SectionTendons, ...], msgspec.Meta(min_length=1, max_length=8)] = (
        SectionTendons(pair_angle_deg=(0.0, 90.0)),
        SectionTendons(pair_angle_deg=(45.0, 135.0)),
    )
    coupling: Annotated[float, msgspec.Meta(ge=0, le=1)] = 1.0
    """Share of the pitch radius at which distal tendons cross the sections before their own; 0 leads them along the backbone."""
    identified: IdentifiedSettings | None = None
    """What this robot was found to be beyond the drawing; without it, laws begin at the drawing."""
    forbidden: tuple[Region, ...] = ()
    keep_clear_mm: Annotated[float, msgspec.Meta(ge=0, le=1000)] = 5.0
    law: str = "resolved_rate"
    law_file: str = ""
    tuning: dict[str, Any] = msgspec.field(default_factory=dict)
    maximum_node_speed_mm_s: Speed = 20.0
    reachable_within_mm: Annotated[float, msgspec.Meta(gt=0, le=100)] = 1.0
    """How far from where it was asked to be the model may leave a nodal point of a target that is still accepted."""
    relax_mm_s: Speed = 1.0
    """How fast `relax` lets the tendons go."""
    rate_hz: Annotated[float, msgspec.Meta(ge=20, le=1000)] = 200.0
    limits: LimitSettings = LimitSettings()
    sensing: SensingSettings = SensingSettings()
    homing: HomingSettings = HomingSettings()
    jog: JogSettings = JogSettings()
    operator: OperatorSettings = OperatorSettings()
    stall_s: Seconds = 0.5
    """How far apart two cycles may lie while torque is on."""
    real_time: RealTimeSettings = RealTimeSettings()

    def kinematics(self, robot: RobotSettings) -> Kinematics:
        """The model of this robot; raises ControllerSetupError when the sections do not agree."""
        return Kinematics(
            robot.section_length_mm,
            [np.radians(section.angle_deg) for section in self.sections],
            [section.pitch_radius_mm for section in self.sections],
            coupling=self.coupling,
            stage=robot.stage,
        )

    def drawing(self, robot: RobotSettings, mm_per_rad: tuple[float, ...]) -> Drawing:
        """What an identification of this robot, on servos that turn like that, is a correction of."""
        return Drawing(
            section_length_mm=robot.section_length_mm,
            angle_deg=tuple(section.angle_deg for section in self.sections),
            pitch_radius_mm=tuple(section.pitch_radius_mm for section in self.sections),
            coupling=self.coupling,
            mm_per_rad=mm_per_rad,
        )
