"""Where the stage was when a frame was taken."""

import numpy as np
import pytest

from messaging.control import TendonState
from sensing.stage_height import StageHeight

SECOND_NS = 1_000_000_000
NOW_NS = 1_780_000_000 * SECOND_NS


def report(after_s, insertion_mm):
    return TendonState(
        time_ns=NOW_NS + round(after_s * SECOND_NS),
        displacement_mm=np.zeros(4),
        displacement_mm_s=np.zeros(4),
        insertion_mm=insertion_mm,
        insertion_mm_s=0.0,
        current_ma=np.zeros(5),
        temperature_c=np.zeros(5),
        voltage_v=np.zeros(5),
        hardware_error=np.zeros(5),
        torque=True,
    )


def heights(*reports):
    stage = StageHeight(age_limit_s=0.5)
    for after_s, insertion_mm in reports:
        stage.heard(report(after_s, insertion_mm))
    return lambda after_s: stage.at(NOW_NS + round(after_s * SECOND_NS))


def test_without_reports_the_base_is_at_zero_and_unknown():
    assert heights()(0.0) == (0.0, False)


def test_between_two_reports_the_height_is_interpolated_in_mm():
    at = heights((0.0, 10.0), (0.1, 14.0))
    assert at(0.025) == (pytest.approx(11.0), True)
    assert at(0.1) == (pytest.approx(14.0), True)


def test_a_frame_a_little_later_than_the_last_report_uses_it():
    at = heights((0.0, 10.0), (0.1, 14.0))
    assert at(0.59) == (14.0, True)


def test_a_stale_report_is_used_but_not_trusted():
    at = heights((0.0, 10.0), (0.1, 14.0))
    assert at(0.61) == (14.0, False)


def test_a_frame_from_before_the_first_report_is_not_trusted_when_far():
    at = heights((0.0, 10.0), (0.1, 14.0))
    assert at(-5.0) == (10.0, False)


def test_a_clock_set_back_starts_anew():
    at = heights((100.0, 30.0), (0.0, 10.0))
    assert at(0.0) == (10.0, True)
    assert at(100.0) == (10.0, False)


def test_nanoseconds_of_unix_time_are_not_lost_in_floats():
    at = heights((0.0, 0.0), (1e-6, 10.0))
    height, _ = at(0.5e-6)
    assert height == pytest.approx(5.0, abs=0.1)
