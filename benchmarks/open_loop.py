"""How far an open-loop constant-curvature model misses the simulated robot: `python -m benchmarks.open_loop`.

The model is the common one: the curvature vector of each section is a linear map of the servo displacements plus an
offset, each section is a circular arc, the base pose is known. All 20 numbers are fitted by least squares to the tip.
It is fitted on half of the moves and judged on the other half, and once more fitted and judged on all of them.
"""

import argparse
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.robot.settings import SimulatedRobotSettings, ideal

Array = NDArray[np.float64]

MOVES = 40
MOVE_S = 1.5
REST_S = 0.3
STEP_S = 0.03
LARGEST_BEND_RAD = np.radians(100)  # with stretch and friction the sections bend to about 80 degrees

IMPERFECTIONS: dict[str, dict[str, Any]] = {
    "friction": {"friction_coefficient": 0.0},
    "backlash": {"backlash_mm": 0.0},
    "tendon stretch": {"tendon_compliance_mm_per_N": 0.0},
    "section coupling": {"coupling": 0.0},
    "gravity": {"gravity_m_s2": 0.0},
    "body damping": {"damping_s": 0.0},
}
SECTION_IMPERFECTIONS: dict[str, dict[str, Any]] = {
    "stiffness variation": {"stiffness_variation": 0.0},
    "precurvature": {"precurvature_per_mm": (0.0, 0.0)},
}


@dataclass(frozen=True)
class Motion:
    """Servo displacements over time, and which move each belongs to."""

    servo_mm: Array
    """(M, D)."""
    move: NDArray[np.intp]
    """(M,)."""


@dataclass(frozen=True)
class OpenLoopError:
    """RMS of the tip error, in mm."""

    unseen_mm: float
    """Fitted on half of the moves, judged on the other half."""
    seen_mm: float
    """Fitted and judged on all moves."""


def workspace_motion(settings: SimulatedRobotSettings, seed: int, moves: int) -> Motion:
    """Smooth moves between random bends of all sections, each followed by a short rest."""
    rng = np.random.default_rng(seed)
    sections = len(settings.sections)
    size = LARGEST_BEND_RAD * np.sqrt(rng.random((moves + 1, sections)))
    heading = 2 * np.pi * rng.random((moves + 1, sections))
    bends = np.stack([size * np.cos(heading), size * np.sin(heading)], axis=2)
    bends[0] = 0.0
    waypoints = bends.reshape(moves + 1, -1) @ _servo_per_bend(settings).T
    moving = np.arange(1, round(MOVE_S / STEP_S) + 1) * STEP_S / MOVE_S
    share = np.concatenate([(1 - np.cos(np.pi * moving)) / 2, np.ones(round(REST_S / STEP_S))])
    servo_mm = waypoints[:-1, None] + share[None, :, None] * np.diff(waypoints, axis=0)[:, None]
    return Motion(servo_mm.reshape(-1, servo_mm.shape[2]), np.repeat(np.arange(moves), len(share)))


def simulated_tips(settings: SimulatedRobotSettings, servo_mm: Array) -> Array:
    """Tip positions (M, 3) in the robot frame, in mm."""
    robot = SimulatedRobot(settings)
    return np.array([robot.step(row, 0.0, STEP_S).shape.centreline_mm[-1] for row in servo_mm])


def constant_curvature_tips(curvature_per_mm: Array, length_mm: Array) -> Array:
    """Tips (M, 3) of sections that are circular arcs, with curvature (M, S, 2) towards x and y and length (S,)."""
    count = len(curvature_per_mm)
    frame = np.broadcast_to(np.eye(3), (count, 3, 3))
    tip = np.zeros((count, 3))
    for section, length in enumerate(length_mm):
        bend = curvature_per_mm[:, section] * length
        angle = np.linalg.norm(bend, axis=1)
        sine, rise = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
        arc = np.column_stack([rise[:, None] * bend, sine]) * length
        tip = tip + (frame @ arc[:, :, None])[:, :, 0]
        turn = np.zeros((count, 3, 3))
        turn[:, :2, 2] = bend
        turn[:, 2, :2] = -bend
        frame = frame @ (np.eye(3) + sine[:, None, None] * turn + rise[:, None, None] * (turn @ turn))
    return tip


