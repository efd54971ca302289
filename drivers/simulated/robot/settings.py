"""Settings of the simulated robot: its build, and the strength of everything that makes a real one hard.

Every strength may be zero; with all of them zero the robot is a uniform rod under frictionless tendons (`ideal`).
Angles are written in degrees here, because bench files are written by people.
"""

from typing import Annotated, Literal

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Fraction = Annotated[float, msgspec.Meta(ge=0, le=1)]
Degrees = Annotated[float, msgspec.Meta(ge=-360, le=360)]
CurvaturePerMm = Annotated[float, msgspec.Meta(ge=-0.05, le=0.05)]


class SectionSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One section: a round backbone with evenly spaced disks, which guide the tendons that end at its tip.

    Where tendons share servos, neighbours in `tendon_angles_deg` do (first and second, third and fourth, ...): a positive
    displacement pulls the first and pays out the second. Angles are measured from +X towards +Y.
    `stiffness_variation` v tapers the bending stiffness linearly from (1 + v) at the section's base to (1 - v) at its tip.
    `precurvature_per_mm` is the curvature at rest at the section's base, fading linearly to zero at its tip;
    positive values lean the section towards +X and +Y.
    """

    length_mm: Positive = 40.0
    tendon_angles_deg: Annotated[tuple[Degrees, ...], msgspec.Meta(min_length=1, max_length=16)] = (
        0.0,
        180.0,
        90.0,
        270.0,
    )
    pitch_radius_mm: Positive = 4.0
    backbone_radius_mm: Positive = 0.4
    youngs_modulus_GPa: Positive = 60.0
    poisson_ratio: Annotated[float, msgspec.Meta(gt=-1, le=0.5)] = 0.3
    disk_spacing_mm: Positive = 4.0
    stiffness_variation: Annotated[float, msgspec.Meta(gt=-1, lt=1)] = 0.4
    precurvature_per_mm: tuple[CurvaturePerMm, CurvaturePerMm] = (0.004, -0.003)


class SimulatedRobotSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The robot on its stage; the defaults are the bench robot, two sections with two tendon pairs each."""

    sections: Annotated[tuple[SectionSettings, ...], msgspec.Meta(min_length=1, max_length=8)] = (
        SectionSettings(),
        SectionSettings(tendon_angles_deg=(45.0, 225.0, 135.0, 315.0), precurvature_per_mm=(-0.003, -0.004)),
    )

    tendons_per_servo: Literal[1, 2] = 2
    """2: a servo for each antagonistic pair; 1: a servo for each tendon, which only pulls."""
    friction_coefficient: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.14
    """Capstan coefficient between a tendon and its disks: a fraction 1 - exp(-friction * bend) of the tension is lost."""
    guide_bend_deg: Annotated[float, msgspec.Meta(ge=0, le=720)] = 90.0
    """Angle by which every tendon is turned on its way from its servo to the base, with the same friction."""
    presliding_mm: Positive = 0.05
    """How far a tendon creeps at a disk before friction is fully engaged; keeps the tip from jumping."""
    backlash_mm: NotNegative = 0.15
    """Play between a servo and its pair: the displacement lost at each reversal."""
    tendon_compliance_mm_per_N: NotNegative = 0.3
    """Stretch of one tendon from servo to tip; 0 means practically rigid."""
    pretension_N: NotNegative = 2.5
    """Tension of every tendon while the robot is straight."""
    coupling: Fraction = 1.0
    """Fraction of the pitch radius at which distal tendons cross the sections before their own; 0 leads them along the backbone."""
    gravity_m_s2: Annotated[float, msgspec.Meta(ge=0, le=20)] = 9.81
    """Gravity, along -Z."""
    backbone_density_g_cm3: NotNegative = 6.45
    disk_mass_g: NotNegative = 0.6
    tip_payload_g: NotNegative = 15.0
    damping_s: NotNegative = 0.1
    """Retardation time of the backbone (Kelvin-Voigt): a released robot straightens with this time constant."""

    centreline_points: Annotated[int, msgspec.Meta(ge=2, le=2001)] = 81


def ideal(settings: SimulatedRobotSettings) -> SimulatedRobotSettings:
    """The same build with every imperfection at strength zero; the coupling is geometry and stays."""
    sections = tuple(
        msgspec.structs.replace(section, stiffness_variation=0.0, precurvature_per_mm=(0.0, 0.0))
        for section in settings.sections
    )
    return msgspec.structs.replace(
        settings,
        sections=sections,
        friction_coefficient=0.0,
        backlash_mm=0.0,
        tendon_compliance_mm_per_N=0.0,
        gravity_m_s2=0.0,
        damping_s=0.0,
    )
