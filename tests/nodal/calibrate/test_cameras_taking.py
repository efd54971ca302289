"""Views out of a stream: only what stands still, looked at now and then, and shown while it goes on."""

import io

import pytest
from rich.console import Console

from calibration.board import Board
from drivers.cameras import CameraFrame, FrameSet
from messaging.board import BoardSettings
from nodal.calibrate.cameras.kept_views import NewViews
from nodal.calibrate.cameras.progress import COLUMNS, ROWS, blocks, drawn, in_one_line
from nodal.calibrate.cameras.taking import Taking, newest


@pytest.fixture
def taking(tmp_path):
    return Taking(Board(BoardSettings()), ("left", "right"), NewViews(tmp_path), one_by_one=False)


def frames(jpegs, at_s):
    return FrameSet(
        frames=tuple(
            CameraFrame(name=name, jpeg=jpeg, capture_monotonic_ns=round(at_s * 1e9), number=7)
            for name, jpeg in jpegs.items()
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


def test_of_the_sets_that_wait_the_newest_is_looked_at():
    sets = [frames({}, 0), frames({}, 0), None, None, frames({}, 0), None]
    assert list(newest(sets)) == [sets[1], None, sets[4]]
