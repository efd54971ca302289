"""Calibrations of other tools: there and back without a change, and files as those tools write them."""

import dataclasses
import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from calibration.camera_set import CameraSet
from nodal.__main__ import main
from nodal.bench_file import load_bench
from nodal.calibration.formats.calibration import Calibration, Choices
from nodal.calibration.formats.reading import read_calibration, write_calibration
from nodal.calibration_file import load_rig, save_rig
from nodal.errors import CalibrationFileError

EXACT = 1e-12

# as samples/cpp/stereo_calib.cpp writes intrinsics.yml and extrinsics.yml; the sizes are not in them
OPENCV_INTRINSICS = """%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3e+02, 0., 3.2e+02, 0., 5.3e+02, 2.4e+02, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -2.8e-01, 2.5e-02, 1.2e-03, -2.8e-04, 1.4e-01 ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.31e+02, 0., 3.25e+02, 0., 5.31e+02, 2.5e+02, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -2.9e-01, 1.0e-01, -6.1e-04, -1.5e-04, 0. ]
"""
OPENCV_EXTRINSICS = """%YAML:1.0
---
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0., 0., -1., 0., 1., 0., 1., 0., 0. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -3.5, 0.25, 4.0 ]
Q: !!opencv-matrix
   rows: 1
   cols: 1
   dt: d
   data: [ 1. ]
"""
# as samples/cpp/tutorial_code/calib3d/camera_calibration writes one camera
OPENCV_SINGLE = """<?xml version="1.0"?>
<opencv_storage>
<calibration_time>"Thu 01 Jan 2026 10:00:00"</calibration_time>
<image_width>640</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    657. 0. 318. 0. 658. 241. 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -0.4 0.7 0.001 0.002 -0.5</data></distortion_coefficients>
</opencv_storage>
"""
# as camera_calibration's cameracalibrator.py saves a stereo pair
ROS = """image_width: 640
image_height: 480
camera_name: {name}
camera_matrix:
  rows: 3
  cols: 3
  data: [500., 0., {cx}, 0., 501., 240., 0., 0., 1.]
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.3, 0.1, 0.001, 0.002, 0.]
rectification_matrix:
  rows: 3
  cols: 3
  data: [{rectification}]
projection_matrix:
  rows: 3
  cols: 4
  data: [400., 0., 320., {shift}, 0., 400., 240., 0., 0., 0., 1., 0.]
"""


def placed(rig_from_robot):
    """The cameras of the simulated bench, with the robot where it is said to be."""
    rig = load_bench("simulated").rig
    return Calibration(cameras=CameraSet.of_rig(rig), rig_from_robot=rig_from_robot)


def numbers_of(cameras):
    return np.concatenate(
        [
            np.concatenate(
                [
                    np.ravel(camera.intrinsics),
                    camera.distortion,
                    np.ravel(camera.camera_from_rig),
                    [camera.width_px, camera.height_px],
                ]
            )
            for camera in cameras.cameras
        ]
    )


cameras = st.builds(
    lambda focal, centre, terms, turn, along: {
        "intrinsics": ((focal[0], 0.0, centre[0]), (0.0, focal[1], centre[1]), (0.0, 0.0, 1.0)),
        "distortion": terms,
        "turn": turn,
        "along": along,
    },
    st.tuples(*[st.floats(300, 3000)] * 2),
    st.tuples(*[st.floats(100, 1800)] * 2),
    st.tuples(*[st.floats(-0.2, 0.2)] * 2, *[st.floats(-0.01, 0.01)] * 2, st.floats(-0.1, 0.1)),
    st.tuples(*[st.floats(-0.6, 0.6)] * 3),
    st.tuples(st.floats(20, 400), *[st.floats(-100, 100)] * 2),
)


