"""`nodal calibrate cameras` as it is typed, from pictures of a board, and what it keeps and refuses."""

import contextlib
import dataclasses
import io
import json
import shutil

import numpy as np
import pytest

from calibration.camera_set import CameraSet
from drivers.cameras import CameraFrame, CameraSilentError
from messaging.errors import NodalError
from nodal.__main__ import main
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import read_bench
from nodal.calibrate import ending
from nodal.calibrate.cameras import calibrating
from nodal.calibrate.cameras.calibrating import still_skew_s
from nodal.calibrate.cameras.kept_views import kept_pictures, kept_views
from nodal.calibrate.cameras.taking import Taking
from nodal.calibrate.cameras.verdict import Grade, judgements, overall
from nodal.calibration.folder import cameras_in
from nodal.calibration_file import load_rig, save_rig
from nodal.exit_status import REFUSED
from nodal.toml_file import read_table, written

LOOK = Taking.look
RATE_HZ = 15.0


def images(folder):
    """The words that stand for these pictures."""
    return ["--images", f"left={folder}/*_left.jpg", f"right={folder}/*_right.jpg"]


def calibrated(bench, folder, *more):
    return main(["calibrate", "cameras", "--config", str(bench), *images(folder), *more])


def angle_deg(cameras: CameraSet):
    turn = np.array(cameras.cameras[1].camera_from_rig)[:3, :3]
    return np.degrees(np.arccos((np.trace(turn) - 1) / 2))


@pytest.fixture
def few(tmp_path, shots):
    """The first two views."""
    folder = tmp_path / "few"
    folder.mkdir()
    for file in sorted(shots.iterdir())[:4]:
        shutil.copy(file, folder)
    return folder


def test_pictures_become_cameras_with_the_views_and_a_report_beside_them(first_calibration, shots):
    bench, printed = first_calibration
    folder = bench.parent / "calibration"
    cameras = cameras_in(folder / "cameras.json")
    assert [camera.name for camera in cameras.cameras] == ["left", "right"]
    for camera in cameras.cameras:
        assert np.array(camera.intrinsics)[:2, 2] == pytest.approx((480, 270), abs=0.5)
        assert np.diag(camera.intrinsics)[:2] == pytest.approx(720, abs=0.5)
    assert angle_deg(cameras) == pytest.approx(50, abs=0.02)
    assert list(cameras.views_rejected) == ["12"]
    assert cameras.made_at
    assert set(kept_views(folder).rig_from_board) == {f"{number:02d}" for number in range(12)}
    pictures = kept_pictures(folder, ("left", "right"))
    assert pictures["05"]["right"].read_bytes() == (shots / "05_right.jpg").read_bytes()
    assert (folder / "report.html").exists()
    assert "verdict: good" in printed
    assert "view 12 rejected: left: no marker of DICT_4X4_50 is in sight" in printed
    assert "elsewhere" not in printed
    assert f"next: nodal calibrate base --config {bench}" in printed


def test_what_was_kept_is_calibrated_again_and_compared_with_the_calibration_file(calibrated_bench, capsys):
    folder = calibrated_bench.parent / "calibration"
    first = cameras_in(folder / "cameras.json")
    rig = first.in_robot_frame(np.eye(4))
    shift = np.eye(4)
    shift[0, 3] = 2.0
    moved = dataclasses.replace(rig[1], camera_from_robot=shift @ rig[1].camera_from_robot)
    save_rig(folder / "rig.json", [rig[0], moved])
    before = (folder / "rig.json").read_bytes()
    assert calibrated(calibrated_bench, folder / "views", "--json") == 0
    again = json.loads(capsys.readouterr().out)
    assert cameras_in(folder / "cameras.json").cameras == first.cameras
    assert (folder / "rig.json").read_bytes() == before
    assert again["verdict"] == "good"
    assert again["cameras"]["cameras"][0]["intrinsics"] == [list(row) for row in first.cameras[0].intrinsics]
    assert again["moved"] == [
        {"camera": "right", "shift_mm": pytest.approx(2), "turn_deg": pytest.approx(0, abs=1e-5)}
    ]


def test_a_refusal_leaves_everything_as_it_was(calibrated_bench, few, capsys):
    folder = calibrated_bench.parent / "calibration"
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    assert calibrated(calibrated_bench, few) == 3
    told = capsys.readouterr().err
    assert "camera left sees the board in 2 views that differ; at least 3 are needed" in told
    assert "nothing was changed" in told
    assert f"the views of an attempt that came to nothing are in {folder / 'views.refused'}" in told
    assert {file: file.read_bytes() for file in before} == before
    # they can be added to and tried again: they are not lost while they are read
    assert calibrated(calibrated_bench, folder / "views.refused") == 3
    assert len(list((folder / "views.refused").iterdir())) == 4


