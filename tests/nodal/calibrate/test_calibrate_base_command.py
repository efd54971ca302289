"""`nodal calibrate base` by pictures of the board at the base: what is written, compared and refused."""

import dataclasses
import json

import cv2
import msgspec
import numpy as np
import pytest

from calibration.base import BasesFound
from calibration.board import Board
from messaging.board import BoardPlace, BoardSettings
from nodal.__main__ import main
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import read_bench
from nodal.calibrate.base import finding
from nodal.calibration.folder import load_cameras
from nodal.calibration_file import load_rig

AT_BASE = {"origin_mm": [-45.0, 2.0, 77.0], "x_axis": [1.0, 0.0, 0.0], "y_axis": [0.0, 0.0, -1.0]}
TURN = 0.02


@pytest.fixture
def fixture_bench(calibrated_bench):
    edit_bench_file(calibrated_bench, {"board": {"at_base": AT_BASE}})
    return calibrated_bench


@pytest.fixture
def at_base(tmp_path, places):
    """The words for pictures of the board at the base."""
    for camera, jpeg in places["here"].items():
        (tmp_path / f"base_{camera}.jpg").write_bytes(jpeg)
    return ["--images", *(f"{camera}={tmp_path}/base_{camera}.jpg" for camera in places["here"])]


def off_px(bench, jpegs):
    """How far the rig says that the board's corners are from where pictures show them: the largest distance."""
    board, robot_from_board = Board(BoardSettings()), BoardPlace(**AT_BASE).robot_from_board
    worst = 0.0
    for camera in load_rig(bench.parent / "calibration" / "rig.json"):
        seen = board.find(cv2.imdecode(np.frombuffer(jpegs[camera.camera], np.uint8), cv2.IMREAD_GRAYSCALE))
        pose = camera.camera_from_robot @ robot_from_board
        px, _ = cv2.projectPoints(
            board.points_mm[seen.ids],
            cv2.Rodrigues(pose[:3, :3])[0],
            pose[:3, 3],
            camera.intrinsics,
            camera.distortion,
        )
        worst = max(worst, np.linalg.norm(px[:, 0] - seen.px, axis=1).max())
    return worst


def by_robot(bench, by_board, turn_rad, made_at=None):
    """Leave a result of the robot's own in base.json that is turned about Z from the board's."""
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(turn_rad), -np.sin(turn_rad)], [np.sin(turn_rad), np.cos(turn_rad)]]
    robot = msgspec.structs.replace(
        by_board,
        way="robot",
        rig_from_robot=(by_board.matrix @ turn).tolist(),
        covariance=np.diag([1e-6] * 3 + [0.01] * 3).tolist(),
        cameras_made_at=load_cameras(read_bench(bench)).made_at if made_at is None else made_at,
    )
    file = bench.parent / "calibration" / "base.json"
    file.write_bytes(msgspec.json.encode(BasesFound(used="robot", robot=robot)))


def kept(bench) -> BasesFound:
    return msgspec.json.decode((bench.parent / "calibration" / "base.json").read_bytes(), type=BasesFound)


def test_the_rig_says_where_the_board_is_seen(fixture_bench, at_base, places, capsys):
    assert main(["calibrate", "base", "--config", str(fixture_bench), *at_base]) == 0
    assert "robot frame by the board, from 1 set of pictures" in capsys.readouterr().out
    assert off_px(fixture_bench, places["here"]) < 0.5
    assert kept(fixture_bench).used == "board"
    drawn = [
        cv2.imread(str(fixture_bench.parent / f"calibration/base-{camera}.jpg")) for camera in places["here"]
    ]
    assert [picture.shape for picture in drawn] == [(540, 960, 3)] * 2


def test_a_rig_that_sensing_is_not_content_with_leaves_the_one_before_beside_it(
    fixture_bench, at_base, monkeypatch, capsys
):
    def discontent(arguments):
        check = finding.Check(shape=None, refusal="no robot in left", known_length_mm=80.0)
        return dataclasses.replace(find_base(arguments), check=check)

    words = ["calibrate", "base", "--config", str(fixture_bench), *at_base]
    rig = fixture_bench.parent / "calibration" / "rig.json"
    assert main(words) == 0
    assert "next: nodal calibrate background" in capsys.readouterr().err
    good = rig.read_bytes()
    at_base_elsewhere = AT_BASE | {"origin_mm": [-40.0, 2.0, 77.0]}
    edit_bench_file(fixture_bench, {"board": {"at_base": at_base_elsewhere}})
    find_base = finding.find_base
    monkeypatch.setattr(finding, "find_base", discontent)
    assert main(words) == 3
    said = capsys.readouterr().err
    assert "next:" not in said
    assert f"no robot in left; the one before it is kept as {rig}~" in said
    assert (rig.parent / "rig.json~").read_bytes() == good != rig.read_bytes()


@pytest.mark.parametrize(("turn_rad", "named"), [(0.0, []), (TURN, ["roll"])])
def test_an_earlier_result_by_the_robot_is_compared(fixture_bench, at_base, capsys, turn_rad, named):
    words = ["calibrate", "base", "--config", str(fixture_bench), "--board", "--json", *at_base]
    assert main(words) == 0
    first = kept(fixture_bench).board
    by_robot(fixture_bench, first, turn_rad)
    capsys.readouterr()
    assert main(words) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert found["difference"]["too_large"] == named
    assert found["difference"]["roll_deg"] == pytest.approx(np.degrees(turn_rad), abs=0.01)
    assert ("board and robot disagree about the roll" in err) is bool(named)
    assert kept(fixture_bench).robot is not None


def test_a_result_among_other_cameras_is_not_compared(fixture_bench, at_base, capsys):
    words = ["calibrate", "base", "--config", str(fixture_bench), "--json", *at_base]
    assert main(words) == 0
    by_robot(fixture_bench, kept(fixture_bench).board, TURN, made_at="2020-01-01T00:00:00+00:00")
    capsys.readouterr()
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["difference"] is None
    assert kept(fixture_bench).robot is None


def test_without_a_fixture_the_board_says_nothing(calibrated_bench, at_base, capsys):
    edit_bench_file(calibrated_bench, {"board": {"at_base": None}})
    words = ["calibrate", "base", "--config", str(calibrated_bench), "--board", *at_base]
    assert main(words) == 3
    assert "has no [board.at_base]" in capsys.readouterr().err


def test_pictures_without_the_board_are_refused_and_nothing_is_written(
    fixture_bench, tmp_path, places, capsys
):
    blank = cv2.imencode(".jpg", np.full((540, 960), 90, np.uint8))[1].tobytes()
    (tmp_path / "l.jpg").write_bytes(places["here"]["left"])
    (tmp_path / "r.jpg").write_bytes(blank)
    words = ["--images", f"left={tmp_path}/l.jpg", f"right={tmp_path}/r.jpg"]
    assert main(["calibrate", "base", "--config", str(fixture_bench), *words]) == 3
    assert "camera right does not see the board at the base" in capsys.readouterr().err
    assert not (fixture_bench.parent / "calibration" / "rig.json").exists()


def test_files_cannot_show_the_robot_being_moved(fixture_bench, at_base, capsys):
    assert main(["calibrate", "base", "--config", str(fixture_bench), "--robot", *at_base]) == 2
    assert "with them only --board can be done" in capsys.readouterr().err


def test_one_camera_is_not_enough(fixture_bench, at_base, capsys):
    assert main(["calibrate", "base", "--config", str(fixture_bench), *at_base[:2]]) == 2
    assert "camera right: no pictures are given" in capsys.readouterr().err
