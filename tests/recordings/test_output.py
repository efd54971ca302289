"""The file below a recording: one writer, whole records, clear errors."""

import fcntl

import pytest

from recordings.errors import (
    DiskFullError,
    RecordingExistsError,
    RecordingInUseError,
    UnreadableError,
    UnwritableError,
)
from recordings.output import Output, in_use


def test_what_was_written_is_there_at_once(tmp_path):
    with Output(tmp_path / "a") as output:
        output.write(b"one")
        output.write(b"two")
        assert (tmp_path / "a").read_bytes() == b"onetwo"
        assert output.tell() == 6
        output.sync()


def test_a_second_writer_is_refused_while_the_first_writes(tmp_path):
    with (
        Output(tmp_path / "a"),
        pytest.raises(RecordingInUseError, match=r"/a: another recorder is writing it"),
    ):
        Output(tmp_path / "a")


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "a").write_bytes(b"kept")
    with pytest.raises(RecordingExistsError, match="never overwritten"):
        Output(tmp_path / "a")
    assert (tmp_path / "a").read_bytes() == b"kept"


def test_the_lock_ends_with_the_writer(tmp_path):
    with Output(tmp_path / "a"):
        assert in_use(tmp_path / "a")
    assert not in_use(tmp_path / "a")


def test_readers_do_not_look_like_writers(tmp_path):
    (tmp_path / "a").touch()
    with (tmp_path / "a").open() as reader:
        fcntl.flock(reader, fcntl.LOCK_SH)
        assert not in_use(tmp_path / "a")


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(UnwritableError, match=r"the folder .*/nowhere does not exist"):
        Output(tmp_path / "nowhere" / "a")


def test_a_read_only_folder_is_named(read_only_folder):
    with pytest.raises(UnwritableError, match=r"read-only/a: it cannot be written: Permission denied"):
        Output(read_only_folder / "a")


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UnwritableError, match="Not a directory"):
        Output(tmp_path / "file" / "a")


def test_a_missing_file_is_in_nobodys_use(tmp_path):
    with pytest.raises(UnreadableError, match="No such file"):
        in_use(tmp_path / "a")


def test_a_write_that_does_not_fit_leaves_nothing_behind(tmp_path, small_disk):
    with Output(tmp_path / "a") as output, small_disk(100):
        output.write(b"x" * 60)
        with pytest.raises(DiskFullError, match=r"no room is left .* after 60 bytes"):
            output.write(b"y" * 60)
        assert (tmp_path / "a").read_bytes() == b"x" * 60
        output.write(b"z" * 40)
        assert output.tell() == 100
