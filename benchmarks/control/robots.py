"""The robots of the benches: the bench robot, and others that the same controller is to lead as well.

Each is what a drawing says. Random benches are drawn around it, and its controller is told nothing else.
"""

import dataclasses

import msgspec
import numpy as np

from benchmarks.control.paths import CIRCLE, TIP
from controller.settings import ControllerSettings, LimitSettings, SectionTendons
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings
from drivers.simulated.servos.settings import MotorSettings
from messaging.control import Target
from messaging.settings import RobotSettings
from nodal.targets import circle
from nodal.virtual.settings import ServoSettings, ShapeSettings, VirtualBenchSettings

SECTION_MM = 40.0
POINTS_PER_SECTION = 20
STAGE_MM, LOWERED_MM = 5.0, 3.0
"""How far above, or below, a straight robot's tip its circle lies."""
EASY_SERVOS = ServoSettings(tendon_mm_per_rad=10.0, motor=MotorSettings(friction_Nm=0.02))
"""Single tendons are kept tight by their currents, so their servos must feel a few newtons in spite of their own friction."""
EASY_LIMITS = LimitSettings(least_tension_ma=15.0)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Robot:
    """A robot by its drawing, its controller's settings, and a circle that it can reach."""

    name: str
    bench: VirtualBenchSettings
    controller: ControllerSettings
    robot: RobotSettings
    circle: Target


BENCH_ROBOT = Robot(
    name="two sections",
    bench=VirtualBenchSettings(),
    controller=ControllerSettings(),
    robot=RobotSettings(section_length_mm=(SECTION_MM, SECTION_MM)),
    circle=CIRCLE,
)


def _robot(
    name: str,
    angles_deg: list[tuple[float, ...]],
    *,
    single: bool = False,
    stage: bool = True,
    radius_mm: float = 15.0,
) -> Robot:
    """Sections of 40 mm with tendon pairs, or single tendons, at these angles; more of them pull over more."""
    count = len(angles_deg)
    sections = tuple(
        SectionSettings(
            length_mm=SECTION_MM,
            tendon_angles_deg=angles if single else tuple(a + turn for a in angles for turn in (0.0, 180.0)),
        )
        for angles in angles_deg
    )
    tendons = [
        SectionTendons(tendon_angle_deg=angles) if single else SectionTendons(pair_angle_deg=angles)
        for angles in angles_deg
    ]
    ends_mm = SECTION_MM * np.arange(1, count + 1)
    return Robot(
        name=name,
        bench=VirtualBenchSettings(
            robot=SimulatedRobotSettings(
                sections=sections,
                tendons_per_servo=1 if single else 2,
                centreline_points=POINTS_PER_SECTION * count + 1,
            ),
            stage=stage,
            servos=EASY_SERVOS if single else ServoSettings(),
            shape=ShapeSettings(
                node_names=(*(f"end {n}" for n in range(1, count)), TIP), node_arc_mm=tuple(ends_mm.tolist())
            ),
        ),
        controller=ControllerSettings(
            sections=tuple(tendons),
            limits=msgspec.structs.replace(
                EASY_LIMITS if single else LimitSettings(), displacement_mm=5.0 * count
            ),
        ),
        robot=RobotSettings(section_length_mm=(SECTION_MM,) * count, stage=stage),
        circle=circle(
            TIP,
            radius_mm=radius_mm,
            period_s=10.0,
            height_mm=SECTION_MM * count + (STAGE_MM if stage else -LOWERED_MM),
            centre_mm=(0.0, 0.0),
        ),
    )


OTHER_ROBOTS = (
    _robot("one section", [(0.0, 90.0)], radius_mm=10.0),
    _robot("three sections", [(0.0, 90.0), (30.0, 120.0), (60.0, 150.0)]),
    _robot("four sections", [(0.0, 90.0), (22.5, 112.5), (45.0, 135.0), (67.5, 157.5)]),
    _robot("three pairs", [(0.0, 60.0, 120.0), (30.0, 90.0, 150.0)]),
    _robot("no stage", [(0.0, 90.0), (45.0, 135.0)], stage=False),
    _robot("single tendons", [(90.0, 210.0, 330.0), (30.0, 150.0, 270.0)], single=True),
)
