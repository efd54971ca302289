"""The log says how far frames lie apart, and when they find no partner."""

import logging

import pytest

from drivers.cameras import CameraFrame, FrameSetPairing, PairingReport
from drivers.cameras.pairing_report import FIRST_S, PERIOD_S

MS = 1_000_000
PERIOD_NS = 33 * MS


@pytest.fixture
def bench(caplog):
    caplog.set_level(logging.INFO)
    pairing = FrameSetPairing(("a", "b"), 0.012)
    return pairing, PairingReport(pairing, 0.0)


def run(bench, moments, apart_ns, only="ab"):
    pairing, report = bench
    for moment in moments:
        for name in only:
            time_ns = moment * PERIOD_NS + (apart_ns if name == "b" else 0)
            frame = CameraFrame(name=name, jpeg=b"", capture_monotonic_ns=time_ns, number=moment)
            if (frame_set := pairing.feed(frame)) is not None:
                report.add(frame_set)


def test_the_skew_is_said_once_when_all_find_partners(bench, caplog):
    run(bench, range(5), 3 * MS)
    run(bench, range(5, 10), 5 * MS)
    for now_s in (1.0, FIRST_S, FIRST_S + PERIOD_S):
        bench[1].tell(now_s)
    assert caplog.messages == [
        "10 frame sets, their frames 4.0 ms apart on average, 5.0 ms at most (12 ms are allowed)"
    ]


def test_frames_from_before_the_first_set_are_no_loss(bench, caplog):
    run(bench, range(20), 0, only="a")
    run(bench, range(20, 30), 0)
    bench[1].tell(FIRST_S)
    assert "without a partner" not in caplog.text


def test_frames_without_a_partner_are_counted_each_minute(bench, caplog):
    run(bench, range(10), MS)
    bench[1].tell(FIRST_S)
    caplog.clear()
    run(bench, range(10, 13), 0, only="a")
    run(bench, range(13, 20), 2 * MS)
    bench[1].tell(FIRST_S + PERIOD_S - 1)
    assert caplog.messages == []
    bench[1].tell(FIRST_S + PERIOD_S)
    (message,) = caplog.messages
    assert message.startswith("7 frame sets, their frames 2.0 ms apart on average, 2.0 ms at most")
    assert message.endswith("; frames without a partner: 3 of a")
    assert caplog.records[0].levelno == logging.WARNING


def test_cameras_that_never_meet_are_said_to(bench, caplog):
    run(bench, range(40), 16 * MS)
    bench[1].tell(FIRST_S)
    assert (
        "no frame set, for the cameras' frames lie too far apart (12 ms are allowed): let sensing.maximum_skew_s be 50 %"
        in caplog.text
    )
