"""What a simulated bench really is, drawn by chance: nothing stands quite where the drawing says, and one servo is wound the other way."""

import dataclasses

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from drivers.simulated.cameras.projection import Lens
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings
from drivers.simulated.servos.settings import EmulatedServosSettings
from drivers.simulated.settings import DriveSettings, SimulationSettings
from messaging.frames import CameraCalibration
from nodal.virtual.random_bench import random_bench
from nodal.virtual.settings import VirtualBenchSettings

POSITION_MM = 10.0
ANGLE_RAD = np.deg2rad(3.0)
FOCAL = 0.03
CENTRE_PX = 30.0
DISTORTION = np.array([0.03, 0.04, 0.0006, 0.0006, 0.02])
"""How far each lies from the drawing at most, either way."""

_MARGIN_PX = 20.0


def true_cameras(seed: int) -> tuple[CameraCalibration, ...]:
    """Cameras about where the reference bench has them, all of which see the whole robot."""
    random = np.random.default_rng([seed, 0x72696720])
    cameras = _drawn(random)
    while not all(map(_sees_the_robot, cameras)):
        cameras = _drawn(random)
    return cameras


def true_simulation(seed: int) -> SimulationSettings:
    """The reference bench's robot and drive with everything that a drawing leaves open; sections are as long as it says."""
    nominal = SimulatedRobotSettings()
    bench = random_bench(seed, VirtualBenchSettings(robot=nominal))
    sections = tuple(
        _as_long_as(drawn, section)
        for drawn, section in zip(bench.robot.sections, nominal.sections, strict=True)
    )
    drive = DriveSettings()
    pulleys_mm_per_rad = [round(drive.pulley_mm_per_rad * gain, 4) for gain in bench.servos.gain[:-1]]
    other_way = int(np.random.default_rng([seed, 0x7369676E]).integers(len(pulleys_mm_per_rad)))
    pulleys_mm_per_rad[other_way] *= -1
    return SimulationSettings(
        servos=EmulatedServosSettings(link="servos", ids=(1, 2, 3, 4, 5)),
        robot=msgspec.structs.replace(bench.robot, sections=sections),
        drive=msgspec.structs.replace(drive, each_pulley_mm_per_rad=tuple(pulleys_mm_per_rad)),
        seed=seed,
    )


def _as_long_as(drawn: SectionSettings, section: SectionSettings) -> SectionSettings:
    return msgspec.structs.replace(drawn, length_mm=section.length_mm)


def _drawn(random: np.random.Generator) -> tuple[CameraCalibration, ...]:
    return tuple(_displaced(camera, random) for camera in default_cameras())


def _displaced(camera: CameraCalibration, random: np.random.Generator) -> CameraCalibration:
    def up_to(bound: float, count: int) -> NDArray[np.float64]:
        return random.uniform(-bound, bound, count)

    intrinsics, pose = camera.intrinsics.copy(), camera.camera_from_robot.copy()
    intrinsics[[0, 1], [0, 1]] *= 1 + up_to(FOCAL, 1)
    intrinsics[:2, 2] += up_to(CENTRE_PX, 2)
    rotation = Rotation.from_rotvec(up_to(ANGLE_RAD, 3)).as_matrix() @ pose[:3, :3]
    centre_mm = -pose[:3, :3].T @ pose[:3, 3] + up_to(POSITION_MM, 3)
    pose[:3, :3], pose[:3, 3] = rotation, -rotation @ centre_mm
    return dataclasses.replace(
        camera,
        intrinsics=intrinsics,
        distortion=camera.distortion + DISTORTION * up_to(1.0, 5),
        camera_from_robot=pose,
    )


def _sees_the_robot(camera: CameraCalibration) -> bool:
    """Standing straight, and bent over to any side."""
    turn = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    bent_mm = np.column_stack([45 * np.cos(turn), 45 * np.sin(turn), np.full_like(turn, 60.0)])
    lens = Lens(camera)
    pixels = lens.to_pixels(lens.to_camera(np.vstack([[0, 0, -5], [0, 0, 85], bent_mm])))
    limit = np.array([lens.width_px, lens.height_px]) - _MARGIN_PX
    return bool(((pixels > _MARGIN_PX) & (pixels < limit)).all())
