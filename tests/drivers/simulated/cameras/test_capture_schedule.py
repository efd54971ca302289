"""When pictures are taken, and where the robot was then."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.cameras.schedule import CaptureSchedule, Pose, PoseHistory
from drivers.simulated.cameras.settings import SensorSettings

MS = 1_000_000


@given(seed=st.integers(0, 1000), cameras=st.integers(1, 5))
def test_cameras_keep_their_phase_and_stray_a_little(seed: int, cameras: int) -> None:
    sensor = SensorSettings()
    schedule = CaptureSchedule(cameras, sensor, 0, seed)
    times_s = np.array([schedule.captures_ns(number) for number in range(50)]) / 1e9
    offsets_s = times_s - np.arange(50)[:, None] / sensor.rate_hz
    phases_s = offsets_s.mean(axis=0)
    assert np.ptp(phases_s) <= 2 * sensor.phase_s + 4 * sensor.jitter_s
    assert np.abs(offsets_s - phases_s).max() < 6 * sensor.jitter_s
    if cameras > 1:
        assert np.ptp(phases_s) > sensor.phase_s


def test_times_do_not_depend_on_who_asks_when() -> None:
    one, other = (CaptureSchedule(2, SensorSettings(), 5, 3) for _ in range(2))
    later = one.captures_ns(70)
    assert [one.captures_ns(n) for n in range(3)] == [other.captures_ns(n) for n in range(3)]
    assert other.captures_ns(70) == later


@given(now_ms=st.integers(-100, 10_000))
def test_the_first_capture_after_a_time_is_the_first(now_ms: int) -> None:
    schedule = CaptureSchedule(2, SensorSettings(), 0, 1)
    number = schedule.first_after(now_ms * MS)
    assert min(schedule.captures_ns(number)) > now_ms * MS
    assert number == 0 or min(schedule.captures_ns(number - 1)) <= now_ms * MS


def test_between_two_poses_the_robot_moves_evenly() -> None:
    history = PoseHistory(keep_s=0.1)
    for time_ms in range(0, 300, 8):
        history.add(Pose(time_ms * MS, np.full((3, 3), float(time_ms))))
    assert history.at(290 * MS)[0, 0] == pytest.approx(290)
    assert history.at(200 * MS)[2, 2] == pytest.approx(200)
    assert history.at(999 * MS)[0, 0] == 296
    assert history.at(0)[0, 0] == pytest.approx(196, abs=8)
