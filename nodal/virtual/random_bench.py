"""Benches drawn by chance: each within what a plausible lab robot is, none as its controller believes it to be."""

import msgspec
import numpy as np

from drivers.simulated.robot.settings import SectionSettings
from nodal.virtual.settings import VirtualBenchSettings

replace = msgspec.structs.replace


def random_bench(seed: int, nominal: VirtualBenchSettings | None = None) -> VirtualBenchSettings:
    """The nominal bench with everything that a drawing or a data sheet leaves open; the same seed gives the same bench."""
    nominal = nominal or VirtualBenchSettings()
    random = np.random.default_rng([seed, 0x6E6F64616C])
    motor = nominal.servos.motor

    def between(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    sections = tuple(_section(section, random) for section in nominal.robot.sections)
    servos = sum(len(s.tendon_angles_deg) for s in sections) // nominal.robot.tendons_per_servo
    return replace(
        nominal,
        robot=replace(
            nominal.robot,
            sections=sections,
            friction_coefficient=between(0.08, 0.2),
            backlash_mm=between(0.05, 0.25),
            tendon_compliance_mm_per_N=between(0.2, 0.4),
            pretension_N=between(1.5, 3.5),
            tip_payload_g=between(5.0, 25.0),
            damping_s=between(0.05, 0.15),
        ),
        servos=replace(
            nominal.servos,
            gain=(
                *(between(0.9, 1.1) for _ in range(servos)),
                *(between(0.99, 1.01) for _ in range(nominal.stage)),
            ),
            profile_velocity_rad_s=between(3.0, 4.8),
            profile_acceleration_rad_s2=between(60.0, 150.0),
            motor=replace(motor, friction_Nm=motor.friction_Nm * between(0.6, 1.5)),
        ),
        seed=seed,
    )


def _section(section: SectionSettings, random: np.random.Generator) -> SectionSettings:
    lean, heading = random.uniform(0.002, 0.006), random.uniform(0.0, 2 * np.pi)
    return replace(
        section,
        length_mm=section.length_mm + float(random.uniform(-0.3, 0.3)),
        youngs_modulus_GPa=section.youngs_modulus_GPa * float(random.uniform(0.8, 1.25)),
        stiffness_variation=float(random.uniform(0.2, 0.5)),
        precurvature_per_mm=(float(lean * np.cos(heading)), float(lean * np.sin(heading))),
    )
