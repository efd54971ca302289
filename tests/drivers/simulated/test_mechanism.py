"""Servos, drive and robot as one, with and without a stage."""

import numpy as np
import pytest

from drivers.simulated.mechanism import Mechanism
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.settings import EmulatedServosSettings
from drivers.simulated.settings import DriveSettings, SimulationSettings
from drivers.simulated.stage_place import StagePlace


@pytest.mark.parametrize(("ids", "insertion_mm"), [((1, 2, 3, 4), 0.0), ((1, 2, 3, 4, 5), 3.0)])
def test_the_last_servo_moves_the_stage_if_there_is_one(tmp_path, ids, insertion_mm):
    link = EmulatedServosSettings(link=str(tmp_path / "servos"), ids=ids)
    settings = SimulationSettings(servos=link)
    with EmulatedServos(link) as servos:
        mechanism = Mechanism(SimulatedRobot(settings.robot), servos, settings.drive, StagePlace(link.link))
        servos._bus.servos[-1].motor.position_rad = insertion_mm / settings.drive.stage_mm_per_rad
        state = mechanism.step(0.005)
    assert state.shape.centreline_mm[0, 2] == pytest.approx(insertion_mm, abs=1e-3)
    assert np.isfinite(state.shape.centreline_mm).all()


def test_the_stage_stands_where_it_stood_before_the_simulator_died(tmp_path):
    """Its servo has forgotten its turns, as one does that loses its supply; the screw has not moved."""
    link = EmulatedServosSettings(link=str(tmp_path / "servos"), ids=(1, 2, 3, 4, 5))
    settings = SimulationSettings(servos=link)
    for moved_mm in (30.0, 0.0):
        with EmulatedServos(link) as servos:
            mechanism = Mechanism(
                SimulatedRobot(settings.robot), servos, settings.drive, StagePlace(link.link)
            )
            servos._bus.servos[-1].motor.position_rad += moved_mm / settings.drive.stage_mm_per_rad
            state = mechanism.step(0.005)
            ticks = servos._bus.servos[-1].memory["present_position"]
        assert state.shape.centreline_mm[0, 2] == pytest.approx(30.0, abs=1e-2)
    assert 0 <= ticks < 4096


def test_a_pulley_that_is_wound_the_other_way_pulls_the_other_way(tmp_path):
    link = EmulatedServosSettings(link=str(tmp_path / "servos"), ids=(1, 2, 3, 4))
    lean_mm, load_Nm = [], []
    for sign in (1, -1):
        drive = DriveSettings(each_pulley_mm_per_rad=(sign * 4.5, 5.0, 5.0, 5.0))
        settings = SimulationSettings(servos=link, drive=drive)
        with EmulatedServos(link) as servos:
            mechanism = Mechanism(SimulatedRobot(settings.robot), servos, drive, StagePlace(link.link))
            for _ in range(30):
                servos._bus.servos[0].motor.position_rad = sign * 0.6
                state = mechanism.step(0.02)
            lean_mm.append(state.shape.centreline_mm[-1])
            load_Nm.append(mechanism._load_Nm[0])
    np.testing.assert_allclose(lean_mm[0], lean_mm[1], atol=0.05)
    assert load_Nm[0] == pytest.approx(-load_Nm[1], rel=0.05)
    assert load_Nm[0] > 0.01
