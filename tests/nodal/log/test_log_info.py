"""What `nodal log info` tells of the golden run, in words and in JSON."""

import json
from collections import Counter
from pathlib import Path

import cv2
import pytest

from nodal.__main__ import main
from nodal.exit_status import ERROR
from recordings import Log

RUN = Path(__file__).parents[2] / "data" / "run.mcap"


@pytest.fixture
def info(capsys):
    def told(path, *words):
        status = main(["log", "info", str(path), *words])
        said = capsys.readouterr()
        return status, said.out or said.err

    return told


def test_every_topic_has_its_count_and_its_expected_rate(info):
    status, told = info(RUN, "--json")
    assert status == 0
    topics = json.loads(told)["topics"]
    assert {key: topic["count"] for key, topic in topics.items()} == Counter(
        recorded.topic for recorded in Log(RUN).messages()
    )
    # this bench's own settings, not the table of topics
    assert topics["camera/left"]["expected_hz"] == 15
    assert topics["controller/state"]["expected_hz"] == 100
    assert topics["log"]["expected_hz"] is None
    assert topics["truth"]["rate_hz"] == pytest.approx(15, rel=0.1)
    # sensing was dead for that long
    assert topics["shape"]["largest_gap_s"] > 0.5


def test_the_page_tells_what_was_asked_and_what_happened(info):
    status, told = info(RUN)
    assert status == 0
    for words in ("small", "left, right", "resolved_rate", "middle at 40 mm", "calibration.json", "numpy"):
        assert words in told
    for words in (
        "fault",
        "homing",
        "the operator asked to arm",
        "nodal points distal at 60 mm",
        "refused",
        "circle",
    ):
        assert words in told


def test_pictures_are_never_decoded(info, monkeypatch):
    def decoded(*_):
        raise AssertionError("a picture was decoded")

    monkeypatch.setattr(cv2, "imdecode", decoded)
    assert info(RUN)[0] == 0


def test_a_file_that_was_cut_off_says_so(info, tmp_path):
    log = tmp_path / "log.mcap"
    log.write_bytes(RUN.read_bytes()[:1_000_000])
    status, told = info(log)
    assert status == 0
    assert "was cut off" in told
    assert "the file was cut off in the middle of a record" in told


def test_a_cut_is_told_by_itself(info, tmp_path):
    out = tmp_path / "out.mcap"
    assert (
        main(["log", "cut", str(RUN), "-o", str(out), "--around", "fault", "--before", "1", "--after", "1"])
        == 0
    )
    status, told = info(out)
    assert status == 0
    assert "fault" in told


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda path: None, "no such recording"),
        (Path.mkdir, "no recording"),
        (lambda path: path.write_text("this is no recording at all"), "not an MCAP file"),
    ],
)
def test_what_is_no_recording_is_one_clear_line(info, tmp_path, make, problem):
    log = tmp_path / "log.mcap"
    make(log)
    status, told = info(log)
    assert status == ERROR
    assert told.startswith("nodal: error: ")
    assert told.count("\n") == 1
    assert problem in told
