"""Views out of a stream: only what stands still, looked at now and then, and shown while it goes on."""

import io

import pytest
from rich.console import Console

from calibration.board import Board
from drivers.cameras import CameraFrame, FrameSet
from messaging.board import BoardSettings
from nodal.calibrate.cameras.kept_views import VIEWS, NewViews, kept_pictures
from nodal.calibrate.cameras.progress import COLUMNS, ROWS, TakingProgress, blocks, drawn, in_one_line
from nodal.calibrate.cameras.taking import Taking, newest
from nodal.calibrate.cameras.waiting import PATIENCE_S, HeardCamera, why_no_set


@pytest.fixture
def taking(tmp_path):
    return Taking(Board(BoardSettings()), ("left", "right"), NewViews(tmp_path), one_by_one=False)


def frames(jpegs, at_s, skew_s=0.0):
    return FrameSet(
        frames=tuple(
            CameraFrame(
                name=name, jpeg=jpeg, capture_monotonic_ns=round((at_s + number * skew_s) * 1e9), number=7
            )
            for number, (name, jpeg) in enumerate(jpegs.items())
        )
    )


def test_a_board_is_taken_once_it_stands_still(taking, places, tmp_path):
    here, elsewhere = places["here"], places["elsewhere"]
    assert taking.look(frames(here, 0.0))
    assert taking.verdict.reason == "hold the board still"
    assert not taking.look(frames(here, 0.1))  # too soon to be seen moving
    assert taking.look(frames(here, 0.2))
    assert taking.verdict.taken
    assert taking.look(frames(elsewhere, 0.4))
    assert taking.verdict.reason == "hold the board still"
    assert taking.look(frames(elsewhere, 0.6))
    assert [view.name for view in taking.views] == ["01", "02"]
    assert taking.look(frames(elsewhere, 0.8))
    assert "shows the same as view 02" in taking.verdict.reason
    assert taking.refused["hold the board still"] == 2
    assert sorted(file.name for file in (tmp_path / "views.new").iterdir()) == [
        "01_left.jpg",
        "01_right.jpg",
        "02_left.jpg",
        "02_right.jpg",
    ]


def test_how_still_a_board_must_be_follows_from_how_far_out_of_step_the_cameras_are(taking, drifting):
    """A hand's tremor: 15 px/s in these pictures."""
    before, after = drifting
    taking.look(frames(before, 0.0))
    assert taking.look(frames(after, 0.2, skew_s=0.016))
    assert taking.verdict.reason == "hold the board still"
    taking.look(frames(before, 0.4, skew_s=0.016))
    assert taking.look(frames(after, 0.6, skew_s=0.002))
    assert taking.verdict.taken


def test_a_camera_whose_pictures_cannot_be_read_is_named(taking, places):
    assert taking.look(frames(places["here"] | {"right": b"no picture"}, 0.0))
    assert taking.verdict.reason == "no picture of camera right"
    assert not taking.views


def test_what_is_shown_meanwhile(taking, places):
    taking.look(frames(places["here"], 0.0))
    taking.look(frames(places["here"], 0.2))
    assert in_one_line(taking).startswith("1 views | view 01 taken: ")
    console = Console(width=120, file=io.StringIO())
    console.print(drawn(taking))
    text = console.file.getvalue()
    assert "1 taken" in text
    assert taking.missing[0] in text
    rows = blocks(taking.views, "left", taking.sizes["left"])
    assert [len(row) for row in rows] == [2 * COLUMNS] * ROWS
    assert rows[0].strip() == ""
    assert rows[ROWS // 2][COLUMNS] != " "
    assert all(row in text for row in rows)


class SomeCamera:
    """Gives a frame each time it is told to."""

    def __init__(self, name):
        self.name, self.ended, self.waiting = name, False, 0

    def read(self):
        if not self.waiting:
            return None
        self.waiting -= 1
        return CameraFrame(name=self.name, jpeg=b"", capture_monotonic_ns=0, number=0)

    def close(self):
        pass


def test_why_no_pictures_come_that_belong_together():
    left, right = some = [SomeCamera("left"), SomeCamera("right")]
    cameras = [HeardCamera(camera) for camera in some]
    left.waiting = 1
    assert [camera.read() is None for camera in cameras] == [False, True]
    now_s = cameras[0].heard_s
    assert why_no_set(cameras, 0.017, now_s) == "no picture comes from camera right"
    right.waiting = 1
    assert cameras[1].read() is not None
    assert "from all cameras, but are taken more than 17 ms apart" in why_no_set(cameras, 0.017, now_s)
    later_s = cameras[1].heard_s + PATIENCE_S + 0.1
    assert why_no_set(cameras, 0.017, later_s) == "no picture comes from camera left and right"
    left.ended = True
    assert why_no_set(cameras, 0.017, later_s) == "no picture comes from camera right"


def test_whoever_waits_is_told_why_once_in_a_while(taking, capsys):
    progress = TakingProgress()
    for _ in range(50):
        progress.show(taking, "no picture comes from camera right")
    told = capsys.readouterr().err
    assert told == "0 views | no picture comes from camera right | next: the board, before all cameras\n"
    console = Console(width=120, file=io.StringIO())
    console.print(drawn(taking, "no picture comes from camera right"))
    assert "no picture comes from camera right" in console.file.getvalue()


def test_pictures_of_cameras_whose_names_end_alike_are_told_apart(tmp_path):
    (tmp_path / VIEWS).mkdir()
    for name in ("01_left", "01_top_left", "02_top_left", "02_other"):
        (tmp_path / VIEWS / f"{name}.jpg").touch()
    found = kept_pictures(tmp_path, ("left", "top_left"))
    assert {view: [file.name for file in files.values()] for view, files in found.items()} == {
        "01": ["01_left.jpg", "01_top_left.jpg"],
        "02": ["02_top_left.jpg"],
    }


def test_of_the_sets_that_wait_the_newest_is_looked_at():
    sets = [frames({}, 0), frames({}, 0), None, None, frames({}, 0), None]
    assert list(newest(sets)) == [sets[1], None, sets[4]]
