"""Calibrations that MATLAB made."""

import numpy as np
import pytest
from scipy.io import savemat

from nodal.calibration.formats.calibration import Choices
from nodal.calibration.formats.reading import read_calibration
from nodal.errors import CalibrationFileError

EXACT = 1e-12


def matlab_camera(**fields):
    """As cameraParameters' toStruct lays a camera out, up to R2022a: a 960 x 1280 camera with two radial terms."""
    return {
        "RadialDistortion": [-0.4, 0.18],
        "TangentialDistortion": [0.001, -0.002],
        "ImageSize": [960.0, 1280.0],
        "WorldPoints": np.zeros((20, 2)),
        "WorldUnits": "millimeters",
        "EstimateSkew": False,
        "NumRadialDistortionCoefficients": 2.0,
        "EstimateTangentialDistortion": True,
        "RotationVectors": np.zeros((9, 3)),
        "TranslationVectors": np.zeros((9, 3)),
        "ReprojectionErrors": np.zeros((20, 2, 9)),
        "IntrinsicMatrix": [[1410.0, 0.0, 0.0], [0.0, 1411.0, 0.0], [611.0, 552.0, 1.0]],
        "Version": {"Name": "Computer Vision Toolbox", "Version": "9.1", "Release": "(R2019a)"},
        **fields,
    }


def matlab_pair(**fields):
    turn = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]  # rows: x' = -y, y' = x
    return {
        "CameraParameters1": matlab_camera(),
        "CameraParameters2": matlab_camera(),
        "RotationOfCamera2": turn,
        "TranslationOfCamera2": [-110.0, 2.0, 30.0],
        **fields,
    }


def test_a_matlab_struct_counts_pixels_from_one_and_writes_points_as_rows(tmp_path):
    savemat(tmp_path / "stereo.mat", {"stereoParams": matlab_pair(), "other": 3.0})
    first, second = read_calibration([tmp_path / "stereo.mat"], None, Choices()).cameras.cameras
    assert (first.width_px, first.height_px) == (1280, 960)
    assert first.intrinsics == ((1410, 0, 610), (0, 1411, 551), (0, 0, 1))
    assert first.distortion == (-0.4, 0.18, 0.001, -0.002, 0)
    assert second.camera_from_rig == ((0, -1, 0, -110), (1, 0, 0, 2), (0, 0, 1, 30), (0, 0, 0, 1))


def test_a_newer_matlab_struct_has_k_and_a_pose(tmp_path):
    newer = matlab_camera(K=[[1410.0, 0.0, 611.0], [0.0, 1411.0, 552.0], [0.0, 0.0, 1.0]], RadialDistortion=[-0.4, 0.18, 0.05], WorldUnits="m")  # fmt: skip
    del newer["IntrinsicMatrix"]
    pair = matlab_pair(CameraParameters1=newer, CameraParameters2=newer)
    del pair["RotationOfCamera2"], pair["TranslationOfCamera2"]
    pair["PoseCamera2"] = {
        "R": [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        "Translation": [-0.11, 0.002, 0.03],
    }
    savemat(tmp_path / "stereo.mat", {"s": pair})
    first, second = read_calibration([tmp_path / "stereo.mat"], None, Choices()).cameras.cameras
    assert first.intrinsics == ((1410, 0, 610), (0, 1411, 551), (0, 0, 1))
    assert first.distortion == (-0.4, 0.18, 0.001, -0.002, 0.05)
    assert second.camera_from_rig == ((0, -1, 0, -110), (1, 0, 0, 2), (0, 0, 1, 30), (0, 0, 0, 1))


@pytest.mark.parametrize(
    ("pair", "complaint"),
    [
        (matlab_pair(CameraParameters1=matlab_camera(IntrinsicMatrix=[[1410.0, 0.0, 0.0], [3.0, 1411.0, 0.0], [611.0, 552.0, 1.0]])), "a skew of 3 px"),
        (matlab_pair(CameraParameters1=matlab_camera(RadialDistortion=[0.1, 0.1, 0.1, 0.1])), "4 coefficients of RadialDistortion"),
        (matlab_pair(CameraParameters1=matlab_camera(WorldUnits="furlongs")), "WorldUnits are 'furlongs'; say with --units"),
        ({"K": np.eye(3)}, "no struct with CameraParameters1 and CameraParameters2"),
        (matlab_pair(CameraParameters1=5.0), "no struct with CameraParameters1 and CameraParameters2"),
    ],
)  # fmt: skip
def test_what_matlab_says_and_sensing_cannot_use_is_refused(tmp_path, pair, complaint):
    savemat(tmp_path / "stereo.mat", {"s": pair})
    with pytest.raises(CalibrationFileError, match=complaint):
        read_calibration([tmp_path / "stereo.mat"], None, Choices())


@pytest.mark.parametrize("place", [144, 777, 809])  # scipy 1.17: UnboundLocalError, SIGSEGV, SIGBUS
def test_a_damaged_mat_file_brings_nothing_down(tmp_path, place):
    file = tmp_path / "stereo.mat"
    savemat(file, {"s": matlab_pair()}, long_field_names=True)
    damaged = bytearray(file.read_bytes())
    damaged[place] = 255
    file.write_bytes(damaged)
    with pytest.raises(CalibrationFileError, match=r"a damaged \.mat file: "):
        read_calibration([file], None, Choices())


def test_a_mat_file_of_version_7_3_is_refused_with_what_to_do(tmp_path):
    file = tmp_path / "stereo.mat"
    file.write_bytes(
        b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116)
        + b"\0" * 8
        + b"\0\2IM"
        + b"\x89HDF\r\n\x1a\n".rjust(512, b"\0")
    )
    with pytest.raises(CalibrationFileError, match=r"saved as version 7\.3.*-v7"):
        read_calibration([file], None, Choices())
