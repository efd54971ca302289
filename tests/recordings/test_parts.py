"""A recording that was cut off goes on beside itself."""

from pathlib import Path

import pytest

from recordings.errors import RecordingExistsError, RecordingInUseError
from recordings.parts import new_path, next_number, part_path, parts
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter


def next_part(path):
    return part_path(path, next_number(path))


def write(path):
    return RecordingWriter(path, RecorderSettings())


def test_names_sort_by_time_and_are_utc():
    assert new_path(Path("runs"), 1_777_726_645_987_654_321) == Path("runs/2026-05-02T12-57-25Z.mcap")


def test_the_first_part_has_the_name_itself(tmp_path):
    path = tmp_path / "circle.mcap"
    assert (parts(path), next_part(path)) == ([], path)


def test_a_recording_that_was_cut_off_goes_on_in_its_next_part(tmp_path):
    path = tmp_path / "circle.mcap"
    with write(path):
        pass
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    assert next_part(path) == tmp_path / "circle.part2.mcap"
    next_part(path).write_bytes(whole[:50])
    assert next_part(path) == tmp_path / "circle.part3.mcap"
    assert parts(path) == [path, tmp_path / "circle.part2.mcap"]


def test_a_finished_recording_does_not_go_on(tmp_path):
    path = tmp_path / "circle.mcap"
    with write(path):
        pass
    with pytest.raises(RecordingExistsError, match=r"circle\.mcap: it is finished"):
        next_part(path)


def test_a_recording_that_is_being_written_belongs_to_its_recorder(tmp_path):
    path = tmp_path / "circle.mcap"
    with write(path), pytest.raises(RecordingInUseError, match="another recorder"):
        next_part(path)
