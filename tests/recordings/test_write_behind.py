"""Whoever writes never waits for the disk, and hears of what went wrong there."""

import os
import threading

import pytest

from recordings.errors import DeletedError, DiskFullError
from recordings.output import Output, in_use
from recordings.write_behind import WriteBehind


@pytest.fixture
def stalled(monkeypatch):
    """A disk that does nothing until the event is set; how often it was asked to sync."""
    free = threading.Event()
    pwrite, fdatasync = os.pwrite, os.fdatasync
    free.syncs = 0

    def slow_pwrite(*arguments):
        free.wait(30)
        return pwrite(*arguments)

    def slow_fdatasync(file):
        free.syncs += 1
        free.wait(30)
        fdatasync(file)

    monkeypatch.setattr(os, "pwrite", slow_pwrite)
    monkeypatch.setattr(os, "fdatasync", slow_fdatasync)
    yield free
    free.set()


def test_what_a_stalled_disk_does_not_take_waits(tmp_path, stalled):
    behind = WriteBehind(Output(tmp_path / "a"))
    for number in range(100):
        behind.write(b"%03d" % number)
        behind.sync()
    assert (behind.tell(), behind.written_bytes, behind.waiting_bytes) == (300, 0, 300)
    assert not behind.wait(0.01)
    stalled.set()
    behind.end()
    assert behind.wait(30)
    behind.check()
    assert (tmp_path / "a").read_bytes() == b"".join(b"%03d" % number for number in range(100))
    assert behind.waiting_bytes == 0
    assert not in_use(tmp_path / "a")


def test_syncs_do_not_pile_up(tmp_path, stalled):
    behind = WriteBehind(Output(tmp_path / "a"))
    for _ in range(100):
        behind.sync()
    stalled.set()
    behind.end()
    assert behind.wait(30)
    assert stalled.syncs <= 3


def test_a_failure_is_told_at_the_next_call_and_ends_the_file(tmp_path, small_disk, eventually):
    behind = WriteBehind(Output(tmp_path / "a"))
    with small_disk(100):
        behind.write(b"x" * 60)
        behind.write(b"y" * 60)
        assert behind.wait(30)
    for call in (behind.check, behind.sync, lambda: behind.write(b"z")):
        with pytest.raises(DiskFullError, match="after 60 bytes"):
            call()
    assert (tmp_path / "a").read_bytes() == b"x" * 60
    assert behind.waiting_bytes == 60
    assert not in_use(tmp_path / "a")


def test_a_deleted_file_is_noticed(tmp_path):
    behind = WriteBehind(Output(tmp_path / "a"))
    behind.write(b"x" * 60)
    (tmp_path / "a").unlink()
    behind.sync()
    assert behind.wait(30)
    with pytest.raises(DeletedError, match=r"/a: it was deleted after 60 bytes"):
        behind.check()
