"""A board before two cameras without distortion, in pictures of 960 x 540 px."""

import contextlib
import io
import itertools
import shutil

import cv2
import numpy as np
import pytest

from calibration.charuco import charuco_board
from messaging.board import BoardSettings
from nodal.__main__ import main
from nodal.bench_file import bench_path
from nodal.toml_file import read_table, written

WIDTH, HEIGHT, FOCAL_PX = 960, 540, 720.0
APART_DEG, AWAY_MM = 50.0, 200.0
FINER, BOARD_PX_PER_MM, PAPER_MM = 2, 8, 6
K = np.array([[FOCAL_PX, 0, 480.0], [0, FOCAL_PX, 270.0], [0, 0, 1]])


def turned(x_deg=0.0, y_deg=0.0, z_deg=0.0, place_mm=(0, 0, 0)):
    """(4, 4) turned about z, then y, then x."""
    pose = np.eye(4)
    for axis, angle in zip(np.eye(3), (x_deg, y_deg, z_deg), strict=True):
        pose[:3, :3] = pose[:3, :3] @ cv2.Rodrigues(axis * np.radians(angle))[0]
    pose[:3, 3] = place_mm
    return pose


AHEAD = turned(place_mm=(0, 0, AWAY_MM))
CAMERA_FROM_RIG = {"left": np.eye(4), "right": AHEAD @ turned(y_deg=APART_DEG) @ np.linalg.inv(AHEAD)}


def printed():
    """The board with white around it, and (3, 3) from mm on the board to its pixels."""
    size_px = [side * 10 * BOARD_PX_PER_MM for side in BoardSettings().squares]
    board = charuco_board(BoardSettings()).generateImage(size_px)
    white = PAPER_MM * BOARD_PX_PER_MM
    paper = cv2.copyMakeBorder(board, *[white] * 4, cv2.BORDER_CONSTANT, value=255)
    return paper, np.array([[BOARD_PX_PER_MM, 0, white - 0.5], [0, BOARD_PX_PER_MM, white - 0.5], [0, 0, 1]])


def picture(rig_from_board, camera, seed=0):
    """JPEG bytes of what the camera sees of a board there."""
    paper, paper_from_board = printed()
    pose = CAMERA_FROM_RIG[camera] @ rig_from_board
    finer = np.array([[FINER, 0, (FINER - 1) / 2], [0, FINER, (FINER - 1) / 2], [0, 0, 1]])
    seen_from_paper = finer @ K @ pose[:3, [0, 1, 3]] @ np.linalg.inv(paper_from_board)
    fine = cv2.warpPerspective(paper, seen_from_paper, (FINER * WIDTH, FINER * HEIGHT), borderValue=90)
    grey = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    noisy = grey * 0.8 + 20 + np.random.default_rng(seed).normal(0, 1.5, grey.shape)
    return cv2.imencode(".jpg", np.clip(noisy, 0, 255).astype(np.uint8))[1].tobytes()


def board_at(x_deg, y_deg, z_deg, place_mm):
    """`rig_from_board` (4, 4) of a board whose middle is `place_mm` from where both cameras look, facing between them."""
    to_middle = turned(place_mm=(-45, -35, 0))
    return (
        AHEAD
        @ turned(place_mm=place_mm)
        @ turned(y_deg=-APART_DEG / 2)
        @ turned(x_deg, y_deg, z_deg)
        @ to_middle
    )


def boards(count, seed=3):
    """Tilted every way, all over the pictures, by turns in each of their quarters."""
    random = np.random.default_rng(seed)
    for _, quarter in zip(range(count), itertools.cycle(((-1, -1), (1, -1), (-1, 1), (1, 1))), strict=False):
        x_deg, y_deg = random.uniform(-32, 32, 2)
        across, down = quarter * random.uniform((15, 10), (50, 32))
        yield board_at(x_deg, y_deg, random.uniform(-40, 40), (across, down, random.uniform(-35, 35)))


@pytest.fixture(scope="session")
def shots(tmp_path_factory):
    """A folder of NN_left.jpg and NN_right.jpg: twelve views of the board and, as view 12, one without it."""
    folder = tmp_path_factory.mktemp("shots")
    for number, rig_from_board in enumerate(boards(12)):
        for camera in CAMERA_FROM_RIG:
            (folder / f"{number:02d}_{camera}.jpg").write_bytes(picture(rig_from_board, camera, seed=number))
    away = turned(place_mm=(1e4, 0, 500))
    for camera in CAMERA_FROM_RIG:
        (folder / f"12_{camera}.jpg").write_bytes(picture(away, camera))
    return folder


@pytest.fixture
def shots_of_the_middle(tmp_path):
    """Twelve views of the board, tilted well, that all lie in the middle ninth of the pictures."""
    folder = tmp_path / "middle"
    folder.mkdir()
    tilts = itertools.product((-30, -10, 10, 30), (-30, 0, 30))
    for number, (x_deg, y_deg) in enumerate(tilts):
        rig_from_board = board_at(x_deg, y_deg, x_deg, (0, 0, 170 - 2 * x_deg))
        for camera in CAMERA_FROM_RIG:
            jpeg = picture(rig_from_board, camera, seed=number)
            (folder / f"{number:02d}_{camera}.jpg").write_bytes(jpeg)
    return folder


def images(folder):
    """The words that stand for these pictures."""
    return ["--images", *(f"{camera}={folder}/*_{camera}.jpg" for camera in CAMERA_FROM_RIG)]


def write_bench(folder):
    """A bench file without a calibration."""
    table = read_table(bench_path("simulated"))
    table["calibration"] = "calibration/rig.json"
    (folder / "bench.toml").write_text(written(table), encoding="utf-8")
    return folder / "bench.toml"


@pytest.fixture
def bench(tmp_path):
    """A bench that was never calibrated."""
    return write_bench(tmp_path)


@pytest.fixture(scope="session")
def make_bench():
    """Writes the file of such a bench into a folder."""
    return write_bench


@pytest.fixture(scope="session")
def first_calibration(tmp_path_factory, shots):
    """The bench file of a bench whose cameras were calibrated with `shots`, and what was printed."""
    bench = write_bench(tmp_path_factory.mktemp("calibrated"))
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["calibrate", "cameras", "--config", str(bench), *images(shots)]) == 0
    return bench, printed.getvalue()


@pytest.fixture
def calibrated_bench(tmp_path, first_calibration):
    """A copy of that bench."""
    shutil.copytree(first_calibration[0].parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / "bench.toml"


@pytest.fixture(scope="session")
def places():
    """JPEG bytes by camera of a board at two places."""
    poses = {"here": board_at(20, 10, 0, (0, 0, 0)), "elsewhere": board_at(-20, 10, 15, (15, -10, 10))}
    return {name: seen(rig_from_board) for name, rig_from_board in poses.items()}


@pytest.fixture(scope="session")
def drifting():
    """JPEG bytes by camera of a board, and of the same one 3 px beside."""
    return [seen(board_at(20, 10, 0, (0, away_mm, 0))) for away_mm in (0, 3 * AWAY_MM / FOCAL_PX)]


def seen(rig_from_board):
    """JPEG bytes by camera."""
    return {camera: picture(rig_from_board, camera) for camera in CAMERA_FROM_RIG}
