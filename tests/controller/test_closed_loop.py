"""The loop against the simulated robot's mechanics, in virtual time: late and noisy shapes, lagging servos."""

import numpy as np

from controller.settings import ControllerSettings
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.robot.settings import SimulatedRobotSettings

RADIUS_MM, HEIGHT_MM = 15.0, 82.0


class Mechanics:
    """The simulated robot, moved every fourth cycle: its steps are the dear part of these tests."""

    def __init__(self):
        self._robot = SimulatedRobot(SimulatedRobotSettings())
        self._calls = 0

    def move(self, command_mm, dt_s):
        self._calls += 1
        if self._calls % 4 == 1:
            self._robot.step(command_mm[:-1], float(command_mm[-1]), 4 * dt_s)
        points = self._robot.state.shape.centreline_mm
        return points[[len(points) // 2, -1]]


def rms(error_mm):
    """Root mean square length of vectors (n, 3)."""
    return float(np.sqrt((np.asarray(error_mm) ** 2).sum(axis=1).mean()))


def open_loop_rms(command_mm, desired_mm):
    """How far the tip stays from its path when the model's commands are simply sent, without a look."""
    plant = Mechanics()
    errors = [plant.move(c, 0.005)[1] - d for c, d in zip(command_mm, desired_mm, strict=True)]
    return rms(errors[len(errors) // 3 :])


def model_commands(kinematics, desired_mm):
    """(n, A) commands with which the model alone would follow tip positions (n, 3)."""
    command, commands = np.append(np.full(kinematics.tendons, 1e-3), 2.0), []
    for desired in desired_mm:
        for _ in range(3):
            nodes, jacobian = kinematics.nodes_and_jacobian(command, np.array([80.0]))
            command = command + np.linalg.pinv(jacobian[0]) @ (desired - nodes[0])
        commands.append(command)
    return np.array(commands)


def test_circle_and_pose(stand_ins, record_property):
    settings = ControllerSettings()
    bench = stand_ins["VirtualBench"](Mechanics(), settings, noise_mm=0.03)
    bench.home()
    assert np.abs(bench.node_mm[:, :2]).max() < settings.homing.within_mm
    circle = stand_ins["circle"](radius_mm=RADIUS_MM, z_mm=HEIGHT_MM)
    assert bench.run(0.005, circle)[1][0].accepted
    bench.do("arm")
    moments, _ = bench.run(14.0)
    wanted = [m.state.task.reference.at(m.now_s).node_mm[0] for m in moments]
    error = [m.node_mm[1] - w for m, w in zip(moments, wanted, strict=True)][800:]
    circle_mm = rms(error)
    bench.run(0.005, stand_ins["pose"]((8.0, -5.0, 83.0)))
    moments, _ = bench.run(5.0)
    steady_mm = rms([m.node_mm[1] - [8.0, -5.0, 83.0] for m in moments[-200:]])
    turn = np.linspace(0.0, 2 * np.pi * 1.4, 700)
    path = np.stack([RADIUS_MM * np.cos(turn), RADIUS_MM * np.sin(turn), np.full(700, HEIGHT_MM)], axis=-1)
    commands = model_commands(settings.kinematics(stand_ins["ROBOT"]), path)
    open_mm = open_loop_rms(np.repeat(commands, 4, axis=0), np.repeat(path, 4, axis=0))
    record_property("circle_rms_mm", circle_mm)
    record_property("steady_mm", steady_mm)
    record_property("open_loop_rms_mm", open_mm)
    print(f"circle {circle_mm:.3f} mm RMS, steady {steady_mm:.3f} mm, open loop {open_mm:.3f} mm RMS")
    assert circle_mm < open_mm / 5
    assert circle_mm < 0.4
    assert steady_mm < 0.15
