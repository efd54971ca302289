"""`nodal calibrate board`: the page is read back from its file, as lengths and as a picture that a camera might take."""

import re
import shutil
import zlib
from xml.etree import ElementTree as ET

import cv2
import msgspec
import numpy as np
import pytest

from calibration.board import Board
from calibration.camera_set import CameraSet
from drivers.simulated.cameras.rig import default_cameras
from messaging.board import BoardSettings
from nodal.__main__ import main
from nodal.bench_file import SHIPPED, read_bench
from nodal.calibrate.board.drawing import draw_board
from nodal.calibrate.board.page import PAPERS_MM, board_page
from nodal.calibrate.board.pattern import black_rectangles_mm
from nodal.calibration.folder import CAMERAS, calibration_folder, save_json
from nodal.errors import CalibrationError

MM_PER_PT = 25.4 / 72
PX_PER_MM = 6
CORNER = re.compile(r"([ML]) (\S+) (\S+)")
PDF_CORNER = re.compile(rb"(\S+) (\S+) ([ml])\n")
BOARDS = (
    BoardSettings(),
    BoardSettings(
        squares=(5, 8), square_mm=20.0, marker_mm=15.0, dictionary="DICT_6X6_250", legacy_pattern=True
    ),
    BoardSettings(kind="chessboard", squares=(10, 7), square_mm=15.0),
)


def drawn(tmp_path, board, suffix):
    """The page, its size and the corners (N, 4, 2) of what is black, in mm from the top left."""
    page = board_page(board, "A4")
    file = tmp_path / f"board.{suffix}"
    draw_board(file, page, board)
    size_mm, corners_mm = (in_svg if suffix == "svg" else in_pdf)(file)
    return page, size_mm, corners_mm


def in_svg(file):
    root = ET.parse(file).getroot()
    size_mm = [float(root.get(key).removesuffix("pt")) * MM_PER_PT for key in ("width", "height")]
    path = root.find(".//*[@id='board']/{*}path").get("d")
    return size_mm, np.array([found[1:] for found in CORNER.findall(path)], float).reshape(
        -1, 4, 2
    ) * MM_PER_PT


def in_pdf(file):
    data = file.read_bytes()
    box = re.search(rb"/MediaBox \[ 0 0 (\S+) (\S+) \]", data)
    size_mm = [float(box[1]) * MM_PER_PT, float(box[2]) * MM_PER_PT]
    streams = map(inflated, re.findall(rb"stream\r?\n(.*?)\r?\nendstream", data, re.DOTALL))
    page = next(text for text in streams if text.startswith(b"/DeviceRGB"))
    _paper, board, _ruler = page.split(b"\nf\n", 2)
    corners = np.array([found[:2] for found in PDF_CORNER.findall(board)], float)
    corners_mm = corners.reshape(-1, 4, 2) * MM_PER_PT
    corners_mm[..., 1] = size_mm[1] - corners_mm[..., 1]
    return size_mm, corners_mm


def inflated(stream):
    try:
        return zlib.decompress(stream)
    except zlib.error:
        return b""


def as_picture(size_mm, corners_mm):
    """The page as pixels whose centres have integer coordinates, each as dark as the share of it that is black."""
    width, height = (round(side * PX_PER_MM) for side in size_mm)
    white = np.ones((height, width), np.float32)
    for corners in corners_mm * PX_PER_MM:
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        white[int(y0) : int(y1) + 1, int(x0) : int(x1) + 1] -= np.outer(covered(y0, y1), covered(x0, x1))
    return cv2.GaussianBlur(np.round(255 * white.clip(0, 1)).astype(np.uint8), None, 1.0)


def covered(low, high):
    """The share of each pixel from the one that holds `low` to the one that holds `high` that lies between both."""
    return np.diff(np.clip(np.arange(int(low), int(high) + 2), low, high))


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
@pytest.mark.parametrize("board", BOARDS, ids=lambda board: f"{board.kind}-{board.dictionary}")
def test_the_page_is_true_to_scale_and_a_camera_finds_the_board_on_it(tmp_path, board, suffix):
    page, size_mm, corners_mm = drawn(tmp_path, board, suffix)
    assert size_mm == pytest.approx(PAPERS_MM["A4"], abs=1e-4)
    low, high = corners_mm.min(axis=(0, 1)), corners_mm.max(axis=(0, 1))
    assert low == pytest.approx(page.board_corner_mm, abs=1e-4)
    assert high - low == pytest.approx(np.array(board.squares) * board.square_mm, abs=1e-4)
    found = Board(board).find(as_picture(size_mm, corners_mm))
    assert len(found) == (board.squares[0] - 1) * (board.squares[1] - 1)
    there_mm = (found.px + 0.5) / PX_PER_MM - page.board_corner_mm
    assert there_mm == pytest.approx(Board(board).points_mm[found.ids, :2], abs=0.01)


