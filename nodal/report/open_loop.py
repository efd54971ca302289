"""What the same circle would have been without feedback.

The controller's own constant-curvature model, with the tendons' nominal geometry and nothing fitted, is solved for the
commands of the desired path; a second simulated robot, at rest when it begins, is driven with them. Its servos are taken
as ideal, so what remains is the mechanics alone: the error is, if anything, smaller than on the whole bench.
"""

import numpy as np
from numpy.typing import NDArray

from controller.kinematics import Kinematics
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.robot.settings import SimulatedRobotSettings

Array = NDArray[np.float64]

STEP_S = 0.02
APPROACH_S = 2.0
SOLVER_STEPS = 60
DAMPING_MM = 0.1


def open_loop_path(
    desired_mm: Array, time_s: Array, arc_mm: Array, kinematics: Kinematics, settings: SimulatedRobotSettings
) -> Array:
    """Where the nodal points (T, M, 3) at arc lengths (M,) go instead of `desired_mm` (T, M, 3) at times (T,)."""
    commands = np.zeros((len(time_s), kinematics.axes))
    command = np.zeros(kinematics.axes)
    for row, places in enumerate(desired_mm):
        command = solved(kinematics, arc_mm, places, command)
        commands[row] = command
    robot = SimulatedRobot(settings)
    for share in np.arange(STEP_S, APPROACH_S, STEP_S) / APPROACH_S:
        _drive(robot, share * commands[0])
    line_arc_mm = np.linspace(
        0, sum(section.length_mm for section in settings.sections), settings.centreline_points
    )
    moments = np.arange(time_s[0], time_s[-1], STEP_S)
    reached = np.empty((len(moments), len(arc_mm), 3))
    for row, moment in enumerate(moments):
        line = _drive(robot, _interpolated(moment, time_s, commands))
        reached[row] = _interpolated_points(arc_mm, line_arc_mm, line)
    return np.stack(
        [
            np.column_stack([np.interp(time_s, moments, reached[:, node, axis]) for axis in range(3)])
            for node in range(len(arc_mm))
        ],
        axis=1,
    )


def solved(kinematics: Kinematics, arc_mm: Array, places_mm: Array, command: Array) -> Array:
    """The command (A,) that brings the model's points at `arc_mm` (M,) to `places_mm` (M, 3), by damped Gauss-Newton."""
    for _ in range(SOLVER_STEPS):
        nodes, jacobian = kinematics.nodes_and_jacobian(command, arc_mm)
        rows, missing = jacobian.reshape(-1, kinematics.axes), (places_mm - nodes).ravel()
        if np.abs(missing).max() < 1e-3:
            break
        inner = rows.T @ rows + DAMPING_MM**2 * np.eye(kinematics.axes)
        command = command + np.linalg.solve(inner, rows.T @ missing)
    return command


def _drive(robot: SimulatedRobot, command: Array) -> Array:
    return robot.step(command[:-1], float(command[-1]), STEP_S).shape.centreline_mm


def _interpolated(at: float, times: Array, rows: Array) -> Array:
    return np.array([np.interp(at, times, column) for column in rows.T])


def _interpolated_points(arc_mm: Array, line_arc_mm: Array, line_mm: Array) -> Array:
    return np.column_stack([np.interp(arc_mm, line_arc_mm, axis) for axis in line_mm.T])
