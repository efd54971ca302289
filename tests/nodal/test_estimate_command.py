"""`nodal estimate` from the outside: files in, one JSON object or one line out."""

import json
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from messaging.frames import CameraCalibration
from nodal.__main__ import main
from nodal.calibration_file import save_rig
from nodal.commands import estimate
from sensing.settings import MethodName

DONE, ERROR, REFUSED = 0, 2, 3
CURVATURE_PER_MM, HEADING_RAD = 0.012, 2.6
SIZE_PX = 960, 540


def on_arc(arc_mm):
    """Points (n, 3) at distances (n,) from the base of a circular arc."""
    angle = CURVATURE_PER_MM * np.asarray(arc_mm, dtype=float)
    aside = (1 - np.cos(angle)) / CURVATURE_PER_MM
    return np.column_stack(
        [aside * np.cos(HEADING_RAD), aside * np.sin(HEADING_RAD), np.sin(angle) / CURVATURE_PER_MM]
    )


def half_size(calibration):
    intrinsics = calibration.intrinsics.copy()
    intrinsics[:2] /= 2
    intrinsics[:2, 2] -= 0.25
    return CameraCalibration(
        camera=calibration.camera,
        width_px=SIZE_PX[0],
        height_px=SIZE_PX[1],
        intrinsics=intrinsics,
        distortion=calibration.distortion,
        camera_from_robot=calibration.camera_from_robot,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A rig, a photograph of an arc by each camera, and photographs that show no robot."""
    made = tmp_path_factory.mktemp("still")
    rig = tuple(map(half_size, default_cameras()))
    save_rig(made / "rig.json", rig)
    save_rig(made / "large.json", default_cameras())
    for seed, camera in enumerate(rig):
        renderer = Renderer(camera, np.array([40.0, 80.0]), SimulatedCamerasSettings(), seed)
        robot = on_arc(np.arange(81))
        jpeg = renderer.render(robot, robot)
        (made / f"{camera.camera}.jpg").write_bytes(jpeg)
        (made / f"cut_{camera.camera}.jpg").write_bytes(jpeg[: len(jpeg) // 2])
        cv2.imwrite(str(made / f"grey_{camera.camera}.png"), np.full((540, 960, 3), 128, np.uint8))
        # the picture's upper part shows neither robot nor holder: repeated, it is the bare backdrop
        picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        bare = np.vstack([picture[:60]] * 9)
        cv2.imwrite(str(made / f"bare_{camera.camera}.jpg"), bare)
    (made / "words.jpg").write_text("not a picture")
    (made / "nothing.jpg").write_bytes(b"")
    return made


def words(folder, left="left.jpg", right="right.jpg", *more, rig="rig.json"):
    return [
        "estimate",
        "--calibration",
        str(folder / rig),
        "--image",
        f"left={folder / left}",
        "--image",
        f"right={folder / right}",
        *more,
    ]


def from_shell(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "nodal", *arguments], capture_output=True, text=True, check=False, timeout=120
    )


@pytest.fixture
def nodal(capfd):
    """Run in this process: an exception that would be a trace-back fails the test by itself."""

    def _nodal(*arguments):
        try:
            status = main(arguments)
        except SystemExit as ended:
            status = ended.code
        captured = capfd.readouterr()
        return status, captured.out, captured.err

    return _nodal


def test_the_shape_of_an_arc_as_one_json_object(folder):
    ran = from_shell(*words(folder, "left.jpg", "right.jpg", "--nodes", "10,40,79.5", "--json"))
    assert (ran.returncode, ran.stderr) == (DONE, "")
    assert ran.stdout.count("\n") == 1
    said = json.loads(ran.stdout)
    assert list(said) == [
        "method",
        "nodes",
        "centreline_mm",
        "length_mm",
        "known_length_mm",
        "cameras",
        "ray_gap_mm",
        "ray_bias_mm",
        "least_epipolar_angle",
        "flags",
        "stage_ms",
    ]
    assert said["method"] == "refined"
    assert [set(node) for node in said["nodes"]] == [{"name", "arc_mm", "position_mm", "sigma_mm"}] * 3
    assert [node["name"] for node in said["nodes"]] == ["10", "40", "79.5"]
    assert [node["arc_mm"] for node in said["nodes"]] == [10.0, 40.0, 79.5]
    places = np.array([node["position_mm"] for node in said["nodes"]])
    assert np.linalg.norm(places - on_arc([10, 40, 79.5]), axis=1).max() < 0.3
    assert all(0.001 < node["sigma_mm"] < 0.3 for node in said["nodes"])
    assert np.array(said["centreline_mm"]).shape[1] == 3
    assert said["length_mm"] == pytest.approx(80, abs=0.5)
    assert said["known_length_mm"] is None
    assert [camera["name"] for camera in said["cameras"]] == ["left", "right"]
    assert all(0 < camera["residual_px"] < 1 and 60 < camera["visible_mm"] < 81 for camera in said["cameras"])
    assert 0 <= said["ray_bias_mm"] < 0.1
    assert 1 < said["least_epipolar_angle"]["angle_deg"] < 90
    assert 0 <= said["least_epipolar_angle"]["arc_mm"] <= said["length_mm"]
    assert said["flags"] == []
    assert set(said["stage_ms"]) == {"decode", "backdrop", "cold_start", "refine", "judge"}
    # milliseconds, not seconds: no machine finds a robot in less than one
    assert sum(said["stage_ms"].values()) > 1


def test_the_papers_steps_find_the_arc_too(folder, nodal):
    status, out, err = nodal(
        *words(folder, "left.jpg", "right.jpg", "--method", "plain", "--length", "80", "--json")
    )
    assert (status, err) == (DONE, "")
    said = json.loads(out)
    assert (said["method"], said["known_length_mm"]) == ("plain", 80)
    places = np.array([node["position_mm"] for node in said["nodes"]])
    assert np.linalg.norm(places - on_arc([10, 20, 40, 80]), axis=1).max() < 1.0
    assert set(said["stage_ms"]) == {"decode", "segment", "skeleton", "triangulate", "judge"}


def test_there_are_as_many_methods_as_the_bench_file_knows():
    assert set(estimate.METHODS) == set(MethodName)


@pytest.mark.parametrize("method", estimate.METHODS)
def test_colour_threshold_and_work_area_say_what_the_robot_is(folder, nodal, method):
    colour_bgr = np.median(cv2.imread(str(folder / "left.jpg")).reshape(-1, 3), axis=0)
    colour = ",".join(f"{level:g}" for level in colour_bgr[::-1])
    backdrop = "--method", method, "--colour", colour, "--json"
    status, out, _ = nodal(*words(folder, "left.jpg", "right.jpg", *backdrop, "--threshold", "45"))
    places = np.array([node["position_mm"] for node in json.loads(out)["nodes"]])
    assert status == DONE
    assert np.linalg.norm(places - on_arc([10, 20, 40, 80]), axis=1).max() < 1.5
    status, out, _ = nodal(*words(folder, "left.jpg", "right.jpg", *backdrop, "--threshold", "400"))
    assert status == REFUSED
    assert "threshold 400" in json.loads(out)["refused"]
    base_alone = "--work-area", "left=300,350;660,350;660,539;300,539", "--nodes", "10"
    status, out, _ = nodal(*words(folder, "left.jpg", "right.jpg", *backdrop, *base_alone))
    assert status == REFUSED or json.loads(out)["flags"]


def test_a_refusal_as_one_json_object(folder):
    ran = from_shell(*words(folder, "left.jpg", "bare_right.jpg", "--json"))
    assert (ran.returncode, ran.stderr) == (REFUSED, "")
    said = json.loads(ran.stdout)
    assert list(said) == ["refused"]
    assert said["refused"].startswith("camera right: nothing stands out from the backdrop")


def test_an_error_as_one_line(folder):
    ran = from_shell(*words(folder, "missing.jpg", "right.jpg", "--json"))
    assert (ran.returncode, ran.stdout) == (ERROR, "")
    assert (
        ran.stderr == f"nodal: error: {folder / 'missing.jpg'}: cannot be read: No such file or directory\n"
    )


@pytest.mark.parametrize(
    ("left", "right", "reason"),
    [
        ("bare_left.jpg", "bare_right.jpg", "camera left: nothing stands out from the backdrop"),
        ("grey_left.png", "grey_right.png", "camera left: nothing stands out from the backdrop"),
        ("cut_left.jpg", "right.jpg", r"camera left: the JPEG of \d+ bytes is cut off"),
        ("left.jpg", "nothing.jpg", r"camera right: the picture is empty \(0 bytes\)"),
        ("words.jpg", "right.jpg", "camera left: 13 bytes are not a picture"),
    ],
    ids=["no robot", "one colour", "cut off", "empty", "words"],
)
def test_pictures_that_show_no_shape_are_refused(folder, nodal, left, right, reason):
    status, out, err = nodal(*words(folder, left, right, "--json"))
    assert (status, err) == (REFUSED, "")
    said = json.loads(out)
    assert list(said) == ["refused"]
    assert re.match(reason, said["refused"])


def test_a_refusal_in_words(folder, nodal):
    status, out, _ = nodal(*words(folder, "left.jpg", "bare_right.jpg"))
    assert status == REFUSED
    assert out.startswith("refused: camera right: ")


def test_a_table_for_people(folder, nodal):
    status, out, err = nodal(*words(folder, "left.jpg", "right.jpg", "--length", "80"))
    assert (status, err) == (DONE, "")
    method, *lines = out.splitlines()
    assert method == "method refined"
    assert [line.split()[0] for line in lines[1:5]] == ["10", "20", "40", "80"]
    assert lines[0].split()[0] == "node"
    assert re.search(r"^length (79|80)\.\d\d mm, [+-]0\.\d\d mm against the known 80 mm$", out, re.MULTILINE)
    assert re.search(r"^camera left: residual 0\.\d\d px, sees \d\d\.\d mm$", out, re.MULTILINE)
    assert re.search(r"^mean ray gap 0\.\d{3} mm, bias [+-]0\.\d{3} mm$", out, re.MULTILINE)
    assert re.search(
        r"^least angle to the epipolar direction \d+ degrees, \d+ mm from the base$", out, re.MULTILINE
    )
    assert "flags: none" in out


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--nodes", "10,95"], "nodal point at 95 mm is beyond the robot, whose centreline is"),
        (["--nodes", "40,10"], r"distances \[40.0, 10.0\] mm must increase"),
        (["--nodes", "10,10"], "different"),
        (["--nodes", "nan"], "not finite"),
        (["--nodes", "1e999"], "not finite"),
        (["--nodes=-5,10"], "must increase from 0 or more"),
        (["--length", "-80"], "--length -80 mm is not a length"),
        (["--length", "nan"], "--length nan mm is not a length"),
        (["--image", "top=left.jpg"], r"the calibration has no camera 'top', only \['left', 'right'\]"),
        (["--background", "top=left.jpg"], r"the calibration has no camera 'top', only \['left', 'right'\]"),
        (["--background", "left=missing.jpg"], "missing.jpg: cannot be read: No such file or directory"),
        (["--image", "left=."], r"\.: cannot be read: Is a directory"),
        (["--threshold", "0"], "--threshold 0 is not a colour distance; above 0 and up to 442 levels are"),
        (["--threshold", "nan"], "--threshold nan is not a colour distance"),
        (["--colour", "60,300,75"], "--colour 60,300,75 is not a colour; each of R, G and B is 0 to 255"),
        (
            ["--work-area", "top=1,1;9,1;9,9"],
            r"the calibration has no camera 'top', only \['left', 'right'\]",
        ),
        (
            ["--work-area", "left=1,1;9,1"],
            "--work-area left has the shape \\(2, 2\\); a polygon is 3 corners",
        ),
        (["--work-area", "left=1,1;9,1;9,9"], "--work-area left does not contain the robot's base"),
        (["--work-area", "left=0,0;3000,0;3000,539"], "--work-area left has a corner \\[3000, 0\\] outside"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_arguments_that_mean_nothing_possible_are_one_line(folder, nodal, more, message):
    status, out, err = nodal(*words(folder, "left.jpg", "right.jpg", *more))
    assert (status, out) == (ERROR, "")
    assert err.startswith("nodal: error: ")
    assert err.count("\n") == 1
    assert re.search(message, err)


@pytest.mark.parametrize("nodes", ["", "ten", "10;20", "10,,20"])
def test_a_list_that_is_none_is_told_with_an_example(folder, nodal, nodes):
    status, out, err = nodal(*words(folder, "left.jpg", "right.jpg", f"--nodes={nodes}"))
    assert (status, out) == (ERROR, "")
    assert f"{nodes!r} is not a list of distances in mm, such as 10,20,40,80" in err.splitlines()[-1]


@pytest.mark.parametrize(
    ("option", "value", "example"),
    [
        ("--colour", "green", "R,G,B, such as 60,140,75"),
        ("--colour", "60,140", "R,G,B, such as 60,140,75"),
        ("--work-area", "left", "NAME=X,Y;X,Y;..., such as left=600,200;1300,200;"),
        ("--work-area", "left=600,200;1300", "NAME=X,Y;X,Y;..., such as left=600,200;1300,200;"),
    ],
)
def test_a_value_that_cannot_be_read_is_told_with_an_example(folder, nodal, option, value, example):
    status, out, err = nodal(*words(folder, "left.jpg", "right.jpg", option, value))
    assert (status, out) == (ERROR, "")
    assert f"{value!r} is not {example}" in err.splitlines()[-1]


def test_one_image_is_too_few(folder, nodal):
    status, _, err = nodal(*words(folder)[:5])
    assert status == ERROR
    assert err == "nodal: error: --image is given for ['left'] only; a shape takes two cameras or more\n"


def test_a_calibration_of_another_size_names_both(folder, nodal):
    status, _, err = nodal(*words(folder, rig="large.json"))
    assert status == ERROR
    assert err == (
        "nodal: error: camera left: the picture is 960x540 px, its calibration is for 1920x1080 px\n"
    )


@pytest.mark.parametrize(
    ("rig", "message"),
    [("missing.json", "missing.json: cannot be read"), ("words.jpg", "words.jpg: not a calibration file")],
)
def test_a_calibration_that_cannot_be_used(folder, nodal, rig, message):
    status, _, err = nodal(*words(folder, rig=rig))
    assert status == ERROR
    assert err.startswith("nodal: error: ")
    assert message in err
    assert err.count("\n") == 1


def test_pictures_of_every_stage_are_drawn(folder, nodal, tmp_path):
    pytest.importorskip("matplotlib")
    figures = tmp_path / "new" / "figures"
    status, _, err = nodal(*words(folder, "left.jpg", "right.jpg", "--figures", str(figures)))
    assert (status, err) == (DONE, "")
    made = sorted(figures.iterdir())
    assert [file.name for file in made] == [
        f"estimate-{what}.{kind}" for what in ("along", "cameras", "space") for kind in ("pdf", "png")
    ]
    assert all(cv2.imread(str(file)).std() > 5 for file in made if file.suffix == ".png")


def test_a_folder_for_figures_that_cannot_be_made_is_one_line(folder, nodal):
    pytest.importorskip("matplotlib")
    status, _, err = nodal(
        *words(folder, "left.jpg", "right.jpg", "--figures", str(folder / "words.jpg" / "in"))
    )
    assert status == ERROR
    assert err.count("\n") == 1
    assert "--figures" in err


def test_a_refusal_is_drawn_with_what_there_is(folder, nodal, tmp_path):
    pytest.importorskip("matplotlib")
    for right in ("bare_right.jpg", "nothing.jpg"):
        figures = tmp_path / right
        status, _, err = nodal(*words(folder, "left.jpg", right, "--figures", str(figures)))
        assert (status, err) == (REFUSED, "")
        assert sorted(file.name for file in figures.iterdir()) == [
            "estimate-refused.pdf",
            "estimate-refused.png",
        ]
