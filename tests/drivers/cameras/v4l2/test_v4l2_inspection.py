"""Which pictures are good; pure."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cameras.v4l2.inspection import (
    REPORT_S,
    FaultReport,
    Inspection,
    PictureFault,
    is_complete_jpeg,
)
from drivers.cameras.v4l2.stream import Captured


def captured(sequence: int, time_ns: int, body: bytes = b"") -> Captured:
    return Captured(
        jpeg=b"\xff\xd8" + (body or str(time_ns).encode()) + b"\xff\xd9",
        capture_monotonic_ns=time_ns,
        sequence=sequence,
        is_damaged=False,
    )


@given(st.lists(st.integers(1, 50), min_size=1), st.integers(0, 2**32 - 1))
def test_numbers_and_counted_losses_agree_over_the_end_of_the_sequence(steps, first):
    inspection = Inspection()
    assert inspection.number_of(captured(first, 1)) == 0
    position = 0
    for index, step in enumerate(steps):
        position += step
        assert inspection.number_of(captured((first + position) % 2**32, index + 2)) == position
    assert inspection.faults[PictureFault.LOST] == position - len(steps)


@pytest.mark.parametrize("sequence", [0, 7])
def test_a_sequence_that_stands_still_or_begins_anew_counts_on(sequence):
    inspection = Inspection()
    inspection.number_of(captured(7, 1))
    assert inspection.number_of(captured(sequence, 2)) == 1
    assert not inspection.faults


def test_a_new_stream_may_begin_with_an_older_time_and_the_same_picture():
    inspection = Inspection()
    inspection.number_of(captured(5, 100, b"same"))
    assert inspection.number_of(captured(6, 101, b"same")) is None
    assert inspection.since_good == {PictureFault.REPEATED}
    inspection.begin()
    assert inspection.number_of(captured(0, 50, b"same")) == 2
    assert not inspection.since_good


def test_faults_are_said_at_once_and_then_once_a_period():
    inspection = Inspection()
    report = FaultReport(inspection.faults)
    assert report.due(0.0) is None
    inspection.faults[PictureFault.LOST] += 2
    assert report.due(1.0) == "pictures left out: 2 lost on the way"
    inspection.faults[PictureFault.INCOMPLETE] += 1
    assert report.due(REPORT_S) is None
    assert report.due(REPORT_S + 1.0) == "pictures left out: 1 no complete JPEG"
    assert report.due(3 * REPORT_S) is None


@given(st.data())
def test_a_jpeg_that_is_cut_anywhere_is_not_complete(pictures, data):
    jpeg = pictures[0]
    assert is_complete_jpeg(jpeg)
    assert is_complete_jpeg(jpeg + bytes(10))
    assert not is_complete_jpeg(jpeg[: data.draw(st.integers(0, len(jpeg) - 1))])
    assert not is_complete_jpeg(jpeg + b"more")