def fit_constant_curvature(settings: SimulatedRobotSettings, servo_mm: Array, tip_mm: Array) -> Array:
    """Linear map and offset (D + 1, 2 S) from servo displacements to curvatures, by least squares on the tip."""
    length = _lengths(settings)
    inputs = _with_offset(servo_mm)
    start = np.zeros((inputs.shape[1], 2 * len(length)))
    start[:-1] = np.linalg.pinv(_servo_per_bend(settings)).T / np.repeat(length, 2)

    def residual(numbers: Array) -> Array:
        return (_predicted_tips(numbers.reshape(start.shape), inputs, length) - tip_mm).ravel()

    fitted: Array = least_squares(residual, start.ravel(), x_scale="jac").x
    return fitted.reshape(start.shape)


def open_loop_error(settings: SimulatedRobotSettings, seed: int, moves: int = MOVES) -> OpenLoopError:
    """The model's error over a seeded set of moves through the workspace."""
    motion = workspace_motion(settings, seed, moves)
    tip_mm = simulated_tips(settings, motion.servo_mm)
    first_half = motion.move % 2 == 0

    def rms(fitted: NDArray[np.bool_], judged: NDArray[np.bool_]) -> float:
        numbers = fit_constant_curvature(settings, motion.servo_mm[fitted], tip_mm[fitted])
        predicted = _predicted_tips(numbers, _with_offset(motion.servo_mm[judged]), _lengths(settings))
        return float(np.sqrt(((predicted - tip_mm[judged]) ** 2).sum(axis=1).mean()))

    everything = np.ones_like(first_half)
    return OpenLoopError(unseen_mm=rms(first_half, ~first_half), seen_mm=rms(everything, everything))


def without(settings: SimulatedRobotSettings) -> Iterable[tuple[str, SimulatedRobotSettings]]:
    """The settings with one imperfection at a time switched off."""
    for name, change in IMPERFECTIONS.items():
        yield name, msgspec.structs.replace(settings, **change)
    for name, change in SECTION_IMPERFECTIONS.items():
        sections = tuple(msgspec.structs.replace(section, **change) for section in settings.sections)
        yield name, msgspec.structs.replace(settings, sections=sections)


def main() -> None:
    """Print the error of the default bench robot and what each imperfection adds to it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the moves (default: 1)")
    seed = parser.parse_args().seed
    settings = SimulatedRobotSettings()
    length = float(_lengths(settings).sum())
    print(f"tip error of the fitted constant-curvature model, RMS over {MOVES} moves, {length:g} mm robot")
    print(f"{'':32}{'unseen moves':>20}{'all moves':>20}")

    def row(name: str, error: OpenLoopError) -> None:
        cells = (f"{mm:7.2f} mm {100 * mm / length:6.1f} %" for mm in (error.unseen_mm, error.seen_mm))
        print(f"{name:32}" + "".join(f"{cell:>20}" for cell in cells), flush=True)

    row("bench robot", open_loop_error(settings, seed))
    for name, changed in without(settings):
        row(f"  without {name}", open_loop_error(changed, seed))
    row("ideal robot", open_loop_error(ideal(settings), seed))


def _lengths(settings: SimulatedRobotSettings) -> Array:
    return np.array([section.length_mm for section in settings.sections])


def _with_offset(servo_mm: Array) -> Array:
    return np.column_stack([servo_mm, np.ones(len(servo_mm))])


def _predicted_tips(numbers: Array, inputs: Array, length_mm: Array) -> Array:
    return constant_curvature_tips((inputs @ numbers).reshape(len(inputs), -1, 2), length_mm)


def _servo_per_bend(settings: SimulatedRobotSettings) -> Array:
    """(D, 2 S): displacement that textbook geometry asks for, per bend of each section towards x and y."""
    rows = []
    for own, section in enumerate(settings.sections):
        for angle in np.radians(section.tendon_angles_deg[::2]):
            pulled = section.pitch_radius_mm * np.array([np.cos(angle), np.sin(angle)])
            rows.append(
                np.concatenate([pulled * (crossed <= own) for crossed in range(len(settings.sections))])
            )
    return np.array(rows)


if __name__ == "__main__":
    main()
