"""Verdicts on calibrated cameras, and the page that shows them."""

import re

import msgspec
import numpy as np
import pytest

from calibration.base import Base, BasesFound
from calibration.camera_set import BoardCheck
from controller.identified import Drawing, IdentifiedSettings
from nodal.__main__ import main
from nodal.calibrate.background.judging import CameraBackground
from nodal.calibrate.background.keeping import FILE, BackgroundFound
from nodal.calibrate.cameras.verdict import Grade, judgements, overall
from nodal.calibrate.cameras.words import places
from nodal.calibrate.robot.calibrating import ROBOT
from nodal.calibrate.robot.results import AxisFound, Foreseen, NodeForeseen, RobotFound
from nodal.calibration.folder import cameras_in
from nodal.calibration_file import save_rig

SECTIONS = ["cameras", "accuracy", "space", "coverage", "residuals", "distortion", "views"]


def sections_of(page):
    return re.findall(r'<section id="([a-z-]+)">', page)


@pytest.fixture
def cameras(first_calibration):
    return cameras_in(first_calibration[0].parent / "calibration" / "cameras.json")


def test_the_worst_figure_makes_the_verdict(cameras):
    assert overall(judgements(cameras)) is Grade.GOOD
    left, right = cameras.cameras
    blurred = msgspec.structs.replace(left, held_out_rms_px=0.3)
    assert overall(judgements(msgspec.structs.replace(cameras, cameras=(blurred, right)))) is Grade.FAIR
    bent = BoardCheck(squares=100, mean_error_mm=0.0, rms_error_mm=0.01, surface_error_mm=0.4)
    found = judgements(msgspec.structs.replace(cameras, board_check=bent))
    assert overall(found) is Grade.POOR
    assert [one.what for one in found if one.grade is not Grade.GOOD] == ["surface of the board, RMS error"]


def test_the_board_is_judged_by_whether_it_is_like_one_that_was_printed_and_glued(cameras):
    for shape, not_good in (
        ({"bend_x_mm": 0.4, "stretch": -0.004}, []),
        ({"bend_x_mm": 3.0, "stretch": 0.001}, ["bow of the board"]),
        ({"bend_x_mm": 0.0, "stretch": -0.02}, ["stretch of the board, down over across"]),
    ):
        known = msgspec.structs.replace(cameras, board_shape=shape)
        assert [one.what for one in judgements(known) if one.grade is Grade.POOR] == not_good
        told = next(line for line in places(known) if line.startswith("the board itself"))
        assert (
            f"bowed by {shape['bend_x_mm'] * 48 / 49:.3f} mm, {1000 * shape['stretch']:+.2f} ‰ longer" in told
        )


def test_nothing_is_said_of_scale_which_cameras_cannot_know(cameras):
    assert not [one.what for one in judgements(cameras) if "scale" in one.what]


