"""Settings of the servo bus: which port, and which servo pulls what."""

from typing import Annotated

import msgspec

from drivers.dynamixel.control_table import BAUD_RATES

ServoId = Annotated[int, msgspec.Meta(ge=0, le=252)]
BaudRate = Annotated[int, msgspec.Meta(ge=9_600, le=4_500_000)]


class AxisSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One servo: a tendon pair on a pulley, or the stage on a screw.

    `mm_per_rad` is the pulley's radius, or the screw's lead over 2 pi; negative when positive turns mean less mm.
    The travel `min_mm` to `max_mm` counts from the zero that homing sets. `max_current_ma` bounds what the servo itself
    will use to reach its goal, and so the tendon's tension.
    """

    name: Annotated[str, msgspec.Meta(min_length=1)]
    id: ServoId
    mm_per_rad: Annotated[float, msgspec.Meta(ge=-1000, le=1000)]
    min_mm: float
    max_mm: float
    max_current_ma: Annotated[float, msgspec.Meta(gt=0, le=6000)]
    zero_ticks: Annotated[int, msgspec.Meta(ge=-1_048_575, le=1_048_575)] | None = None
    """The servo's own position that is called 0 mm, so that a stage keeps its place when the controller starts anew; without
    it 0 mm is where the servo stands when the port is opened, which is right for tendons: homing finds their zero."""

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if abs(self.mm_per_rad) < 1e-3:
            raise ValueError(
                f"axis {self.name}: mm_per_rad {self.mm_per_rad} must be at least 0.001 either way"
            )
        if not self.min_mm < self.max_mm:
            raise ValueError(f"axis {self.name}: min_mm {self.min_mm} must be below max_mm {self.max_mm}")


class ServoSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One bus: the tendon pairs in the order of every displacement vector, and the stage, if the robot stands on one."""

    port: Annotated[str, msgspec.Meta(min_length=1)]
    tendons: Annotated[tuple[AxisSettings, ...], msgspec.Meta(min_length=1)]
    stage: AxisSettings | None = None
    baud_rate: BaudRate = 1_000_000
    profile_velocity_rad_s: Annotated[float, msgspec.Meta(gt=0, le=780)] = 4.0
    profile_acceleration_rad_s2: Annotated[float, msgspec.Meta(gt=0, le=12_000)] = 100.0
    watchdog_ms: Annotated[int, msgspec.Meta(ge=20, le=2540)] = 200
    """After how long a silence the servos stop by themselves; rounded up to whole units of 20 ms."""
    temperature_limit_c: Annotated[int, msgspec.Meta(ge=30, le=80)] = 75
    """At which temperature a servo lets go by itself, a little above `controller.limits.temperature_c`, which acts first."""
    answer_timeout_ms: Annotated[float, msgspec.Meta(ge=1, le=500)] = 20.0
    retries: Annotated[int, msgspec.Meta(ge=0, le=5)] = 2

    @property
    def axes(self) -> tuple[AxisSettings, ...]:
        """The tendon pairs, then the stage if there is one."""
        return self.tendons if self.stage is None else (*self.tendons, self.stage)

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        for what, values in (("id", [a.id for a in self.axes]), ("name", [a.name for a in self.axes])):
            if len(set(values)) != len(values):
                raise ValueError(f"axes: every {what} must be used once, not {values}")
        if self.baud_rate not in BAUD_RATES:
            raise ValueError(f"baud_rate {self.baud_rate}: servos speak at {', '.join(map(str, BAUD_RATES))}")