def test_pictures_without_a_board_are_refused_with_the_reason(bench, tmp_path, shots, capsys):
    folder = tmp_path / "none"
    folder.mkdir()
    for camera in ("left", "right"):
        shutil.copy(shots / f"12_{camera}.jpg", folder)
    assert calibrated(bench, folder) == 3
    assert "no marker of DICT_4X4_50 is in sight" in capsys.readouterr().err


def test_every_camera_needs_pictures(bench, shots, capsys):
    words = ["calibrate", "cameras", "--config", str(bench), "--images", f"left={shots}/*_left.jpg"]
    assert main(words) == 2
    assert "camera right: no pictures are given" in capsys.readouterr().err
    assert calibrated(bench, shots, "--views", "0") == 2


def test_an_interrupt_goes_on_with_the_views_that_there_are_and_needs_no_pictures(
    bench, shots, capsys, monkeypatch
):
    def without_matplotlib(bench):
        raise NodalError("pictures need matplotlib")

    monkeypatch.setattr(ending, "write_report", without_matplotlib)
    stopped_after(monkeypatch, 8, KeyboardInterrupt)
    assert calibrated(bench, shots) == 0
    told = capsys.readouterr()
    assert "going on with the views that there are" in told.err
    assert "report:  not written: pictures need matplotlib" in told.out
    assert cameras_in(bench.parent / "calibration" / "cameras.json").views_used == 8


def stopped_after(monkeypatch, count, error):
    """Looking raises this once so many views are taken."""

    def stops(self, frame_set):
        if len(self.views) == count:
            raise error
        return LOOK(self, frame_set)

    monkeypatch.setattr(Taking, "look", stops)


def test_a_camera_that_falls_silent_ends_the_taking_like_an_interrupt(bench, shots, capsys, monkeypatch):
    stopped_after(monkeypatch, 8, CameraSilentError("no frame from camera right for 20.01 s"))
    assert calibrated(bench, shots) == 0
    assert "no frame from camera right for 20.01 s: going on with the views" in capsys.readouterr().err
    assert cameras_in(bench.parent / "calibration" / "cameras.json").views_used == 8
    stopped_after(monkeypatch, 0, CameraSilentError("no frame from camera right for 20.01 s"))
    assert calibrated(bench, shots) == 2


def test_views_outlive_whatever_ends_an_attempt(bench, few, capsys, monkeypatch):
    folder = bench.parent / "calibration"
    cut_off = folder / "views.new"
    shutil.copytree(few, cut_off)  # of a command that was killed
    stopped_after(monkeypatch, 0, RuntimeError)
    with pytest.raises(RuntimeError):
        calibrated(bench, few)
    assert len(list((folder / "views.refused").iterdir())) == 4
    stopped_after(monkeypatch, 1, RuntimeError)
    with pytest.raises(RuntimeError):
        calibrated(bench, few)
    assert sorted(file.name for file in (folder / "views.refused").iterdir()) == [
        "00_left.jpg",
        "00_right.jpg",
    ]
    assert len(list((folder / "views.refused~").iterdir())) == 4
    # an attempt without a view takes the place of none with some
    stopped_after(monkeypatch, 0, RuntimeError)
    with pytest.raises(RuntimeError):
        calibrated(bench, few)
    assert len(list((folder / "views.refused").iterdir())) == 2
    assert not cut_off.exists()


def test_a_damaged_calibration_file_is_noticed_before_anybody_holds_a_board(bench, few, capsys, monkeypatch):
    folder = bench.parent / "calibration"
    folder.mkdir()
    (folder / "rig.json").write_text("{")
    stopped_after(monkeypatch, 0, AssertionError)
    assert calibrated(bench, few) == 2
    assert "rig.json: not a calibration file" in capsys.readouterr().err


def test_views_of_the_middle_alone_are_not_called_good(bench, shots_of_the_middle, capsys):
    assert calibrated(bench, shots_of_the_middle) == 0
    printed = capsys.readouterr().out
    assert "verdict: poor" in printed
    assert "missing: left: nothing in the upper left of the picture" in printed
    cameras = cameras_in(bench.parent / "calibration" / "cameras.json")
    assert cameras.cameras[0].empty_ninths == 8
    assert "left: nothing in the lower right of the picture" in cameras.missing
    page = (bench.parent / "calibration" / "report.html").read_text()
    assert "left: nothing in the lower right of the picture" in page


def test_poor_cameras_do_not_take_the_place_of_better_ones(bench, shots, shots_of_the_middle, capsys):
    assert calibrated(bench, shots) == 0
    file = bench.parent / "calibration" / "cameras.json"
    better = file.read_bytes()
    assert overall(judgements(cameras_in(file))) is not Grade.POOR

    assert calibrated(bench, shots_of_the_middle) == REFUSED

    assert "are better and stay" in capsys.readouterr().err
    assert file.read_bytes() == better


