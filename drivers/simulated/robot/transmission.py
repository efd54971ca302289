"""From servos to tendons: play, stretch and friction.

Friction acts at every disk. Its force follows the tendon's sliding through the disk over `presliding_mm` and then stays
at the capstan limit (Prandtl's element): rate independent, hysteretic, and without jumps. Within a step the limit is the
one of the step before, so that friction has a potential and a step is a minimisation; stretch sits before the base.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.robot.equilibrium import TendonLaw, TendonPull
from drivers.simulated.robot.errors import RobotBuildError
from drivers.simulated.robot.settings import SimulatedRobotSettings
from drivers.simulated.robot.tendons import TendonRouting

Array = NDArray[np.float64]

_STIFFEST_N_PER_MM = 300.0  # what a rigid tendon means; stiffer ones only cost time


@dataclass(frozen=True)
class Friction:
    """Friction of T tendons at the K disks at which pieces begin."""

    limit_N: Array
    """(T, K) force at which a tendon slides."""
    engagement: Array
    """(T, K) share of the limit in use, -1 to 1; positive while the tendon is pulled towards the base."""
    beyond_mm: Array
    """(T, K) length of tendon beyond a disk when the engagement was taken."""


@dataclass(frozen=True)
class Transmission:
    """Servos, their play, and the tendons that they pull."""

    pull_per_displacement: Array
    """(T, D): +1 where a servo pulls a tendon, -1 where it pays out."""
    free_mm: Array
    """(T,) length of each tendon beyond the base without tension: what the straight robot takes, and what has slipped."""
    stiffness_N_per_mm: float
    pretension_N: float
    backlash_mm: float
    friction_coefficient: float
    guide_bend_rad: float
    presliding_mm: float

    def play(self, held_mm: Array, servo_mm: Array) -> Array:
        """Displacement (D,) that reaches the tendons: it moves only when the servo has crossed the play."""
        return np.clip(held_mm, servo_mm - self.backlash_mm / 2, servo_mm + self.backlash_mm / 2)

    def law(self, displacement_mm: Array, friction: Friction) -> TendonLaw:
        """The tendons' pull with displacement (D,) behind the play, sliding on from `friction`."""
        slack_mm = self.free_mm - self.pull_per_displacement @ displacement_mm
        slack_mm -= self.pretension_N / self.stiffness_N_per_mm

        def pull(distance_mm: Array) -> TendonPull:
            beyond = _beyond(distance_mm)
            stretch = np.maximum(beyond[:, 0] - slack_mm, 0.0)
            base_N = self.stiffness_N_per_mm * stretch
            trial, engaged = self._engagement(friction, beyond)
            held_N = friction.limit_N * engaged
            stored = engaged * (trial - engaged / 2)
            stiffness = friction.limit_N / self.presliding_mm * (np.abs(trial) < 1)
            stiffness[:, 0] += self.stiffness_N_per_mm * (stretch > 0)
            return TendonPull(
                energy=float(base_N @ stretch) / 2
                + self.presliding_mm * float((friction.limit_N * stored).sum()),
                base_N=base_N,
                tension_N=base_N[:, None] - np.cumsum(held_N, axis=1),
                stiffness_N_per_mm=stiffness,
            )

        return pull

    def slide(self, friction: Friction, distance_mm: Array, pull: TendonPull, bend_rad: Array) -> Friction:
        """Friction after the tendons slid to distances (T, K); the limits are those of the new pull and bend (K,)."""
        beyond = _beyond(distance_mm)
        _, engaged = self._engagement(friction, beyond)
        before_N = np.column_stack([pull.base_N, pull.tension_N[:, :-1]])
        wrap_rad = bend_rad + self.guide_bend_rad * (np.arange(len(bend_rad)) == 0)
        lost = 1 - np.exp(-self.friction_coefficient * wrap_rad)
        return Friction(lost * np.maximum(before_N, pull.tension_N).clip(0.0), engaged, beyond)

    def unengaged(self, distance_mm: Array) -> Friction:
        """Friction of a robot whose tendons have not slid yet."""
        zeros = np.zeros_like(distance_mm)
        return Friction(zeros, zeros, _beyond(distance_mm))

    def _engagement(self, friction: Friction, beyond_mm: Array) -> tuple[Array, Array]:
        trial = friction.engagement + (friction.beyond_mm - beyond_mm) / self.presliding_mm
        return trial, np.clip(trial, -1.0, 1.0)


def build_transmission(settings: SimulatedRobotSettings, routing: TendonRouting) -> Transmission:
    """Raises RobotBuildError where tendons share servos and a section has one left over."""
    return Transmission(
        pull_per_displacement=_pull_per_displacement(settings, len(routing.runs)),
        free_mm=routing.runs @ routing.piece_length_mm,
        stiffness_N_per_mm=1 / (settings.tendon_compliance_mm_per_N + 1 / _STIFFEST_N_PER_MM),
        pretension_N=settings.pretension_N,
        backlash_mm=settings.backlash_mm,
        friction_coefficient=settings.friction_coefficient,
        guide_bend_rad=np.radians(settings.guide_bend_deg),
        presliding_mm=settings.presliding_mm,
    )


def _pull_per_displacement(settings: SimulatedRobotSettings, tendons: int) -> Array:
    if settings.tendons_per_servo == 1:
        return np.eye(tendons)
    for number, section in enumerate(settings.sections, start=1):
        if len(section.tendon_angles_deg) % 2:
            raise RobotBuildError(
                f"section {number} has {len(section.tendon_angles_deg)} tendons; servos pull pairs, so the number must "
                "be even (tendons_per_servo = 1 gives every tendon its own)"
            )
    servos = tendons // 2
    both_ways: Array = np.repeat(np.eye(servos), 2, axis=0) * np.tile([[1.0], [-1.0]], (servos, 1))
    return both_ways


def _beyond(distance_mm: Array) -> Array:
    """(T, K) length from the start of each piece to the tendon's end."""
    return np.cumsum(distance_mm[:, ::-1], axis=1)[:, ::-1]