def test_the_report_is_one_file_with_all_there_is(first_calibration, tmp_path, capsys):
    bench, _ = first_calibration
    assert main(["calibration", "report", "--config", str(bench), "--out", str(tmp_path / "page.html")]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert sections_of(page) == SECTIONS
    assert set(re.findall(r'(?:src|href)="(?!#|data:)([^"]*)"', page)) == set()
    assert page.index("Nothing speaks against these cameras.") < page.index('<section id="cameras">')
    assert re.search(r"camera left: \d+ corners of 12 views, residuals 100+ times as long", page)
    assert "left: no marker of DICT_4X4_50 is in sight" in page
    assert page.count("data:image/jpeg") >= 2 + 2 * 6


def test_cameras_of_somebody_else_have_a_report_of_what_is_known(calibrated_bench, cameras, capsys):
    folder = calibrated_bench.parent / "calibration"
    save_rig(folder / "rig.json", cameras.in_robot_frame(np.eye(4)))
    (folder / "cameras.json").unlink()
    (folder / "views" / "views.json").unlink()
    for file in (folder / "views").iterdir():
        file.unlink()
    assert main(["calibration", "report", "--config", str(calibrated_bench)]) == 0
    page = (folder / "report.html").read_text()
    assert sections_of(page) == ["cameras", "accuracy", "space", "distortion"]
    assert "in the robot frame" in page


def test_the_robot_frame_is_shown_as_long_as_it_is_of_these_cameras(calibrated_bench, cameras):
    folder, page = calibrated_bench.parent / "calibration", calibrated_bench.parent / "page.html"
    base = Base(
        way="board",
        rig_from_robot=np.eye(4).tolist(),
        covariance=(np.eye(6) * 1e-4).tolist(),
        residual_px={"left": 0.03, "right": 0.04},
        residual_mm=0.01,
        frame_sets=12,
        cameras_made_at=cameras.made_at,
    )
    found = BasesFound(used="board", board=base, robot=msgspec.structs.replace(base, way="robot"))
    report = ["calibration", "report", "--config", str(calibrated_bench), "--out", str(page)]
    (folder / "base.json").write_bytes(msgspec.json.encode(found))
    (folder / "base-left.jpg").write_bytes((folder / "views" / "00_left.jpg").read_bytes())
    assert main(report) == 0
    assert "left 0.030\u202fpx, right 0.040\u202fpx; 0.010\u202fmm" in page.read_text()
    assert "board and robot apart" in page.read_text()
    stale = msgspec.structs.replace(base, cameras_made_at="some other day")
    (folder / "base.json").write_bytes(msgspec.json.encode(BasesFound(used="board", board=stale)))
    assert main(report) == 0
    assert "it must be found again" in page.read_text()


def test_what_later_steps_found_is_shown(calibrated_bench):
    folder, page = calibrated_bench.parent / "calibration", calibrated_bench.parent / "page.html"
    axis = AxisFound(
        axis=1,
        section=1,
        name="proximal x",
        gain=0.913,
        gain_sigma=0.012,
        bends_others=(1.0, 0.1),
        bends_others_drawn=(1.0, 0.0),
        lost_motion_mm=0.31,
        lost_motion_sigma_mm=0.02,
        current_at_rest_ma=40.0,
        current_between_ways_ma=None,
    )
    identified = IdentifiedSettings(
        date="today",
        drawing=Drawing(section_length_mm=(), angle_deg=(), pitch_radius_mm=(), coupling=1.0, mm_per_rad=()),
        gain=((0.0,),),
        gain_sigma=((0.1,),),
        bias_rad=(0.0,),
        bias_sigma_rad=(0.1,),
        lost_motion_mm=(0.3,),
        lost_motion_sigma_mm=(0.1,),
    )
    tip = NodeForeseen(name="tip", arc_mm=80.0, before_mm=6.5, after_mm=0.7)
    robot = RobotFound(
        date="today",
        seconds=60.0,
        length_mm=80.0,
        poses=30,
        refused=0,
        reversed=("distal y",),
        axes=(axis,),
        fit_rms_mm=0.4,
        held_out=Foreseen(poses=6, before_mm=5.0, after_mm=0.6, nodes=(tip,)),
        identified=identified,
        doubt="the stage stands still",
    )
    seen = CameraBackground(
        camera="left",
        pictures=30,
        level=(60.0, 141.0, 78.0),
        noise=(1.0, 1.0, 1.0),
        tile_noise=0.6,
        noisiest=1.0,
        noisiest_px=(1, 1),
        flicker=0.001,
        unevenness=0.18,
        clipped_share=0.0,
        spots=(),
        ends_in_reach=False,
        work_area=None,
    )
    scene = BackgroundFound(made_at="today", insertion_mm=3.0, insertion_known=True, cameras=(seen,))
    (folder / ROBOT).write_bytes(msgspec.json.encode(robot))
    (folder / FILE).write_bytes(msgspec.json.encode(scene))
    assert main(["calibration", "report", "--config", str(calibrated_bench), "--out", str(page)]) == 0
    text = page.read_text()
    assert "Signs that were corrected: distal y." in text
    assert "Not written into the bench file: the stage stands still." in text
    assert "0.913 ± 0.012" in text
    assert "0.700\u202fmm" in text
    assert "with the stage at 3.0 mm" in text
    assert "60, 141, 78" in text
    (folder / ROBOT).write_text("{}")
    assert main(["calibration", "report", "--config", str(calibrated_bench)]) == 2


def test_without_cameras_there_is_no_report(bench, capsys):
    assert main(["calibration", "report", "--config", str(bench)]) == 2
    assert "begin with `nodal calibrate cameras`" in capsys.readouterr().err
