"""What the demo shows: the tip to the circle's beginning, round and round, and a hold at the end. Lengths fit the robot."""

import dataclasses

from messaging.control import Target
from nodal import targets
from nodal.bench_settings import BenchSettings
from nodal.demo.operator import Operator
from nodal.demo.telemetry import Telemetry
from nodal.report.summary import CIRCLE, HOLD

APPROACH = "demo-approach"
PERIOD_S = 10.0
SHORTEST_S = 8.0
APPROACH_S = 3.0
HOLD_S, HOLD_SHARE = (3.0, 8.0), 0.1


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scenario:
    """A level circle of one nodal point, in the robot frame."""

    node: str
    radius_mm: float
    height_mm: float
    duration_s: float

    @classmethod
    def for_bench(cls, settings: BenchSettings, duration_s: float) -> "Scenario":
        """The circle of the outermost nodal point: radius 15 mm and height 85 mm on a robot of 80 mm."""
        length_mm = settings.robot.length_mm
        return cls(
            node=settings.sensing.nodal_points[-1].name,
            radius_mm=15 / 80 * length_mm,
            height_mm=85 / 80 * length_mm,
            duration_s=duration_s,
        )

    def perform(self, operator: Operator, telemetry: Telemetry) -> None:
        """Approach, circle, hold; raises DemoError or Stopped."""
        hold_s = min(max(HOLD_SHARE * self.duration_s, HOLD_S[0]), HOLD_S[1])
        begin = [self.radius_mm, 0.0, self.height_mm]
        operator.follow(self._point(APPROACH, begin), APPROACH_S)
        operator.follow(self._circle(), self.duration_s - APPROACH_S - hold_s)
        now = telemetry.controller
        where = now.desired_mm[0].tolist() if now is not None and now.target_name == CIRCLE else begin
        operator.follow(self._point(HOLD, where), hold_s)

    def _point(self, name: str, place_mm: list[float]) -> Target:
        return dataclasses.replace(targets.points({self.node: place_mm}, {}), name=name)

    def _circle(self) -> Target:
        circle = targets.circle(
            self.node,
            radius_mm=self.radius_mm,
            period_s=PERIOD_S,
            height_mm=self.height_mm,
            centre_mm=(0.0, 0.0),
        )
        return dataclasses.replace(circle, name=CIRCLE)
