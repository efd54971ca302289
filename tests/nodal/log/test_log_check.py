"""Whether `nodal log check` finds what is wrong, and nothing where nothing is."""

from pathlib import Path

import pytest
from mcap.reader import make_reader

from nodal.__main__ import main
from nodal.exit_status import ERROR
from nodal.log.check import UNHEALTHY
from recordings import Log
from recordings.copying import Copy

RUN = Path(__file__).parents[2] / "data" / "run.mcap"


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    """A stretch of the golden run in which nothing went wrong."""
    path = tmp_path_factory.mktemp("check") / "quiet.mcap"
    assert main(["log", "cut", str(RUN), "-o", str(path), "--from", "2.6", "--until", "6"]) == 0
    return path


def changed(source, path, keep=lambda entry: True, attached=True):
    """A copy of this recording with some of its messages."""
    log = Log(source)
    with Copy(path, compressed=True) as copy:
        copy.attach(log.attachments if attached else {}, log.span_ns[0])
        copy.write(entry for _, entry in log.entries() if keep(entry))
        copy.summarise({}, "the test was done")
    return path


def every(number, key):
    """Leave out one message in so many of a topic."""
    seen = [0]

    def keep(entry):
        seen[0] += entry.stream.topic == key
        return entry.stream.topic != key or seen[0] % number

    return keep


@pytest.fixture
def check(capsys):
    def told(*paths):
        status = main(["log", "check", *map(str, paths)])
        said = capsys.readouterr()
        return status, said.out or said.err

    return told


def test_a_stretch_in_which_all_went_well_is_healthy(check, quiet):
    assert check(quiet) == (0, f"{quiet}: healthy\n")


def test_the_time_in_which_sensing_was_dead_is_found(check):
    status, told = check(RUN)
    assert status == UNHEALTHY
    assert "shape: silent" in told


def test_messages_left_out_are_counted(check, quiet, tmp_path):
    status, told = check(changed(quiet, tmp_path / "log.mcap", every(5, "tendon/state")))
    assert status == UNHEALTHY
    assert "losses" in told
    assert "tendon/state" in told


def test_a_topic_that_is_too_slow_is_named_with_what_is_expected(check, quiet, tmp_path):
    status, told = check(changed(quiet, tmp_path / "log.mcap", every(4, "truth")))
    assert status == UNHEALTHY
    assert any("rate" in line and "truth" in line and "expected 15" in line for line in told.splitlines())


def test_frames_without_a_partner_are_counted(check, quiet, tmp_path):
    status, told = check(changed(quiet, tmp_path / "log.mcap", every(3, "camera/left")))
    assert status == UNHEALTHY
    assert "have no partner" in told


def test_missing_attachments_are_named(check, quiet, tmp_path):
    status, told = check(changed(quiet, tmp_path / "log.mcap", attached=False))
    assert status == UNHEALTHY
    assert "no bench.toml is attached" in told


@pytest.mark.parametrize("key", ["sensing/memory", "controller/memory"])
def test_what_a_replay_would_lack_is_found(check, quiet, tmp_path, key):
    log = changed(quiet, tmp_path / "log.mcap", keep=lambda entry: entry.stream.topic != key)
    status, told = check(log)
    assert status == UNHEALTHY
    assert f"{key}: none" in told


def test_faults_and_restarts_are_told(check):
    _, told = check(RUN)
    assert "no trusted shape for 1.01 s, 1 s are allowed" in told
    assert "restart  sensing began anew; silent for 1." in told


def test_one_that_cannot_be_read_keeps_nobody_from_the_others(quiet, tmp_path, capsys):
    (tmp_path / "bad.mcap").write_bytes(b"not a recording")
    assert main(["log", "check", str(tmp_path / "bad.mcap"), str(quiet)]) == ERROR
    said = capsys.readouterr()
    assert "bad.mcap" in said.err
    assert said.out == f"{quiet}: healthy\n"


def test_a_part_of_which_nothing_can_be_read_is_told_and_the_others_are_read(check, quiet, tmp_path):
    first, second = tmp_path / "log.mcap", tmp_path / "log.part2.mcap"
    first.write_bytes(quiet.read_bytes())
    second.write_bytes(bytes(5000))
    status, told = check(first)
    assert status == UNHEALTHY
    assert "log.part2.mcap" in told
    assert len(list(Log(first).messages())) == len(list(Log(quiet).messages()))


def test_a_file_that_was_cut_off_is_unhealthy(check, quiet, tmp_path):
    log = tmp_path / "log.mcap"
    log.write_bytes(quiet.read_bytes()[:-5000])
    status, told = check(log)
    assert status == UNHEALTHY
    assert "cut off" in told


def test_a_recorder_killed_between_two_chunks_is_found(check, quiet, tmp_path):
    with quiet.open("rb") as file:
        chunk = make_reader(file).get_summary().chunk_indexes[-1]
    log = tmp_path / "log.mcap"
    log.write_bytes(
        quiet.read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length + chunk.message_index_length]
    )
    assert len(list(Log(log).messages())) == len(list(Log(quiet).messages()))
    status, told = check(log)
    assert status == UNHEALTHY
    assert told.count("cut off") == 1


def test_changed_bytes_are_damage(check, quiet, tmp_path):
    log = tmp_path / "log.mcap"
    data = bytearray(quiet.read_bytes())
    data[len(data) // 2] ^= 255
    log.write_bytes(data)
    status, told = check(log)
    assert status == UNHEALTHY
    assert "damage" in told


def test_each_of_several_has_its_verdict(check, quiet):
    status, told = check(quiet, RUN)
    assert status == UNHEALTHY
    assert f"{quiet}: healthy" in told
    assert f"{RUN}: " in told


def test_what_is_no_recording_is_an_error(check, tmp_path):
    log = tmp_path / "log.mcap"
    log.write_text("this is no recording at all")
    status, told = check(log)
    assert status == ERROR
    assert "not an MCAP file" in told
    assert told.count("\n") == 1
