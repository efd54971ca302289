"""The simulated robot: a tendon-driven continuum robot on a linear stage, moved by the displacements of its servos.

Mechanics only: no clock and no input or output. The body has no inertia; each step is one implicit Euler step of a
Kelvin-Voigt rod with frictional tendons, found by minimising its incremental energy.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivers.simulated.robot.backbone import build_backbone
from drivers.simulated.robot.equilibrium import Balance, Mechanics, Pose, TendonPull
from drivers.simulated.robot.errors import NoEquilibriumError, RobotBuildError, RobotInputError
from drivers.simulated.robot.settings import SimulatedRobotSettings
from drivers.simulated.robot.shape import Sampling, Shape
from drivers.simulated.robot.tendons import route_tendons
from drivers.simulated.robot.transmission import Friction, build_transmission

Array = NDArray[np.float64]

_NEWTON_STEPS = 8  # a bound on the cost of a step; what is left is made up for in the next
_NEWTON_STEPS_FROM_REST = 200


@dataclass(frozen=True)
class RobotState:
    """What the robot does after a step."""

    shape: Shape
    insertion_mm: float
    tendon_tension_N: Array
    """(T,) at the base, never negative; tendons section by section in the order of their settings."""
    servo_load_N: Array
    """(D,) net pull on each servo: positive pulls back a positive displacement."""


@dataclass(frozen=True)
class _Memory:
    """What a step leaves to the next one."""

    pose: Pose
    pulled_mm: Array
    friction: Friction


def static_shape(settings: SimulatedRobotSettings, tension_N: ArrayLike, insertion_mm: float = 0.0) -> Shape:
    """The shape at rest under tensions (T,) in N, the same along each tendon.

    Friction, stretch and play have no part in it. Raises RobotInputError for unusable tensions and NoEquilibriumError
    where the solver finds no rest.
    """
    mechanics = _mechanics(settings)
    tension = _checked("tension_N", tension_N, (len(mechanics.routing.runs),))
    if (tension < 0).any():
        raise RobotInputError(
            f"tension_N is {tension.tolist()}; tendons only pull, so all must be at least 0"
        )
    along = tension[:, None] * mechanics.routing.runs
    none = np.zeros_like(along)

    def constant(distance_mm: Array) -> TendonPull:
        return TendonPull(float((along * distance_mm).sum()), tension, along, none)

    start = mechanics.pose(mechanics.backbone.rest_strain_per_mm)
    rest, settled = mechanics.descend(start, constant, _NEWTON_STEPS_FROM_REST)
    if not settled:
        raise NoEquilibriumError(f"no shape at rest found for tension_N {tension.tolist()}")
    return Sampling(mechanics.backbone, settings.centreline_points).shape(rest.pose, insertion_mm)


class SimulatedRobot:
    """A robot that remembers: its pose, where its play lies and how its tendons rub.

    Servos are numbered section by section, one for each pair of tendons or for each tendon, as the settings say.
    """

    def __init__(self, settings: SimulatedRobotSettings) -> None:
        """At rest with all servos at zero. Raises RobotBuildError and NoEquilibriumError."""
        self._damping_s = settings.damping_s
        self._unpushed = self._mechanics = _mechanics(settings)
        self._pushed_N = np.zeros_like(self._mechanics.backbone.disk_force_N)
        self._sampling = Sampling(self._mechanics.backbone, settings.centreline_points)
        self._transmission = build_transmission(settings, self._mechanics.routing)
        self.pull_per_displacement = self._transmission.pull_per_displacement
        """(T, D): +1 where a servo pulls a tendon, -1 where it pays out."""
        self.servos = self.pull_per_displacement.shape[1]
        start = self._mechanics.pose(self._mechanics.backbone.rest_strain_per_mm)
        nothing_pulled = np.zeros(self.servos)
        law = self._transmission.law(nothing_pulled, self._transmission.unengaged(start.path.distance_mm))
        rest, settled = self._mechanics.descend(start, law, _NEWTON_STEPS_FROM_REST)
        if not settled:
            raise NoEquilibriumError("no shape at rest found for a robot whose servos are all at zero")
        unengaged = self._transmission.unengaged(rest.pose.path.distance_mm)
        self._memory = self._remember(rest, nothing_pulled, unengaged)
        self.state = self._state(rest, 0.0)

    def step(self, servo_displacement_mm: ArrayLike, insertion_mm: float, dt_s: float) -> RobotState:
        """Advance by `dt_s` with the servos at displacement (D,) and the stage at `insertion_mm`.

        Raises RobotInputError for values that are not finite, of the wrong shape, or a dt_s that is not positive.
        """
        servo_mm = _checked("servo_displacement_mm", servo_displacement_mm, (self.servos,))
        _checked("insertion_mm", insertion_mm, ())
        if not 0 < dt_s < np.inf:
            raise RobotInputError(f"dt_s is {dt_s}; it must be positive and finite")
        memory = self._memory
        pulled = self._transmission.play(memory.pulled_mm, servo_mm)
        slowed = self._mechanics.backbone.slowed(memory.pose.strain, self._damping_s / dt_s)
        law = self._transmission.law(pulled, memory.friction)
        moved, _ = replace(self._mechanics, backbone=slowed).descend(memory.pose, law, _NEWTON_STEPS)
        self._memory = self._remember(moved, pulled, memory.friction)
        self.state = self._state(moved, insertion_mm)
        return self.state

    def push(self, force_N: ArrayLike, disk: int = -1) -> None:
        """Push the disk at the end of piece `disk` with a force (3,) in the robot frame, until it is pushed otherwise.

        Raises RobotInputError for a force that is not finite and for a disk that is not there.
        """
        count = len(self._pushed_N)
        if not -count <= disk < count:
            raise RobotInputError(f"disk is {disk}; the robot has {count}, counted from 0 or back from -1")
        self._pushed_N[disk] = _checked("force_N", force_N, (3,))
        self._bear()

    def slip(self, tendon_mm: ArrayLike) -> None:
        """Let tendons (T,) become longer by so much where they are fastened, or shorter where negative.

        Raises RobotInputError for lengths that are not finite, or not one for each tendon.
        """
        slipped_mm = _checked("tendon_mm", tendon_mm, self._transmission.free_mm.shape)
        self._transmission = replace(self._transmission, free_mm=self._transmission.free_mm + slipped_mm)

    def rebuild(self, settings: SimulatedRobotSettings) -> None:
        """Go on with other settings: another payload, stiffness, friction, play and so on; what was pushed or slipped stays.

        Raises RobotBuildError when pieces or tendons would be others.
        """
        mechanics = _mechanics(settings)
        before = self._mechanics
        if not (
            np.array_equal(before.backbone.piece_length_mm, mechanics.backbone.piece_length_mm)
            and np.array_equal(before.routing.side_mm, mechanics.routing.side_mm)
        ):
            raise RobotBuildError("a robot keeps its sections, disks and tendons while it runs")
        transmission = build_transmission(settings, mechanics.routing)
        self._transmission = replace(transmission, free_mm=self._transmission.free_mm)
        self._damping_s = settings.damping_s
        self._unpushed = mechanics
        self._bear()

    def _bear(self) -> None:
        """Take up what has changed of the pushes or of the build."""
        backbone = self._unpushed.backbone
        backbone = replace(backbone, disk_force_N=backbone.disk_force_N + self._pushed_N)
        self._mechanics = replace(self._unpushed, backbone=backbone)
        self._memory = replace(self._memory, pose=self._mechanics.pose(self._memory.pose.strain))

    def _remember(self, moved: Balance, pulled_mm: Array, friction: Friction) -> _Memory:
        strain = moved.pose.strain.reshape(-1, 3)
        turn_rad = np.hypot(strain[:, 0], strain[:, 1]) * self._mechanics.backbone.piece_length_mm
        # a tendon turns at the disk between two pieces by the mean of theirs, and at the base by half of the first's
        bend_rad = (turn_rad + np.concatenate([[0.0], turn_rad[:-1]])) / 2
        slid = self._transmission.slide(friction, moved.pose.path.distance_mm, moved.pull, bend_rad)
        return _Memory(moved.pose, pulled_mm, slid)

    def _state(self, moved: Balance, insertion_mm: float) -> RobotState:
        shape = self._sampling.shape(moved.pose, insertion_mm)
        tension = moved.pull.base_N
        return RobotState(shape, insertion_mm, tension, self.pull_per_displacement.T @ tension)


def _mechanics(settings: SimulatedRobotSettings) -> Mechanics:
    backbone = build_backbone(settings)
    return Mechanics(backbone, route_tendons(settings, backbone))


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        raise RobotInputError(f"{name} is {array.tolist()}; it must be finite and of shape {shape}")
    return array