def made(one, other):
    template = CameraSet.of_rig(load_bench("simulated").rig).cameras[0]
    place = np.eye(4)
    place[:3, :3] = Rotation.from_rotvec(other["turn"]).as_matrix()
    place[:3, 3] = other["along"]
    return CameraSet(
        cameras=tuple(
            msgspec.structs.replace(
                template,
                name=name,
                intrinsics=values["intrinsics"],
                distortion=values["distortion"],
                camera_from_rig=tuple(map(tuple, where.tolist())),
            )
            for name, values, where in (("one", one, np.eye(4)), ("other", other, place))
        )
    )


@settings(max_examples=25, deadline=None)
@given(
    one=cameras, other=cameras, form=st.sampled_from(["opencv", "xml", "ros", "kalibr", "matlab", "cameras"])
)
def test_there_and_back_nothing_changes(tmp_path_factory, one, other, form):
    folder = tmp_path_factory.mktemp("there")
    if form == "kalibr":
        one, other = ({**values, "distortion": (*values["distortion"][:4], 0.0)} for values in (one, other))
    before = made(one, other)
    names = ("one", "other")
    out = folder / {"opencv": "o.yml", "xml": "o.xml", "ros": "ros", "kalibr": "k.yaml", "matlab": "m.mat", "cameras": "c.json"}[form]  # fmt: skip
    write_calibration(out, "opencv" if form == "xml" else form, Calibration(cameras=before), Choices())
    files = [out / f"{name}.yaml" for name in names] if form == "ros" else [out]
    after = read_calibration(files, None, Choices(names=names)).cameras
    assert [camera.name for camera in after.cameras] == ["one", "other"]
    np.testing.assert_allclose(numbers_of(after), numbers_of(before), rtol=EXACT, atol=EXACT * 400)


def test_a_rig_stays_a_rig_and_loses_its_robot_frame_elsewhere_with_a_note(tmp_path):
    rig = load_bench("simulated").rig
    save_rig(tmp_path / "rig.json", rig)
    whole = read_calibration([tmp_path / "rig.json"], None, Choices())
    write_calibration(tmp_path / "again.json", None, whole, Choices())
    for one, other in zip(rig, load_rig(tmp_path / "again.json"), strict=True):
        np.testing.assert_allclose(other.camera_from_robot, one.camera_from_robot, atol=1e-12)
    _, written = write_calibration(tmp_path / "m.mat", None, whole, Choices())
    assert "the robot frame is left out" in written.notes


def test_opencv_samples_in_two_files_take_the_size_from_the_command_line(tmp_path, capsys):
    (tmp_path / "intrinsics.yml").write_text(OPENCV_INTRINSICS)
    (tmp_path / "extrinsics.yml").write_text(OPENCV_EXTRINSICS)
    words = [
        str(tmp_path / "intrinsics.yml"),
        str(tmp_path / "extrinsics.yml"),
        str(tmp_path / "cameras.json"),
    ]
    assert main(["calibration", "convert", *words]) == 2
    assert "the size of the pictures is not in it; give it with --size" in capsys.readouterr().err
    assert (
        main(
            ["calibration", "convert", *words, "--size", "640x480", "--units", "cm", "--names", "left,right"]
        )
        == 0
    )
    left, right = json.loads((tmp_path / "cameras.json").read_text())["cameras"]
    assert (left["name"], left["width_px"], left["height_px"]) == ("left", 640, 480)
    assert left["distortion"] == [-0.28, 0.025, 0.0012, -0.00028, 0.14]
    assert right["intrinsics"][1] == [0, 531, 250]
    assert right["camera_from_rig"] == [[0, 0, -1, -35], [0, 1, 0, 2.5], [1, 0, 0, 40], [0, 0, 0, 1]]


def test_single_cameras_need_poses_from_elsewhere(tmp_path):
    files = [tmp_path / f"{name}.xml" for name in ("left", "right")]
    for file in files:
        file.write_text(OPENCV_SINGLE)
    with pytest.raises(CalibrationFileError, match="does not say where the cameras left, right stand"):
        read_calibration(files, None, Choices())
    poses = CameraSet.of_rig(load_bench("simulated").rig)
    found = read_calibration(files, None, Choices(poses=poses)).cameras
    np.testing.assert_allclose(found.cameras[1].camera_from_rig, poses.cameras[1].camera_from_rig, atol=1e-12)
    assert found.cameras[1].intrinsics == ((657, 0, 318), (0, 658, 241), (0, 0, 1))
    assert found.cameras[1].distortion == (-0.4, 0.7, 0.001, 0.002, -0.5)