def as_webcams(bench, width, height):
    """The bench with webcams that are asked for pictures of this size."""
    table = read_table(bench)
    table["cameras"] = {
        name: {
            "source": "v4l2",
            "device": f"/dev/v4l/by-path/{name}",
            "width_px": width,
            "height_px": height,
            "rate_hz": RATE_HZ,
        }
        for name in table["cameras"]
    }
    table.pop("simulation", None)
    bench.write_text(written(table), encoding="utf-8")


def test_pictures_of_another_size_than_the_bench_asks_for_are_refused(bench, few, capsys):
    as_webcams(bench, 1920, 1080)
    assert calibrated(bench, few) == 3
    told = capsys.readouterr().err
    assert "camera left: its pictures are 960 x 540 px, but the bench asks it for 1920 x 1080" in told
    as_webcams(bench, 960, 540)
    assert calibrated(bench, few) == 3
    assert "sees the board in 2 views" in capsys.readouterr().err


def test_a_bench_whose_rooms_do_not_agree_is_refused_at_once(bench, few, capsys):
    as_webcams(bench, 960, 540)
    edit_bench_file(bench, {"cameras": {"left": {"device": "/dev/v4l/by-path/right"}}})
    assert calibrated(bench, few) == 2
    assert "have the same device" in capsys.readouterr().err


def test_cameras_that_run_freely_see_a_board_that_stands_still(bench):
    simulated = read_bench(bench).settings
    assert still_skew_s(simulated) == simulated.sensing.maximum_skew_s
    as_webcams(bench, 960, 540)
    assert 1 / 30 < still_skew_s(read_bench(bench).settings) < 1 / 28
    edit_bench_file(bench, {"sensing": {"maximum_skew_s": 0.05}})
    assert still_skew_s(read_bench(bench).settings) == 0.05


class LiveCamera:
    """Gives these pictures, each of them eight times, a period apart; then it ends, or, without any, is silent."""

    def __init__(self, name, files, phase_s):
        self.name, self._number, self._resting = name, 0, False
        self._jpegs = [jpeg for file in files for jpeg in [file.read_bytes()] * 8]
        self._phase_s = phase_s

    @property
    def ended(self):
        return 0 < len(self._jpegs) == self._number

    def read(self):
        self._resting = not self._resting
        if self._resting or self._number == len(self._jpegs):
            return None
        self._number += 1
        return CameraFrame(
            name=self.name,
            jpeg=self._jpegs[self._number - 1],
            capture_monotonic_ns=round((self._number / RATE_HZ + self._phase_s) * 1e9),
            number=self._number,
        )

    def close(self):
        pass


@pytest.fixture
def live(bench, monkeypatch):
    """`nodal calibrate cameras` on a bench with these webcams, and a person who presses Enter."""

    def run(*cameras):
        @contextlib.contextmanager
        def running(*_):
            yield list(cameras), None

        as_webcams(bench, 960, 540)
        monkeypatch.setattr(calibrating, "running_cameras", running)
        monkeypatch.setattr("sys.stdin", io.StringIO("\n"))
        return main(["calibrate", "cameras", "--config", str(bench)])

    return run


def test_cameras_half_a_period_out_of_step_see_a_board_that_stands_still(live, few, capsys):
    right = LiveCamera("right", sorted(few.glob("*_right.jpg")), phase_s=0.5 / RATE_HZ)
    assert live(LiveCamera("left", sorted(few.glob("*_left.jpg")), phase_s=0.0), right) == 3
    told = capsys.readouterr().err
    assert "2 views are taken; calibrating" in told
    assert "camera left sees the board in 2 views that differ" in told


def test_a_camera_that_gives_nothing_is_named_while_others_wait_for_it(live, few, capsys, monkeypatch):
    monkeypatch.setattr(calibrating, "PATIENCE_S", 0.0)
    monkeypatch.setattr(calibrating, "SILENCE_S", 0.2)
    left = LiveCamera("left", sorted(few.glob("*_left.jpg")), phase_s=0.0)
    assert live(left, LiveCamera("right", [], phase_s=0.0)) == 2
    told = capsys.readouterr().err
    assert "0 views | no picture comes from camera" in told
    assert "no frame from camera right" in told


def test_a_simulated_bench_holds_the_board_itself(light_bench, tmp_path, zenoh_settings, capsys):
    shutil.copytree(light_bench.parent, tmp_path, dirs_exist_ok=True)
    table = read_table(light_bench) | {"zenoh": {"rendezvous": zenoh_settings.rendezvous}}
    bench = tmp_path / "bench.toml"
    bench.write_text(written(table), encoding="utf-8")
    assert main(["calibrate", "cameras", "--config", str(bench), "--views", "6", "--json"]) == 0
    cameras = cameras_in(tmp_path / "cameras.json")
    assert json.loads(capsys.readouterr().out)["cameras"]["views_used"] == 6
    for camera, true in zip(cameras.cameras, load_rig(tmp_path / "rig.json"), strict=True):
        assert np.array(camera.intrinsics) == pytest.approx(true.intrinsics, abs=2.0)
