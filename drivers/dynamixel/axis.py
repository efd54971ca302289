"""One axis: between mm of tendon or stage and the servo's counts."""

import dataclasses
import math

from drivers.dynamixel.control_table import MAX_TURNS, RAD_PER_TICK, RAD_S_PER_VELOCITY, TICKS_PER_TURN, Model
from drivers.dynamixel.errors import WrongSetupError
from drivers.dynamixel.settings import AxisSettings

MAX_TICKS = MAX_TURNS * TICKS_PER_TURN - 1


@dataclasses.dataclass(frozen=True, slots=True)
class Axis:
    """A servo with its model, and the position in ticks that is called 0 mm."""

    settings: AxisSettings
    model: Model
    zero_ticks: float

    @property
    def mm_per_tick(self) -> float:
        """Travel of one encoder tick; negative where positive turns mean less mm."""
        return self.settings.mm_per_rad * RAD_PER_TICK

    def position_mm(self, ticks: int) -> float:
        """Where Present Position `ticks` is."""
        return (ticks - self.zero_ticks) * self.mm_per_tick

    def velocity_mm_s(self, velocity: int) -> float:
        """Present Velocity in mm/s."""
        return velocity * RAD_S_PER_VELOCITY * self.settings.mm_per_rad

    def current_ma(self, current: int) -> float:
        """Present Current, positive where it drives the axis towards more mm."""
        return math.copysign(self.model.current_unit_ma, self.settings.mm_per_rad) * current

    def goal_ticks(self, position_mm: float) -> int:
        """The Goal Position nearest to `position_mm`."""
        return round(self.zero_ticks + position_mm / self.mm_per_tick)

    def goal_current(self) -> int:
        """The Goal Current that bounds the servo's effort."""
        return int(self.settings.max_current_ma / self.model.current_unit_ma)

    def zeroed(self, ticks: float, position_mm: float) -> "Axis":
        """The same axis, calling Present Position `ticks` `position_mm`; raises WrongSetupError beyond the servo's turns."""
        zero = ticks - position_mm / self.mm_per_tick
        for limit_mm in (self.settings.min_mm, self.settings.max_mm):
            if abs(zero + limit_mm / self.mm_per_tick) > MAX_TICKS:
                raise WrongSetupError(
                    f"axis {self.settings.name}: with 0 mm at tick {zero:.0f}, {limit_mm} mm is beyond the "
                    f"{MAX_TURNS} turns that a servo can count"
                )
        return dataclasses.replace(self, zero_ticks=zero)

    def after_reboot(self, ticks_before: int, ticks_after: int) -> "Axis":
        """The same axis when a reboot made the servo forget its turns: the angle within a turn is still true."""
        turns = math.floor((ticks_after - ticks_before) / TICKS_PER_TURN + 0.5)
        return dataclasses.replace(self, zero_ticks=self.zero_ticks + turns * TICKS_PER_TURN)
