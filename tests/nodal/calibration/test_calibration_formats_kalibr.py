"""Calibrations that Kalibr made."""

import pytest

from nodal.__main__ import main
from nodal.bench_file import load_bench
from nodal.calibration.formats.calibration import Choices
from nodal.calibration.formats.reading import read_calibration
from nodal.calibration_file import save_rig
from nodal.errors import CalibrationFileError

EXACT = 1e-12
# as kalibr_calibrate_cameras writes a camchain
KALIBR = """cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 1.9e-04, 1.7e-05]
  distortion_model: radtan
  intrinsics: [458.6, 457.2, 367.2, 248.3]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, -0.11]
  - [1.0, 0.0, 0.0, 0.02]
  - [0.0, 0.0, 1.0, 0.03]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.27, 0.08, 0.0, 0.0]
  distortion_model: radtan
  intrinsics: [457.5, 456.1, 379.9, 255.2]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
"""


def test_a_kalibr_chain_is_in_metres(tmp_path):
    file = tmp_path / "camchain.yaml"
    file.write_text(KALIBR)
    first, second = read_calibration([file], None, Choices()).cameras.cameras
    assert first.distortion == (-0.28, 0.07, 1.9e-4, 1.7e-5, 0)
    assert second.intrinsics == ((457.5, 0, 379.9), (0, 456.1, 255.2), (0, 0, 1))
    assert second.camera_from_rig == ((0, -1, 0, -110), (1, 0, 0, 20), (0, 0, 1, 30), (0, 0, 0, 1))


@pytest.mark.parametrize(
    ("line", "instead", "complaint"),
    [
        ("distortion_model: radtan", "distortion_model: equidistant", "pinhole with distortion_model equidistant"),
        ("camera_model: pinhole", "camera_model: omni", "camera_model omni"),
        ("  - [0.0, 0.0, 1.0, 0.03]\n", "", "T_cn_cnm1 should be 4 x 4 numbers"),
        ("resolution: [752, 480]", "resolution: [752, .nan]", "not all of them are finite"),
        ("intrinsics: [458.6, 457.2, 367.2, 248.3]", "", "cam0: intrinsics is missing"),
        ("  - [1.0, 0.0, 0.0, 0.02]", "  - [2.0, 0.0, 0.0, 0.02]", "is not a rigid transform"),
        (KALIBR, "cam0: 5\ncam1: 7", "cam0: 5 stands where camera_model and other keys should"),
    ],
)  # fmt: skip
def test_what_kalibr_says_and_sensing_cannot_use_is_refused(tmp_path, line, instead, complaint):
    file = tmp_path / "camchain.yaml"
    file.write_text(KALIBR.replace(line, instead, 1))
    with pytest.raises(CalibrationFileError, match=complaint):
        read_calibration([file], "kalibr", Choices())


def test_k3_is_not_dropped_silently(tmp_path, capsys):
    save_rig(tmp_path / "rig.json", load_bench("simulated").rig)
    words = [str(tmp_path / "rig.json"), str(tmp_path / "k.yaml"), "--to", "kalibr"]
    assert main(["calibration", "convert", *words]) == 2
    shown = capsys.readouterr().err
    assert "camera left has k3 = 0.027" in shown
    assert "--drop-k3" in shown
    assert not (tmp_path / "k.yaml").exists()
    assert main(["calibration", "convert", *words, "--drop-k3"]) == 0
    assert "camera left: k3 is left out, which costs" in capsys.readouterr().out
