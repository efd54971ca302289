"""`nodal report`: whole pages, of recordings made up to hold much, little, or what nobody would wish for."""

import dataclasses
import json
import re
import sys
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest

from messaging import topics
from messaging.control import Action, ActionRequest, State
from nodal import targets
from nodal.__main__ import main
from nodal.report.loading import load_run
from nodal.report.page import run_page
from nodal.report.page.writing import write_page
from nodal.report.summary import CIRCLE, HOLD, summary_of

VOID = {"meta", "link", "br", "hr", "img", "input"}
LATE = "no trusted shape: shape arrived 109 ms after its capture, 100 ms are allowed"


class Page(HTMLParser):
    """Checks the structure of a page while it reads it, and keeps what is in it."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.ids, self.texts, self.links = [], [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        found = dict(attributes)
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found[name] for name in ("href", "src") if name in found]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.texts.append(data)

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.texts))

    def all(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture
def circle():
    return dataclasses.replace(
        targets.circle("tip", radius_mm=15, period_s=10, height_mm=85, centre_mm=(0, 0)), name=CIRCLE
    )


@pytest.fixture
def quick(monkeypatch):
    """Charts are not drawn: that takes most of the time, and one test looks at it."""
    monkeypatch.setattr(run_page, "as_svg", lambda chart, salt: "<svg></svg>")


@pytest.fixture
def full(story, circle):
    """Everything a simulated bench says in two seconds, with a hold, a flag, a refusal and a fault."""
    story.ask(0.05, topics.CONTROLLER_DO, ActionRequest(action=Action.ARM), "the operator asked to arm")
    story.ask(0.1, topics.CONTROLLER_TARGET, circle, "out of reach", accepted=False)
    story.take_up(0.1, circle)
    story.show_truth(-0.1, 2.1)
    story.sense(0.0, 1.0)
    story.sense(1.0, 1.1, flags=("tip_unseen",))
    story.sense(1.1, 2.0)
    story.control(0.1, 1.0)
    story.control(1.0, 1.2, state=State.HOLD, reason=LATE)
    story.control(1.2, 1.8)
    story.control(1.8, 2.0, state=State.FAULT, reason="the bus is silent", target="")
    story.log(1.8, 40, "fault: the bus is silent", "controller")
    return story


def page_of(path, *more):
    page, reports = write_page([path, *more], None)
    return Page(page.read_text(encoding="utf-8")), reports


def test_a_page_stands_for_itself_and_is_sound(full, tmp_path):
    page, _ = page_of(full.write(tmp_path / "run.mcap"))

    assert len(page.ids) == len(set(page.ids))
    assert all(link.startswith(("#", "data:image/jpeg;base64,")) for link in page.links)
    assert {link[1:] for link in page.links if link[0] == "#"} <= set(page.ids)
    assert not {"script", "link", "iframe", "img"} & {tag for tag, _ in page.tags}
    assert "://" not in (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "url(#" in (tmp_path / "run.html").read_text(encoding="utf-8")
    assert all(picture["role"] == "img" and picture["aria-label"] for picture in page.all("svg"))
    assert all(head["scope"] in ("col", "row") for head in page.all("th"))
    assert len(page.all("figure")) > 15
    assert (tmp_path / "run.html").stat().st_size < 2_000_000


def test_a_page_says_what_was_asked_and_what_came_of_it(full, tmp_path, quick):
    page, _ = page_of(full.write(tmp_path / "run.mcap"))

    for words in (
        "Something went wrong",
        "1 fault, the first after 1.9 s: the bus is silent",
        "bench made-up, 2023-11-14 22:13:19 UTC",
        "arm accepted",
        "through 121 moments in 10 s, again and again refused tracking out of reach",
        "no trusted shape: shape arrived … ms after its capture, … ms are allowed 1 0.20",
        "tip_unseen 3 frame set 31",
        "fault: the bus is silent",
        'name = "made-up"',
        "2 of shape",
        "nodal 1.2.3",
    ):
        assert words in page.text, words
    assert page.all("polyline")
    assert page.all("path")


def test_its_figures_are_those_of_the_summary(full, tmp_path, quick):
    path = full.write(tmp_path / "run.mcap")
    _, [report] = page_of(path)
    summary = summary_of(load_run(path), "run.mcap", None)

    figures = report.as_builtins()["figures"]

    assert figures["truth"]["all nodal points"]["mean_mm"] == summary.node_error_mm.mean == 0.2
    assert figures["tracking"][CIRCLE]["true_rms_mm"] == summary.tracking_error_mm.rms == 0.5
    assert figures["latency"]["capture to command"]["p50_ms"] == summary.capture_to_command_ms.p50 == 20
    assert figures["loop"]["lateness of a cycle"]["p99_ms"] == summary.control_lateness_ms.p99 == 2
    assert figures["sensing"]["estimates"]["flagged"] == summary.flagged == 3
    assert figures["tendons"]["stage"]["current_max_ma"] == 50
    assert figures["states"]["interruptions"]["holds"] == 1
    assert figures["tracking"][CIRCLE]["measured_rms_mm"] == 0
    assert figures["tracking"][CIRCLE]["waiting_percent"] == pytest.approx(100 * 0.2 / 1.7, rel=0.02)


def test_no_text_of_a_recording_can_become_markup(story, circle, tmp_path, quick):
    hostile = "</style></td><script>alert('&amp;')</script>\x00\"'"
    named = dataclasses.replace(circle, name=hostile)
    story.ask(0.0, topics.CONTROLLER_TARGET, named, hostile, accepted=False)
    story.take_up(0.0, named)
    story.sense(0.0, 0.3)
    story.control(0.0, 0.3, target=hostile)
    story.log(0.1, 30, hostile, hostile)

    page, _ = page_of(story.write(tmp_path / "run<b>.mcap"))

    assert not {"script", "b"} - {"b"} & {tag for tag, _ in page.tags}
    assert "<script>alert('&amp;')</script>\ufffd" in page.text
    assert "run<b>" in page.text


def without_truth(story):
    story.sense(0, 0.5)
    story.control(0, 0.5)


def without_frames(story):
    story.sense(0, 0.5, frames=False)
    story.show_truth(0, 0.5)


def without_sensing(story):
    story.control(0, 0.5)


def without_anything_usable(story):
    story.sense(0, 0.3, refusal="camera left: no robot", **NOTHING_SEEN)


def with_sensing_begun_anew(story):
    story.sense(0, 0.5)
    story.begin_anew(topics.SHAPE)
    story.sense(0.6, 1.0)


def with_the_controller_begun_anew(story):
    story.control(0, 0.5)
    story.begin_anew(topics.CONTROLLER_STATE, topics.TENDON_COMMAND, topics.TENDON_STATE)
    story.control(1.5, 2.0, state=State.IDLE, target="", reason="started")


NOTHING_SEEN = {
    "arc_mm": np.zeros(0),
    "centreline_mm": np.zeros((0, 3)),
    "epipolar_angle_rad": np.zeros(0),
    "node_names": (),
    "node_arc_mm": np.zeros(0),
    "node_mm": np.zeros((0, 3)),
    "node_covariance_mm2": np.zeros((0, 3, 3)),
}


@pytest.mark.parametrize(
    ("tell", "words"),
    [
        (lambda story: None, "The recording holds no publication"),
        (lambda story: story.log(0, 20, "hello"), "no shape estimated, and no target tracked"),
        (without_truth, "1 target tracked for 0.5 s, 0.00 mm RMS off as measured"),
        (without_frames, "0.200 mm from the truth on average"),
        (without_sensing, "no shape estimated"),
        (without_anything_usable, "Sensing refused 10 frame sets and flagged 0 estimates"),
        (with_sensing_begun_anew, "Sensing began anew in the middle"),
        (with_the_controller_begun_anew, "Controller began anew in the middle"),
    ],
)
def test_a_recording_that_holds_little_is_reported_too(story, tmp_path, tell, words):
    tell(story)

    page, _ = page_of(story.write(tmp_path / "run.mcap"))

    assert words in page.text


def test_a_recording_without_attachments_shows_frames_without_lines(full, tmp_path, quick):
    page, _ = page_of(full.write(tmp_path / "run.mcap", attached=False))

    assert page.all("image")
    assert not page.all("polyline")
    assert "Settings that ran The recording holds nothing of this." in page.text
    assert "no calibration.json is attached" in page.text


def test_a_recording_that_was_cut_off_is_reported_as_far_as_it_goes(full, tmp_path, quick):
    path = full.write(tmp_path / "run.mcap")
    path.write_bytes(path.read_bytes()[: 3 * 2**20])

    page, [report] = page_of(path)

    assert 0 < len(report.findings.run.shapes) < 60
    assert "cut off" in page.text
    assert report.verdict.level != "good"


def test_all_parts_of_a_recording_are_one_run(full, tmp_path, quick):
    whole = load_run(full.write(tmp_path / "whole.mcap"))
    first = full.write(tmp_path / "run.mcap", before_s=1.0, ended=False)
    full.write(tmp_path / "run.part2.mcap", after_s=1.0)

    page, [report] = page_of(first)

    run = report.findings.run
    assert [one.sequence for one in run.shapes] == [one.sequence for one in whole.shapes]
    assert len(run.states) == len(whole.states)
    assert run.restarts == []
    assert "run.part2.mcap" in page.text


def test_messages_of_others_are_passed_over_and_unreadable_ones_are_counted(full, tmp_path, quick):
    full.say(dataclasses.replace(topics.LOG, key="somebody/else"), Bytes(b"anything"), 0.5)
    full.say(topics.TRUTH, Bytes(b"\xff\xff\xff"), 0.5)

    page, [report] = page_of(full.write(tmp_path / "run.mcap"))

    assert report.findings.run.traffic["somebody/else"].messages == 1
    assert "1 of truth; the first:" in page.text
    assert "1 publication could not be read" in page.text


class Bytes:
    def __init__(self, data):
        self.data = data

    def to_bytes(self):
        return self.data


def test_several_runs_stand_side_by_side(story, full, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    first = full.write(tmp_path / "a" / "run.mcap")
    second = full.write(tmp_path / "b" / "run.mcap", before_s=1.0)

    page, reports = page_of(first, second)

    assert [report.name for report in reports] == ["a/run", "b/run"]
    assert (tmp_path / "a" / "run-and-1-more.html").exists()
    assert len(page.ids) == len(set(page.ids))
    assert {link[1:] for link in page.links if link[0] == "#"} <= set(page.ids)
    assert {"run1", "run2", "run1-tracking", "run2-tracking"} <= set(page.ids)
    assert re.search(r"−\d+ \(−\d+ %\)", page.text)
    assert "Latencies: capture to command" in page.text
    assert all(head["scope"] in ("col", "row", "rowgroup") for head in page.all("th"))


def test_the_command_prints_figures_as_json(full, tmp_path, capsys, quick):
    path = full.write(tmp_path / "run.mcap")

    assert main(["report", str(path), "-o", str(tmp_path / "page.html"), "--json"]) == 0

    told = json.loads(capsys.readouterr().out)
    assert told["page"] == str(tmp_path / "page.html")
    [run] = told["runs"]
    assert run["verdict"]["level"] == "bad"
    assert run["asked"][0]["request"] == "arm"
    assert run["faults"][0]["reason"] == "the bus is silent"
    assert run["figures"]["sensing"]["estimates"]["estimates"] == 61
    assert msgspec.json.encode(told)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["missing.mcap"], "missing.mcap"),
        (["run.mcap", "-o", "run.mcap"], "recordings are never overwritten"),
        (["run.mcap", "-o", "nowhere/page.html"], "the page cannot be written"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(full, tmp_path, monkeypatch, capsys, quick, words, problem):
    monkeypatch.chdir(tmp_path)
    before = full.write(tmp_path / "run.mcap").read_bytes()

    assert main(["report", *words]) == 2

    assert problem in capsys.readouterr().err.splitlines()[-1]
    assert (tmp_path / "run.mcap").read_bytes() == before


def test_without_matplotlib_the_extra_is_named(full, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)

    assert main(["report", str(full.write(tmp_path / "run.mcap"))]) == 2

    assert "install nodal with its extra `plots`" in capsys.readouterr().err


def test_a_run_in_which_nothing_went_wrong_is_good(story, circle, tmp_path, quick):
    story.take_up(0.0, circle)
    story.show_truth(-0.1, 1.1)
    story.sense(0, 1)
    story.control(0, 1, off_mm=0.25)
    hold = dataclasses.replace(targets.points({"tip": [15, 0, 85]}, {}), name=HOLD)
    story.take_up(1.0, hold)
    path = story.write(tmp_path / "run.mcap")

    _, [report] = page_of(path)

    assert report.verdict.level == "remarks", "the recorder counted losses"
    assert "2 publications missing from the recording" in report.verdict.wrong
    assert "0.25 mm RMS off in truth" in report.verdict.done
