"""The calibration file: written and read back exactly, refused in words that name file, camera and key."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.cameras.rig import default_cameras
from messaging.errors import InvalidMessageError
from nodal.calibration_file import load_rig, rig_from_matrices, save_rig
from nodal.errors import CalibrationFileError


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "rig.json"
    save_rig(file, default_cameras())
    return file


def changed(file, change):
    rig = json.loads(file.read_text(encoding="utf-8"))
    change(rig)
    file.write_text(json.dumps(rig), encoding="utf-8")


def test_a_rig_is_read_back_exactly(file):
    assert load_rig(file) == default_cameras()


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda rig: rig.update(format="rig/0"), "format"),
        (lambda rig: rig.update(units="m"), "units"),
        (lambda rig: rig["cameras"].pop("left"), "cameras"),
        (lambda rig: rig["cameras"]["left"].pop("distortion"), "camera left: .*distortion"),
        (lambda rig: rig["cameras"]["left"].update(focal=1), "camera left: .*focal"),
        (lambda rig: rig["cameras"]["left"].update(width_px="wide"), r"camera left: .*width_px"),
        (lambda rig: rig["cameras"]["left"].update(width_px=1), "camera left: size 1x1080"),
        (lambda rig: rig["cameras"]["left"].update(distortion=[0, 0]), r"distortion.*\(2,\)"),
        (lambda rig: rig["cameras"]["left"].update(intrinsics=[[1, 2], [3]]), "intrinsics"),
        (
            lambda rig: rig["cameras"]["left"].update(camera_from_robot=np.ones((4, 4)).tolist()),
            "left: .*rigid",
        ),
    ],
)
def test_a_bad_file_is_refused_by_name(file, change, complaint):
    changed(file, change)

    with pytest.raises(CalibrationFileError, match=complaint) as raised:
        load_rig(file)

    assert str(raised.value).startswith(str(file))


@pytest.mark.parametrize("content", [b"", b"{", b"\x00\xff", b"[]"])
def test_what_is_no_calibration_is_refused(file, content):
    file.write_bytes(content)

    with pytest.raises(CalibrationFileError, match="not a calibration file"):
        load_rig(file)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(CalibrationFileError, match=r"none.json: cannot be read: No such file"):
        load_rig(tmp_path / "none.json")


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(CalibrationFileError, match="cannot be written"):
        save_rig(tmp_path / "nowhere" / "rig.json", default_cameras())


MATRICES = {
    "intrinsics": {camera.camera: camera.intrinsics for camera in default_cameras()},
    "distortion": {camera.camera: camera.distortion for camera in default_cameras()},
    "camera_from_robot": {camera.camera: camera.camera_from_robot for camera in default_cameras()},
}


def test_matrices_make_a_rig():
    assert rig_from_matrices((1920, 1080), **MATRICES) == default_cameras()


def test_distortion_terms_that_are_not_given_are_zero():
    rig = rig_from_matrices((1920, 1080), **{**MATRICES, "distortion": {"left": [0.1, 0.2], "right": []}})

    assert rig[0].distortion.tolist() == [0.1, 0.2, 0, 0, 0]
    assert rig[1].distortion.tolist() == [0, 0, 0, 0, 0]


def test_matrices_of_different_cameras_are_refused():
    with pytest.raises(CalibrationFileError, match=r"distortion is given for \['left'\]"):
        rig_from_matrices((1920, 1080), **{**MATRICES, "distortion": {"left": []}})


def test_more_distortion_than_the_model_knows_is_refused():
    with pytest.raises(CalibrationFileError, match="camera left: distortion has 8 terms"):
        rig_from_matrices((1920, 1080), **{**MATRICES, "distortion": {"left": [0.1] * 8, "right": []}})


def test_a_matrix_no_camera_can_have_is_refused():
    with pytest.raises(InvalidMessageError, match="camera left"):
        rig_from_matrices(
            (1920, 1080), **{**MATRICES, "intrinsics": {"left": -np.eye(3), "right": np.eye(3)}}
        )


def test_the_documented_conversion_works(tmp_path, monkeypatch):
    text = (Path(__file__).parents[2] / "docs" / "calibration-file.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    source = {
        "image_size": [1920, 1080],
        "cameras": {
            camera.camera: {
                "K": camera.intrinsics.tolist(),
                "dist": camera.distortion.tolist(),
                "camera_from_robot": camera.camera_from_robot.tolist(),
            }
            for camera in default_cameras()
        },
    }
    (tmp_path / "calibration.json").write_text(json.dumps(source), encoding="utf-8")
    monkeypatch.chdir(tmp_path)

    exec(compile(example, "docs/calibration-file.md", "exec"), {})

    assert load_rig(tmp_path / "rig.json") == default_cameras()
