"""Stretches cut out of the golden run: what is in them, that they stand alone, and what is refused."""

from itertools import pairwise
from pathlib import Path

import pytest
from mcap.reader import make_reader

from messaging.topics import CONTROLLER_MEMORY, CONTROLLER_STATE, SENSING_MEMORY
from nodal.__main__ import main
from nodal.exit_status import ERROR
from nodal.log.events import KINDS
from recordings import Log

RUN = Path(__file__).parents[2] / "data" / "run.mcap"
SECOND_NS = 10**9


def cut(out, *words):
    return main(["log", "cut", str(RUN), "-o", str(out), *words])


def entries(path, *span):
    return [
        (entry.stream, entry.log_time_ns, entry.publish_time_ns, entry.sequence, entry.payload)
        for _, entry in Log(path).entries(None, *span)
    ]


@pytest.fixture(scope="module")
def middle(tmp_path_factory):
    path = tmp_path_factory.mktemp("cut") / "middle.mcap"
    assert cut(path, "--from", "8", "--until", "11.5") == 0
    return path


def test_a_cut_holds_what_was_logged_then_byte_for_byte(middle):
    begin_ns, _ = Log(RUN).span_ns
    span_ns = begin_ns + 8 * SECOND_NS, begin_ns + 115 * SECOND_NS // 10
    (repeated,) = (int(part["repeated"]) for part in Log(middle).metadata("PART").values())
    assert repeated > 0
    assert entries(middle)[repeated:] == entries(RUN, *span_ns)


def test_a_cut_begins_with_what_still_held(middle):
    begin_ns = Log(middle).span_ns[0]
    newest = {}
    for entry in entries(RUN, None, begin_ns):
        newest[entry[0].topic] = entry
    (repeated,) = (int(part["repeated"]) for part in Log(middle).metadata("PART").values())
    first = entries(middle)[:repeated]
    assert {SENSING_MEMORY.key, CONTROLLER_MEMORY.key, "target", "camera/left/pose"} <= {
        stream.topic for stream, *_ in first
    }
    for stream, log_ns, *rest in first:
        assert log_ns == begin_ns
        assert tuple(rest) == newest[stream.topic][2:]


def test_a_cut_keeps_attachments_and_versions(middle):
    whole, part = Log(RUN), Log(middle)
    assert part.attachments == whole.attachments
    assert list(part.metadata("VERSIONS").values()) == list(whole.metadata("VERSIONS").values())
    assert part.damage == []


def test_other_readers_open_a_cut(middle):
    with middle.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        count = sum(1 for _ in reader.iter_messages())
        assert count == reader.get_summary().statistics.message_count == len(entries(middle))


def test_a_cut_can_be_replayed_from_its_first_memories_on(middle, capsys):
    assert main(["replay", str(middle), "--jobs", "1"]) == 0
    assert "same" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("event", "state"),
    [("fault", "fault"), ("state:ready", "ready"), ("hold", "hold"), ("state:hold", "hold")],
)
def test_a_cut_around_an_event_has_it_where_it_was_asked_for(tmp_path, event, state):
    out = tmp_path / "event.mcap"
    assert cut(out, "--around", event, "--before", "0.5", "--after", "0.5") == 0
    begin_ns, _ = Log(out).span_ns
    states = [(one.log_time_ns, one.message.state) for one in Log(out).messages([CONTROLLER_STATE])]
    changed_ns = next(
        time_ns for (_, before), (time_ns, now) in pairwise(states) if now != before and now == state
    )
    assert changed_ns - begin_ns == pytest.approx(SECOND_NS // 2, abs=SECOND_NS // 10)


@pytest.mark.parametrize("event", ["asked:sensing/nodes", "target:circle", "asked"])
def test_events_of_every_other_kind_are_found(tmp_path, event):
    assert cut(tmp_path / "event.mcap", "--around", event, "--before", "0.1", "--after", "0.1") == 0


def test_an_event_that_does_not_occur_names_those_that_do(tmp_path, capsys):
    out = tmp_path / "never.mcap"
    assert cut(out, "--around", "flag:tip_unseen") == ERROR
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "flag:tip_unseen does not occur" in told
    assert "target:circle" in told
    assert "state:homing (2 times)" in told
    assert not out.exists()


def test_an_unknown_event_names_the_known_ones(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        cut(tmp_path / "unknown.mcap", "--around", "sneeze")
    assert ended.value.code == ERROR
    told = capsys.readouterr().err
    assert all(kind in told for kind in KINDS)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ([], "--around"),
        (["--from", "1", "--around", "fault"], "--around"),
        (["--from", "5", "--until", "3"], "not after"),
        (["--from", "1000"], "has ended by then"),
    ],
)
def test_a_stretch_that_cannot_be_is_one_clear_line(tmp_path, capsys, words, problem):
    assert cut(tmp_path / "out.mcap", *words) == ERROR
    told = capsys.readouterr().err
    assert told.startswith("nodal: error: ")
    assert told.count("\n") == 1
    assert problem in told
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_overwritten(tmp_path, capsys):
    out = tmp_path / "out.mcap"
    out.write_bytes(b"mine")
    assert cut(out, "--from", "1", "--until", "2") == ERROR
    assert "exists" in capsys.readouterr().err
    assert out.read_bytes() == b"mine"
    before = RUN.read_bytes()
    assert cut(RUN, "--from", "1", "--until", "2") == ERROR
    assert RUN.read_bytes() == before
