"""What is recovered from the golden run when it is whole, cut off, changed in the middle, or in parts."""

import struct
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from nodal.__main__ import main
from nodal.exit_status import ERROR
from recordings import Log

RUN = Path(__file__).parents[2] / "data" / "run.mcap"


def recover(log, out):
    return main(["log", "recover", str(log), "-o", str(out)])


def entries(path):
    return [
        (entry.stream, entry.log_time_ns, entry.publish_time_ns, entry.sequence, entry.payload)
        for _, entry in Log(path).entries()
    ]


def is_whole(path):
    """True when another reader finds the index, and every message by it."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        return sum(1 for _ in reader.iter_messages()) == reader.get_summary().statistics.message_count


def test_a_whole_recording_comes_out_as_it_is(tmp_path):
    out = tmp_path / "out.mcap"
    assert recover(RUN, out) == 0
    assert entries(out) == entries(RUN)
    assert Log(out).attachments == Log(RUN).attachments
    assert list(Log(out).metadata("VERSIONS").values()) == list(Log(RUN).metadata("VERSIONS").values())
    assert is_whole(out)


def test_of_a_file_that_was_cut_off_everything_readable_comes_out(tmp_path, capsys):
    log, out = tmp_path / "log.mcap", tmp_path / "out.mcap"
    log.write_bytes(RUN.read_bytes()[:2_000_000])
    assert recover(log, out) == 0
    told = capsys.readouterr()
    assert "cut off" in told.err
    assert str(out) in told.out
    assert entries(out) == entries(log)
    assert Log(out).damage == []
    assert is_whole(out)
    (note,) = Log(out).metadata("RECOVERED").values()
    assert any("cut off" in fact for fact in note.values())
    assert any("log.mcap" in fact for fact in note.values())


def test_of_a_file_with_changed_bytes_the_rest_comes_out(tmp_path, capsys):
    log, out = tmp_path / "log.mcap", tmp_path / "out.mcap"
    data = bytearray(RUN.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 100] = bytes(100)
    log.write_bytes(data)
    assert recover(log, out) == 0
    assert "missing by their numbers" in capsys.readouterr().err
    got, whole = entries(out), entries(RUN)
    assert 0 < len(got) < len(whole)
    assert set(got) < set(whole)
    assert is_whole(out)


def test_parts_become_one_file(tmp_path):
    first, second, out = tmp_path / "log.mcap", tmp_path / "log.part2.mcap", tmp_path / "out.mcap"
    for part, words in ((first, ["--until", "6"]), (second, ["--from", "6"])):
        assert main(["log", "cut", str(RUN), "-o", str(part), *words]) == 0
    assert recover(first, out) == 0
    # what the second part repeats of the first is in it once
    assert entries(out) == entries(RUN)
    assert is_whole(out)


def test_topics_of_other_producers_are_kept_with_their_descriptions(tmp_path):
    log, out = tmp_path / "log.mcap", tmp_path / "out.mcap"
    with log.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("xyz/Weight", "jsonschema", b"{}")
        scale = writer.register_channel("scale", "json", schema, {"unit": "g"})
        bare = writer.register_channel("bare", "", 0)
        writer.add_message(scale, 5, b'{"g": 3}', 4, 7)
        writer.add_message(bare, 6, struct.pack("<d", 1.5), 6, 0)
        writer.finish()
    assert recover(log, out) == 0
    got = entries(out)
    assert got == entries(log)
    assert [(stream.topic, dict(stream.metadata)) for stream, *_ in got] == [
        ("scale", {"unit": "g"}),
        ("bare", {}),
    ]


def text(path):
    path.write_text("this is no recording, whatever its name says")


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda path: None, "no such recording"),
        (Path.touch, "no message"),
        (Path.mkdir, "folder"),
        (text, "not an MCAP file"),
    ],
)
def test_what_is_no_recording_is_one_clear_line(tmp_path, capsys, make, problem):
    log, out = tmp_path / "log.mcap", tmp_path / "out.mcap"
    make(log)
    assert recover(log, out) == ERROR
    told = capsys.readouterr().err
    assert told.startswith("nodal: error: ")
    assert told.count("\n") == 1
    assert problem in told
    assert not out.exists()


def test_nothing_is_overwritten(tmp_path, capsys):
    log = tmp_path / "log.mcap"
    log.write_bytes(RUN.read_bytes())
    assert recover(log, log) == ERROR
    assert "exists" in capsys.readouterr().err
    assert log.read_bytes() == RUN.read_bytes()


def test_it_cannot_be_written_among_its_own_parts(tmp_path, capsys):
    log = tmp_path / "log.mcap"
    log.write_bytes(RUN.read_bytes())
    assert recover(log, tmp_path / "log.part2.mcap") == ERROR
    assert "would make it a part" in capsys.readouterr().err
