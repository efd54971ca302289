"""Files that calibration replaces: whole or not at all, with their modes and links as they were."""

import contextlib
import os
import resource
import stat

import msgspec
import pytest

from calibration.camera_set import CameraSet
from drivers.simulated.cameras.rig import default_cameras
from nodal.bench_editing import edit_bench_file
from nodal.calibration.folder import cameras_in, save_json
from nodal.calibration_file import load_rig, save_rig
from nodal.errors import BenchFileError, CalibrationFileError
from nodal.whole_file import write_whole


@contextlib.contextmanager
def full_disk(size=100):
    """No file can grow beyond so many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def bench(tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text('name = "mine"  # and nobody else\'s\n')
    return file


def test_a_full_disk_leaves_the_old_files_as_they_were(tmp_path, bench):
    rig = default_cameras()
    cameras = CameraSet.of_rig(rig)
    save_rig(tmp_path / "rig.json", rig)
    save_json(tmp_path / "cameras.json", cameras)
    with full_disk():
        with pytest.raises(CalibrationFileError, match=r"rig\.json: cannot be written"):
            save_rig(tmp_path / "rig.json", rig[:1])
        with pytest.raises(CalibrationFileError, match=r"cameras\.json: cannot be written"):
            save_json(tmp_path / "cameras.json", msgspec.structs.replace(cameras, made_at="today"))
        with pytest.raises(BenchFileError, match=r"bench\.toml: cannot be written"):
            edit_bench_file(bench, {"board": {"kind": "charuco", "dictionary": "D" * 100}})
    assert len(load_rig(tmp_path / "rig.json")) == len(rig)
    assert cameras_in(tmp_path / "cameras.json") == cameras
    assert bench.read_text() == 'name = "mine"  # and nobody else\'s\n'
    assert not list(tmp_path.glob("*.new"))


def test_a_link_stays_a_link_and_a_mode_a_mode(tmp_path, bench):
    bench.chmod(0o640)
    link = tmp_path / "link.toml"
    link.symlink_to(bench)
    edit_bench_file(link, {"board": {"square_mm": 9.5}})
    assert link.is_symlink()
    assert stat.S_IMODE(bench.stat().st_mode) == 0o640
    assert "square_mm = 9.5" in bench.read_text()
    assert "nobody else" in bench.read_text()
    assert "square_mm" not in (tmp_path / "link.toml~").read_text()


def test_a_file_that_was_not_there_is_made(tmp_path):
    write_whole(tmp_path / "new.json", b"{}")
    assert [file.name for file in tmp_path.iterdir()] == ["new.json"]


def test_a_pipe_stays_a_pipe(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b"{}")
    assert os.read(reader, 10) == b"{}"
    os.close(reader)
    assert pipe.is_fifo()


def test_what_no_bench_file_may_hold_is_not_written(bench):
    before = bench.read_bytes()
    with pytest.raises(BenchFileError, match=r"board\.square_mm = nan: it must be a finite number"):
        edit_bench_file(bench, {"board": {"square_mm": float("nan")}})
    assert bench.read_bytes() == before