def ros_pair(folder, *, shift="-48.", model="plumb_bob"):
    identity, quarter = "1., 0., 0., 0., 1., 0., 0., 0., 1.", "0., 0., 1., 0., 1., 0., -1., 0., 0."
    for name, cx, rectification, moved in (("left", 320, identity, "0."), ("right", 330, quarter, shift)):
        text = ROS.format(name=name, cx=cx, model=model, rectification=rectification, shift=moved)
        (folder / f"{name}.yaml").write_text(text)
    return [folder / "left.yaml", folder / "right.yaml"]


def test_a_rectified_ros_pair_says_where_its_cameras_stand(tmp_path):
    left, right = read_calibration(ros_pair(tmp_path), None, Choices()).cameras.cameras
    assert (left.name, right.name, right.intrinsics[0]) == ("left", "right", (500, 0, 330))
    # R_2 x_2 = x_1 + (-48 / 400 m, 0, 0), and R_2 turns z into x: x_2 = (-z, y, x) of that
    np.testing.assert_allclose(
        right.camera_from_rig, [[0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, -120], [0, 0, 0, 1]]
    )


def test_ros_cameras_that_are_no_pair_need_poses(tmp_path):
    with pytest.raises(CalibrationFileError, match="does not say where the cameras left, right stand"):
        read_calibration(ros_pair(tmp_path, shift="0."), None, Choices())
    with pytest.raises(CalibrationFileError, match="distortion_model equidistant"):
        read_calibration(ros_pair(tmp_path, model="equidistant"), None, Choices())
    with pytest.raises(CalibrationFileError, match="it holds one camera"):
        read_calibration(ros_pair(tmp_path)[:1], None, Choices())


@pytest.mark.parametrize(
    ("part", "instead", "complaint"),
    [
        ("rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [{rectification}]", "rectification_matrix: 3", "rectification_matrix: 3 stands where data"),
        ("data: [400., 0., 320.", "data: [0., 0., 320.", "projection_matrix has a focal length of 0"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("error")
def test_ros_pairs_that_cannot_be_are_refused(tmp_path, monkeypatch, part, instead, complaint):
    assert part in ROS
    monkeypatch.setattr(f"{__name__}.ROS", ROS.replace(part, instead))
    with pytest.raises(CalibrationFileError, match=complaint):
        read_calibration(ros_pair(tmp_path), None, Choices())


def test_cameras_from_elsewhere_are_told_from_others_by_when_they_were_brought(tmp_path):
    cameras = placed(None).cameras
    assert cameras.made_at == ""
    write_calibration(tmp_path / "cameras.json", None, Calibration(cameras=cameras), Choices())
    brought = read_calibration([tmp_path / "cameras.json"], None, Choices())
    age = datetime.now(UTC) - datetime.fromisoformat(brought.cameras.made_at)
    assert timedelta(seconds=-1) < age < timedelta(minutes=10)
    write_calibration(tmp_path / "again.json", "cameras", brought, Choices())
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "cameras.json").read_bytes()


def test_no_cameras_are_no_calibration(tmp_path):
    (tmp_path / "cameras.json").write_text('{"cameras": []}')
    with pytest.raises(CalibrationFileError, match=r"not a file of calibrated cameras: .* length >= 1"):
        read_calibration([tmp_path / "cameras.json"], None, Choices())


@pytest.mark.parametrize("terms", [8, 12, 14])
def test_larger_lens_models_are_refused_by_name(tmp_path, terms):
    name = {8: "rational", 12: "thin prism", 14: "tilted sensor"}[terms]
    more = ", ".join(["0."] * (terms - 6) + ["0.1"])
    text = OPENCV_INTRINSICS.replace("cols: 5", f"cols: {terms}").replace("1.4e-01 ]", f"1.4e-01, {more} ]")
    text = text.replace("-1.5e-04, 0. ]", f"-1.5e-04, 0., {more} ]")
    (tmp_path / "i.yml").write_text(text)
    (tmp_path / "e.yml").write_text(OPENCV_EXTRINSICS)
    with pytest.raises(CalibrationFileError, match=f"OpenCV's {name} model"):
        read_calibration([tmp_path / "i.yml", tmp_path / "e.yml"], None, Choices(size_px=(640, 480)))


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("a.yml", "%YAML:1.0\n---\nM1: !!opencv-matrix\n  rows: [", "not a file of OpenCV's FileStorage"),
        ("a.yaml", "hello: 1", "not a calibration that is known here"),
        ("a.mat", "no", "not a .mat file"),
        ("a.json", "{", "not JSON"),
        ("a.json", "{}", "not a file of calibrated cameras"),
        ("k.yaml", "cam0: {\n", "not YAML"),
        ("k.yaml", "cam0: {camera_model: pinhole}", "a camchain of two cameras or more"),
    ],
)
def test_a_file_that_is_none_is_one_line_and_status_2(tmp_path, capsys, name, content, complaint):
    (tmp_path / name).write_text(content)
    assert main(["calibration", "convert", str(tmp_path / name), str(tmp_path / "out.json")]) == 2
    shown = capsys.readouterr().err
    assert complaint in shown
    assert shown.count("\n") == 1
    assert not (tmp_path / "out.json").exists()


