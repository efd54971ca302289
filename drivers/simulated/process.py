"""The simulated bench's process: servos and robot move on, the scene is what was asked for, pictures are taken."""

import logging
import sys
import time
from collections.abc import Callable
from threading import Event

import numpy as np

from drivers.simulated.cameras.printed_board import printed_board
from drivers.simulated.cameras.process import camera_processes
from drivers.simulated.cameras.projection import Lens
from drivers.simulated.cameras.schedule import NS_PER_S, Pose
from drivers.simulated.cameras.worker import Setup
from drivers.simulated.hands import Hands
from drivers.simulated.mechanism import Mechanism
from drivers.simulated.photographer import LATE_S, Photographer
from drivers.simulated.robot.robot import SimulatedRobot
from drivers.simulated.scenes import Scenes
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.settings import SimulationSettings
from drivers.simulated.stage_place import StagePlace
from messaging.board import BoardSettings
from messaging.frames import CameraCalibration
from messaging.session import Session
from messaging.settings import ZenohSettings

logger = logging.getLogger(__name__)


def run(
    settings: SimulationSettings,
    calibrations: tuple[CameraCalibration, ...],
    zenoh: ZenohSettings,
    bench: str,
    board: BoardSettings,
    session: Session,
    stop: Event,
    healthy: Callable[[], None],
) -> None:
    """Simulate until `stop` is set; `board` is shown to the cameras when that is asked for. The cameras' processes open
    sessions of their own on the bench named `bench`.

    Raises LinkError, RobotBuildError, SimulatedBoardError, SimulatedCameraError.
    """
    robot = SimulatedRobot(settings.robot)
    section_end_mm = np.cumsum([section.length_mm for section in settings.robot.sections])
    setups = [
        Setup(
            calibration=calibration,
            section_end_mm=section_end_mm,
            settings=settings.cameras,
            seed=settings.seed + number,
            zenoh=zenoh,
            bench=bench,
            board=board,
        )
        for number, calibration in enumerate(calibrations)
    ]
    middle_mm = np.array([0.0, 0.0, section_end_mm[-1] / 2])
    lenses = [Lens(calibration) for calibration in calibrations]
    hands = Hands(printed_board(board).squares_mm, lenses, middle_mm, settings.seed)
    period_ns, place = int(NS_PER_S / settings.step_rate_hz), StagePlace(settings.servos.link)
    sys.setswitchinterval(0.0002)  # the servos' thread answers the bus while this one computes
    with (
        camera_processes(setups, stop.is_set) as cameras,
        EmulatedServos(settings.servos) as servos,
    ):
        mechanism = Mechanism(robot, servos, settings.drive, place)
        due_ns = time.monotonic_ns()
        scenes = Scenes(session, cameras, hands, board.at_base)
        photographer = Photographer(settings, cameras, scenes, session, due_ns)
        while not stop.is_set():
            state = mechanism.step(period_ns / NS_PER_S)
            pose = Pose(due_ns, state.shape.centreline_mm)
            scenes.attend(pose)
            photographer.look(pose)
            healthy()
            due_ns += period_ns
            behind_ns = time.monotonic_ns() - due_ns
            if behind_ns > LATE_S * NS_PER_S:
                due_ns += behind_ns // period_ns * period_ns
                logger.warning(
                    "%.2f s late: that time is left out, the robot stood still", behind_ns / NS_PER_S
                )
            stop.wait(max(0, due_ns - time.monotonic_ns()) / NS_PER_S)
    place.forget()