def test_the_ruler_is_as_long_as_it_says(tmp_path):
    page, _, _ = drawn(tmp_path, BoardSettings(), "svg")
    root = ET.parse(tmp_path / "board.svg").getroot()
    lines = [path.get("d") for path in root.findall(".//*[@id='ruler']/{*}path")]
    baseline, *ticks = [np.array([c[1:] for c in CORNER.findall(line)], float) * MM_PER_PT for line in lines]
    assert np.ptp(baseline[:, 0]) == pytest.approx(100, abs=1e-4)
    assert page.ruler_mm == 100
    assert [tick[0, 0] - baseline[0, 0] for tick in ticks] == pytest.approx(range(101), abs=1e-4)


def test_the_pattern_is_opencvs_own():
    board = BoardSettings()
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    theirs = cv2.aruco.CharucoBoard((9, 7), 60, 42, dictionary).generateImage((540, 420))
    ours = np.full((420, 540), 255, np.uint8)
    for x0, y0, x1, y1 in np.round(black_rectangles_mm(board) * 6).astype(int):
        ours[y0:y1, x0:x1] = 0
    assert np.array_equal(ours, theirs)


def test_a_board_that_does_not_fit_is_refused_with_what_would():
    with pytest.raises(CalibrationError, match=r"it fits A3; A4 takes squares of up to 9\.5 mm"):
        board_page(BoardSettings(squares=(20, 15), square_mm=15.0, marker_mm=11.0), "A4")
    board_page(BoardSettings(squares=(20, 15), square_mm=9.5, marker_mm=7.0), "A4")


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(SHIPPED / "simulated.toml", tmp_path / "bench.toml")
    return tmp_path / "bench.toml"


def test_what_was_measured_becomes_the_size_of_the_squares(bench, capsys):
    assert main(["calibrate", "board", "--config", str(bench), "--out", "board.pdf"]) == 0
    assert "ChArUco board, 9 x 7 squares of 10 mm" in capsys.readouterr().out
    for measured, square_mm in (
        ("97.3", 9.73),
        ("99.1", 9.91),
    ):  # the second time it was measured with more care
        assert main(["calibrate", "board", "--config", str(bench), "--measured", measured]) == 0
        assert read_bench(bench).settings.board.square_mm == pytest.approx(square_mm)
    assert read_bench(bench).settings.board.marker_mm == pytest.approx(6.937)
    assert "came out at 99.10 %" in capsys.readouterr().out


def test_what_was_calibrated_with_the_board_before_it_was_measured_is_named(bench, capsys):
    assert main(["calibrate", "board", "--config", str(bench), "--out", "board.pdf"]) == 0
    measured = ["calibrate", "board", "--config", str(bench), "--measured"]
    file = calibration_folder(read_bench(bench)) / CAMERAS
    cameras = msgspec.structs.replace(CameraSet.of_rig(default_cameras()), board=BoardSettings())
    save_json(file, cameras)
    assert main([*measured, "99.1"]) == 0
    printed = capsys.readouterr().out
    assert f"{file} was calibrated with squares of 10 mm" in printed
    assert "+0.91 % off until you run nodal calibrate cameras and nodal calibrate base again" in printed
    assert main([*measured, "100"]) == 0
    save_json(file, msgspec.structs.replace(cameras, board=BoardSettings(squares=(5, 7))))
    assert main([*measured, "99.1"]) == 0
    assert "was calibrated with" not in capsys.readouterr().out


def test_what_cannot_have_been_measured_is_refused(bench, capsys):
    assert main(["calibrate", "board", "--config", str(bench), "--measured", "99"]) == 3
    assert "draw one with --out first" in capsys.readouterr().err
    assert main(["calibrate", "board", "--config", str(bench), "--out", "board.svg"]) == 0
    assert main(["calibrate", "board", "--config", str(bench), "--measured", "9.9"]) == 2
    assert "allowed are 80 to 125 mm" in capsys.readouterr().err
    bench.write_text(bench.read_text() + "\n[board]\nsquares = [5, 7]\n")
    assert main(["calibrate", "board", "--config", str(bench), "--measured", "99"]) == 3
    assert "is another one than that of [board] now" in capsys.readouterr().err