def test_errors_name_what_is_missing(tmp_path, capsys):
    assert main(["calibration", "convert", str(tmp_path / "no.json"), str(tmp_path / "o.json")]) == 2
    assert "no.json: cannot be read: No such file" in capsys.readouterr().err
    save_rig(tmp_path / "rig.json", load_bench("simulated").rig)
    assert main(["calibration", "convert", str(tmp_path / "rig.json"), str(tmp_path / "o.yaml")]) == 2
    assert "say with --to which" in capsys.readouterr().err
    assert (
        main(
            ["calibration", "convert", str(tmp_path / "rig.json"), str(tmp_path / "o.json"), "--names", "a,a"]
        )
        == 2
    )
    assert "cannot be called a, a" in capsys.readouterr().err
    assert main(["calibration", "convert", str(tmp_path / "rig.json"), str(Path("/nowhere/o.mat"))]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_a_calibration_without_a_robot_is_no_rig(tmp_path):
    with pytest.raises(CalibrationFileError, match="nodal calibrate base"):
        write_calibration(tmp_path / "rig.json", "rig", dataclasses.replace(placed(None)), Choices())


def test_a_longer_kalibr_chain_is_placed_link_by_link(tmp_path):
    step = np.eye(4)
    step[:3, :3] = Rotation.from_rotvec([0.1, 0.5, -0.2]).as_matrix()
    step[:3, 3] = -150, 10, 20
    two = placed(None).cameras.cameras
    three = msgspec.structs.replace(
        two[1],
        name="third",
        camera_from_rig=tuple(map(tuple, (step @ np.array(two[1].camera_from_rig)).tolist())),
    )
    flat = tuple(msgspec.structs.replace(one, distortion=(*one.distortion[:4], 0.0)) for one in (*two, three))
    chain = Calibration(cameras=CameraSet(cameras=flat))
    write_calibration(tmp_path / "k.yaml", "kalibr", chain, Choices())
    after = read_calibration([tmp_path / "k.yaml"], None, Choices(names=("left", "right", "third"))).cameras
    np.testing.assert_allclose(numbers_of(after), numbers_of(chain.cameras), atol=1e-10)
    with pytest.raises(CalibrationFileError, match="3 cameras does not fit into the format matlab"):
        write_calibration(tmp_path / "m.mat", None, chain, Choices())
