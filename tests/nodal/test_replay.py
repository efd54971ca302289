"""A log replays to the same bits, however it is computed; what differs or is missing is named; a what-if can be replayed."""

import dataclasses
import json
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from messaging import topics
from messaging.frames import Frame
from nodal.__main__ import main
from nodal.replay.verification import verified
from nodal.replay.workers import workers
from recordings.log import Log
from recordings.reader import topic_of
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

RUN = Path(__file__).parents[1] / "data" / "run.mcap"
STANDS_STILL = """
import msgspec

class Tuning(msgspec.Struct):
    pass

class StandsStill:
    lead_s = 0.0
    def start(self, beginning):
        return beginning.command_mm
    def step(self, state, inputs):
        return state, state

def make(tuning, plant):
    return StandsStill()
"""
BEGIN_S, END_S = 7.4, 10.3


def rewritten(source, out, change):
    """A copy of a recording in which `change` gives each publication other bytes, or None to leave it out."""
    log = Log(source)
    with RecordingWriter(out, RecorderSettings()) as recording:
        for name, data in log.attachments.items():
            recording.attach(name, data, 0)
        for recorded in log.messages():
            if (payload := change(recorded)) is not None:
                recording.write(
                    recorded.topic,
                    topic_of(recorded.topic).type.protobuf,
                    payload,
                    sequence=recorded.sequence,
                    publish_time_ns=recorded.publish_time_ns,
                    log_time_ns=recorded.log_time_ns,
                )
    return out


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Three seconds out of the middle of the run: it begins and ends while the circle is being followed."""
    begin_ns = next(Log(RUN).messages()).log_time_ns

    def inside(recorded):
        after_s = (recorded.log_time_ns - begin_ns) / 1e9
        return recorded.payload if BEGIN_S <= after_s < END_S else None

    return rewritten(RUN, tmp_path_factory.mktemp("short") / "short.mcap", inside)


def verdict_on(path):
    with ThreadPoolExecutor(1) as executor:
        return next(iter(verified([path], executor)))


def replay(*words):
    return main(["replay", *map(str, words)])


def changed(topic, nth, change):
    """Changes the nth publication of this topic; a change to None leaves it out."""
    count = iter(range(10**9))

    def apply(recorded):
        if recorded.topic != topic.key or next(count) != nth:
            return recorded.payload
        message = change(recorded.message)
        return None if message is None else message.to_bytes()

    return apply


def nothing(_):
    return None


class TestTheSame:
    def test_a_log_replays_to_its_own_bits(self, short, capsys):
        assert replay(short) == 0
        said = capsys.readouterr().out
        assert re.search(r"short\.mcap: same", said)
        assert "not compared, being durations: ShapeEstimate capture_to_publish_ns, stage_s;" in said

    def test_everything_after_the_first_memory_is_compared(self, short):
        comparison = verdict_on(short).comparison
        log = Log(short)
        for topic in (topics.SHAPE, topics.CONTROLLER_STATE):
            count = len(list(log.messages([topic])))
            left_out = sum(comparison.skipped[topic.key].values())
            assert comparison.topics[topic.key].compared + left_out == count
            assert left_out < 0.5 * count
        assert set(comparison.skipped[topics.CONTROLLER_STATE.key]) == {
            "it stands before the first memory in the log"
        }
        assert comparison.topics[topics.TENDON_COMMAND.key].compared > 100
        assert comparison.topics[topics.SENSING_MEMORY.key].compared >= 1
        assert comparison.topics[topics.CONTROLLER_MEMORY.key].compared >= 1

    def test_the_outcome_is_the_same_each_time_and_with_any_workers(self, short, monkeypatch):
        monkeypatch.setattr("nodal.replay.script.STRETCH_NS", 500_000_000)
        outcomes = []
        for jobs, cluster in ((1, None), (2, None), (2, "local")):
            with workers(jobs, cluster) as executor:
                outcomes += [(v.same, v.comparison, v.span_s) for v in verified([short, short], executor)]
        assert outcomes[0][0]
        assert outcomes == outcomes[:1] * 6


class TestDifferent:
    def test_a_changed_estimate_is_named_with_field_amount_and_place(self, short, tmp_path, capsys):
        def nudged(estimate):
            return dataclasses.replace(estimate, node_mm=estimate.node_mm + np.diag([0, 0.25, 0])[:2])

        log = rewritten(short, tmp_path / "a.mcap", changed(topics.SHAPE, 30, nudged))
        assert replay(log, "--json") == 1
        outcome = json.loads(capsys.readouterr().out)
        assert not outcome["same"]
        tally = outcome["verdicts"][0]["comparison"]["topics"]["shape"]
        assert (tally["different"], list(tally["fields"])) == (1, ["node_mm"])
        difference = tally["fields"]["node_mm"]
        assert difference["largest"] == pytest.approx(0.25)
        estimates = [recorded.message for recorded in Log(log).messages([topics.SHAPE])]
        assert difference["first_time_ns"] == estimates[30].capture_time_ns

    def test_one_bit_is_enough(self, short, tmp_path):
        def nudged(command):
            displacement_mm = command.displacement_mm.copy()
            displacement_mm[2] = np.nextafter(displacement_mm[2], np.inf)
            return dataclasses.replace(command, displacement_mm=displacement_mm)

        log = rewritten(short, tmp_path / "a.mcap", changed(topics.TENDON_COMMAND, 200, nudged))
        tally = verdict_on(log).comparison.topics[topics.TENDON_COMMAND.key]
        assert (tally.different, list(tally.fields)) == (1, ["displacement_mm"])

    def test_another_picture_gives_another_estimate(self, short, tmp_path):
        frames = [recorded.message for recorded in Log(short).messages([topics.CAMERA])]
        other = next(frame.jpeg for frame in reversed(frames) if frame.camera == "left")
        change = changed(
            topics.CAMERA.named("left"), 30, lambda frame: dataclasses.replace(frame, jpeg=other)
        )
        verdict = verdict_on(rewritten(short, tmp_path / "a.mcap", change))
        assert not verdict.same
        assert "centreline_mm" in verdict.comparison.topics[topics.SHAPE.key].fields

    def test_durations_are_not_compared(self, short, tmp_path):
        def slower(state):
            return dataclasses.replace(state, lateness_s=1.0, busy_s=1.0, overruns=7)

        change = changed(topics.CONTROLLER_STATE, 150, slower)
        assert verdict_on(rewritten(short, tmp_path / "a.mcap", change)).same

    def test_an_answer_that_would_be_another_is_told(self, tmp_path):
        def turned(asked):
            return dataclasses.replace(asked, accepted=not asked.accepted)

        verdict = verdict_on(rewritten(RUN, tmp_path / "a.mcap", changed(topics.ASKED, 1, turned)))
        assert list(verdict.comparison.topics[topics.ASKED.key].fields) == ["accepted"]


class TestMissing:
    @pytest.mark.parametrize(
        ("topic", "told_of", "reason"),
        [
            (topics.CAMERA.named("left"), topics.SHAPE, "a frame is missing from the log"),
            (
                topics.SHAPE,
                topics.SHAPE,
                "an estimate between the memory and it is missing from the log",
            ),
            (topics.SHAPE, topics.CONTROLLER_STATE, "the shape that a cycle saw is missing from the log"),
            (
                topics.TENDON_STATE,
                topics.CONTROLLER_STATE,
                "the servos' report that a cycle saw is missing from the log",
            ),
            (
                topics.CONTROLLER_STATE,
                topics.CONTROLLER_STATE,
                "a cycle between the memory and it is missing from the log",
            ),
            (topics.TENDON_COMMAND, topics.TENDON_COMMAND, "the cycle's command is missing from the log"),
        ],
        ids=lambda value: getattr(value, "key", None),
    )
    def test_what_a_lost_message_made_unknown_is_left_out_and_said(
        self, short, tmp_path, topic, told_of, reason
    ):
        nth = 30 if topic in (topics.SHAPE, topics.CAMERA.named("left")) else 140
        verdict = verdict_on(rewritten(short, tmp_path / "a.mcap", changed(topic, nth, nothing)))
        assert verdict.same
        assert verdict.comparison.skipped[told_of.key][reason] >= 1
        # until the next memory, not for ever
        assert (
            verdict.comparison.skipped[told_of.key][reason] < verdict.comparison.topics[told_of.key].compared
        )

    def test_a_log_without_memories_says_that_nothing_could_be_compared(self, short, tmp_path, capsys):
        memories = (topics.SENSING_MEMORY.key, topics.CONTROLLER_MEMORY.key)
        log = rewritten(short, tmp_path / "a.mcap", lambda r: None if r.topic in memories else r.payload)
        assert replay(log) == 1
        assert "nothing could be compared" in capsys.readouterr().out


class TestWhatIf:
    def test_without_changes_it_is_the_log_itself(self, tmp_path):
        assert replay(RUN, "-o", tmp_path / "again.mcap") == 0
        for topic in (topics.SHAPE, topics.TENDON_COMMAND, topics.CONTROLLER_STATE, topics.TARGET):
            before, after = (
                [recorded.message for recorded in Log(path).messages([topic])]
                for path in (RUN, tmp_path / "again.mcap")
            )
            assert len(before) == len(after)
        assert verdict_on(tmp_path / "again.mcap").same

    def test_the_same_question_gives_the_same_file(self, short, tmp_path):
        other = "sensing.nodal_points=[{name='tip', arc_mm=79.5}]"
        assert replay(short, "--set", other, "-o", tmp_path / "a.mcap", "--jobs", "1") == 0
        assert replay(short, "--set", other, "-o", tmp_path / "b.mcap", "--jobs", "2") == 0
        assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()

    def test_other_nodal_points_are_reported_and_the_rest_follows(self, short, tmp_path, capsys):
        out = tmp_path / "what-if.mcap"
        points = "sensing.nodal_points=[{name='quarter', arc_mm=20}, {name='tip', arc_mm=80}]"
        assert replay(short, "--set", points, "-o", out) == 0
        assert "node_names: in" in capsys.readouterr().out
        estimates = [recorded.message for recorded in Log(out).messages([topics.SHAPE])]
        assert {estimate.node_names for estimate in estimates} == {("quarter", "tip")}
        assert b"quarter" in Log(out).attachments["bench.toml"]
        assert verdict_on(out).same

    def test_another_method_sees_the_same_robot(self, short, tmp_path):
        out = tmp_path / "what-if.mcap"
        assert replay(short, "--set", "sensing.method=plain", "-o", out) == 0
        before, after = (
            {m.message.sequence: m.message for m in Log(path).messages([topics.SHAPE])}
            for path in (short, out)
        )
        assert {estimate.method for estimate in after.values()} == {"plain"}
        both = [n for n in before.keys() & after.keys() if before[n].trusted and after[n].trusted]
        off = [np.linalg.norm(before[n].node_mm - after[n].node_mm, axis=1).max() for n in both]
        assert len(both) > 0.5 * len(after)
        assert max(off) < 2.0
        assert verdict_on(out).same

    def test_a_law_in_a_file_is_run_only_when_the_user_says_so(self, short, tmp_path, capsys):
        law, out = tmp_path / "stands_still.py", tmp_path / "what-if.mcap"
        law.write_text(STANDS_STILL)
        assert replay(RUN, "--set", f"controller.law_file={law}", "-o", out) == 0
        assert Log(out).attachments["law.py"].decode() == STANDS_STILL
        law.rename(tmp_path / "mine.py")
        capsys.readouterr()
        assert replay(out) == 2
        told = capsys.readouterr().err
        assert "led by a law of its own" in told
        assert "--law FILE" in told
        assert replay(out, "--law", tmp_path / "mine.py") == 0

    def test_another_gain_gives_other_commands(self, tmp_path):
        out = tmp_path / "what-if.mcap"
        assert replay(RUN, "--set", "controller.tuning.feedback_per_s=2", "-o", out) == 0
        before, after = (
            {m.message.time_ns: m.message for m in Log(path).messages([topics.TENDON_COMMAND])}
            for path in (RUN, out)
        )
        both = before.keys() & after.keys()
        gap = [np.abs(before[t].displacement_mm - after[t].displacement_mm).max() for t in both]
        assert 0.01 < max(gap) < 10
        assert verdict_on(out).same

    def test_pictures_that_nobody_looked_at_are_estimated(self, short, tmp_path):
        pictures = rewritten(
            short,
            tmp_path / "pictures.mcap",
            lambda r: r.payload if topic_of(r.topic) == topics.CAMERA else None,
        )
        assert replay(pictures, "-o", tmp_path / "out.mcap") == 0
        frames = [recorded.message for recorded in Log(pictures).messages([topics.CAMERA])]
        assert all(isinstance(frame, Frame) for frame in frames)
        estimates = [recorded.message for recorded in Log(tmp_path / "out.mcap").messages([topics.SHAPE])]
        assert len(estimates) == len(frames) // 2
        assert not any(estimate.refusal for estimate in estimates)
        assert verdict_on(tmp_path / "out.mcap").same

    def test_several_logs_go_into_a_folder(self, short, tmp_path):
        other = tmp_path / "other.mcap"
        other.write_bytes(short.read_bytes())
        assert replay(short, other, "-o", tmp_path / "out") == 0
        assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["other.mcap", "short.mcap"]


class TestWords:
    @pytest.mark.parametrize(
        ("words", "complaint"),
        [
            (["--set", "controller.law=x"], "say where to write that: -o OUT"),
            (["--set", "law", "-o", "x.mcap"], "'law' is not KEY=VALUE"),
            (["--set", "recorder.folder=x", "-o", "x.mcap"], "keys of robot, sensing, controller only"),
            (["--jobs", "0"], "--jobs 0: at least 1"),
        ],
    )
    def test_words_that_mean_nothing_are_refused(self, words, complaint, capsys, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        assert replay(RUN, *words) == 2
        assert complaint in capsys.readouterr().err

    @pytest.mark.parametrize(
        ("change", "complaint"),
        [
            ("controller.law=mine", "law 'mine' is not known; known are model_free, resolved_rate"),
            ("controller.rate=3", "controller.rate is unknown"),
            ("sensing.nodal_points=[{name='far', arc_mm=99}]", "far at 99 mm is beyond the robot"),
            ("sensing.background.left=x.jpg", "no background-left is attached"),
        ],
    )
    def test_settings_that_the_bench_file_could_not_have_are_refused(
        self, change, complaint, tmp_path, capsys
    ):
        assert replay(RUN, "--set", change, "-o", tmp_path / "x.mcap") == 2
        said = capsys.readouterr().err
        assert complaint in said
        assert "Traceback" not in said

    def test_one_bad_log_does_not_keep_the_others_from_being_replayed(self, short, tmp_path, capsys):
        (tmp_path / "bad.mcap").write_bytes(b"not a recording at all")
        assert replay(tmp_path / "bad.mcap", short, tmp_path / "none.mcap") == 2
        told = capsys.readouterr()
        assert "short.mcap: same" in told.out
        assert "bad.mcap" in told.err
        assert "none.mcap" in told.err

    def test_a_recording_is_never_overwritten(self, short, tmp_path, capsys):
        (tmp_path / "here.mcap").write_bytes(b"mine")
        assert replay(short, "-o", tmp_path / "here.mcap") == 2
        assert (tmp_path / "here.mcap").read_bytes() == b"mine"
        assert "here.mcap" in capsys.readouterr().err

    def test_no_cluster_is_said(self, short, capsys):
        assert replay(short, "--dask", "tcp://127.0.0.1:9") == 2
        assert "no scheduler answers there" in capsys.readouterr().err
