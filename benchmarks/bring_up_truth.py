"""What a bench that was brought up believes, against what it really is. Lengths in mm, angles in degrees."""

from pathlib import Path

import msgspec
import numpy as np
from scipy.spatial.transform import Rotation

from messaging.frames import CameraCalibration
from nodal.bench_file import read_bench
from nodal.calibrate.robot.calibrating import ROBOT
from nodal.calibrate.robot.results import RobotFound
from nodal.calibration.folder import calibration_folder, load_cameras
from nodal.calibration_file import load_rig

BENCH, TRUE_RIG = "bench.toml", "true-rig.json"


def camera_errors(folder: Path) -> dict[str, float]:
    """The worst of the lenses, and how far the cameras stand wrongly to the first one."""
    bench, true = read_bench(folder / BENCH), _true(folder)
    believed = load_cameras(bench).cameras
    first = true[believed[0].name].camera_from_robot
    poses = [
        (np.array(camera.camera_from_rig), true[camera.name].camera_from_robot @ np.linalg.inv(first))
        for camera in believed[1:]
    ]
    focal = [
        abs(camera.intrinsics[axis][axis] - true[camera.name].intrinsics[axis, axis])
        for camera in believed
        for axis in (0, 1)
    ]
    centre = [
        np.hypot(*(np.array(camera.intrinsics)[:2, 2] - true[camera.name].intrinsics[:2, 2]))
        for camera in believed
    ]
    return {
        "views": float(load_cameras(bench).views_used),
        "focal off px": float(max(focal)),
        "centre off px": float(max(centre)),
        "held-out px": max(camera.held_out_rms_px or np.nan for camera in believed),
        "baseline off mm": float(max(abs(_length(a) - _length(b)) for a, b in poses)),
        "camera angle off deg": max(_angle_deg(a @ np.linalg.inv(b)) for a, b in poses),
    }


def robot_frame_error(folder: Path) -> dict[str, float]:
    """Where the calibrated robot frame lies in the true one, by the camera by which it lies worst."""
    true = _true(folder)
    moved = [
        np.linalg.inv(true[camera.camera].camera_from_robot) @ camera.camera_from_robot
        for camera in load_rig(Path(read_bench(folder / BENCH).settings.calibration))
    ]
    return {
        "origin off mm": max(map(_length, moved)),
        "axes off deg": max(map(_angle_deg, moved)),
    }


def robot_figures(folder: Path) -> dict[str, float]:
    """How many pulleys are believed to be wound the way they are, and by how much moves without feedback go astray, RMS."""
    bench = read_bench(folder / BENCH)
    settings = bench.settings
    believed = np.array([axis.mm_per_rad for axis in settings.servos.tendons])
    true = np.array(settings.simulation.drive.each_pulley_mm_per_rad) if settings.simulation else believed
    held_out = msgspec.json.decode((calibration_folder(bench) / ROBOT).read_bytes(), type=RobotFound).held_out
    return {
        "signs right": float((np.sign(believed) == np.sign(true)).sum()),
        "open loop as drawn mm": held_out.before_mm,
        "as identified mm": held_out.after_mm,
    }


def _true(folder: Path) -> dict[str, CameraCalibration]:
    return {camera.camera: camera for camera in load_rig(folder / TRUE_RIG)}


def _length(pose: np.ndarray) -> float:
    return float(np.linalg.norm(pose[:3, 3]))


def _angle_deg(pose: np.ndarray) -> float:
    return float(np.degrees(Rotation.from_matrix(pose[:3, :3]).magnitude()))
