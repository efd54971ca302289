"""How a bench that was brought up is judged: what is right gives zeros, what is wrong its size."""

import dataclasses
import re

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.bring_up_truth import camera_errors, robot_figures, robot_frame_error
from calibration.camera_set import CameraSet
from controller.identified import Drawing, IdentifiedSettings
from nodal.calibrate.robot.calibrating import ROBOT
from nodal.calibrate.robot.results import Foreseen, RobotFound
from nodal.calibration.folder import CAMERAS, save_json
from nodal.calibration_file import load_rig, save_rig
from nodal.new.writing import write_simulated


@pytest.fixture
def bench(tmp_path):
    write_simulated(tmp_path / "bench", 5)
    (tmp_path / "bench" / "calibration").mkdir()
    return tmp_path / "bench"


def test_cameras_that_are_right_have_no_error_and_others_theirs(bench):
    true = load_rig(bench / "true-rig.json")
    save_json(bench / "calibration" / CAMERAS, CameraSet.of_rig(true))
    right = camera_errors(bench)
    assert max(right["focal off px"], right["centre off px"], right["baseline off mm"]) < 1e-9
    longer = dataclasses.replace(true[1], intrinsics=true[1].intrinsics + np.diag([3.0, 0, 0]))
    save_json(bench / "calibration" / CAMERAS, CameraSet.of_rig([true[0], longer]))
    assert camera_errors(bench)["focal off px"] == pytest.approx(3.0)


def test_a_robot_frame_is_off_by_where_it_lies_in_the_true_one(bench):
    moved = np.eye(4)
    moved[:3, :3] = Rotation.from_rotvec([0, 0, 0.5], degrees=True).as_matrix()
    moved[:3, 3] = [0.3, 0.0, 0.4]
    wrong = [
        dataclasses.replace(camera, camera_from_robot=camera.camera_from_robot @ moved)
        for camera in load_rig(bench / "true-rig.json")
    ]
    save_rig(bench / "calibration" / "rig.json", wrong)
    assert robot_frame_error(bench) == pytest.approx({"origin off mm": 0.5, "axes off deg": 0.5})


def test_pulleys_that_are_believed_to_be_wound_the_right_way_are_counted(bench):
    found = RobotFound(
        date="",
        seconds=1.0,
        length_mm=80.0,
        poses=1,
        refused=0,
        reversed=(),
        axes=(),
        fit_rms_mm=1.0,
        held_out=Foreseen(poses=1, before_mm=6.0, after_mm=2.0, nodes=()),
        identified=IdentifiedSettings(
            date="",
            drawing=Drawing(
                section_length_mm=(), angle_deg=(), pitch_radius_mm=(), coupling=1.0, mm_per_rad=()
            ),
            gain=(),
            gain_sigma=(),
            bias_rad=(),
            bias_sigma_rad=(),
            lost_motion_mm=(),
            lost_motion_sigma_mm=(),
        ),
    )
    (bench / "calibration" / ROBOT).write_bytes(msgspec.json.encode(found))
    assert robot_figures(bench) == {"signs right": 3, "open loop as drawn mm": 6, "as identified mm": 2}
    file = bench / "bench.toml"
    text = file.read_text(encoding="utf-8")
    for value in re.search(r"each_pulley_mm_per_rad = \[(.*)\]", text)[1].split(", "):
        text = text.replace("mm_per_rad = 5.0,", f"mm_per_rad = {value},", 1)
    file.write_text(text, encoding="utf-8")
    assert robot_figures(bench)["signs right"] == 4
