"""A recording that was cut off goes on beside itself."""

from pathlib import Path

import pytest

from recordings.errors import RecordingExistsError, RecordingInUseError
from recordings.parts import GOES_ON_IN, new_path, next_number, part_path, parts
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


def test_a_recording_killed_between_two_parts_goes_on(tmp_path):
    path = tmp_path / "circle.mcap"
    with write(path) as recording:
        recording.describe("SUMMARY", {GOES_ON_IN: "circle.part2.mcap"})
    assert next_part(path) == tmp_path / "circle.part2.mcap"
    # the next part is made before the one that is full is finished, so that the kill may also leave this
    (tmp_path / "circle.part2.mcap").touch()
    assert next_part(path) == tmp_path / "circle.part3.mcap"


def test_a_part_that_is_gone_hides_none_of_those_after_it(tmp_path):
    path = tmp_path / "circle.mcap"
    for name in (
        "circle.part2.mcap",
        "circle.part10.mcap",
        "circle.part1.mcap",
        "other.part3.mcap",
        "circle.part4.mcap.bak",
    ):
        (tmp_path / name).touch()
    assert parts(path) == [tmp_path / "circle.part2.mcap", tmp_path / "circle.part10.mcap"]
    assert next_part(path) == tmp_path / "circle.part11.mcap"


def test_a_finished_recording_does_not_go_on(tmp_path):
    path = tmp_path / "circle.mcap"
    with write(path) as recording:
        recording.describe("SUMMARY", {GOES_ON_IN: "circle.part2.mcap"})
    with write(tmp_path / "circle.part2.mcap"):
        pass
    with pytest.raises(RecordingExistsError, match=r"circle\.part2\.mcap: it is finished"):
        next_part(path)


def test_a_recording_that_is_being_written_belongs_to_its_recorder(tmp_path):
    path = tmp_path / "circle.mcap"
    with write(path), pytest.raises(RecordingInUseError, match="another recorder"):
        next_part(path)


def test_a_later_part_alone_has_no_others(tmp_path):
    (tmp_path / "circle.mcap").touch()
    (tmp_path / "circle.part2.mcap").touch()
    assert parts(tmp_path / "circle.part2.mcap") == [tmp_path / "circle.part2.mcap"]


def test_a_folder_that_is_not_there_holds_nothing(tmp_path):
    assert parts(tmp_path / "nowhere" / "circle.mcap") == []


def test_names_that_are_taken_get_a_number(tmp_path):
    (tmp_path / "2026-05-02T12-57-25Z-fault.mcap").touch()
    time_ns = 1_777_726_645_987_654_321
    assert new_path(tmp_path, time_ns, "fault").name == "2026-05-02T12-57-25Z-fault-2.mcap"
    assert new_path(tmp_path, time_ns).name == "2026-05-02T12-57-25Z.mcap"
