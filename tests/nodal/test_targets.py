"""Targets as an operator asks for them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.planning.timing import Timing
from messaging.errors import InvalidMessageError
from nodal import targets
from nodal.errors import CommandError
from nodal.targets.pace import Pace


def test_points_are_held_with_their_weights():
    target = targets.points({"middle": [5, 0, 40], "tip": [10, 0, 75]}, {"middle": 0.25})

    assert target.node_names == ("middle", "tip")
    assert target.weights.tolist() == [0.25, 1]
    assert target.position_mm.tolist() == [[[5, 0, 40], [10, 0, 75]]]
    assert not target.repeat


def test_a_weight_for_a_point_that_is_not_there_is_refused():
    with pytest.raises(CommandError, match=r"weight given for tpi; the target's points are tip"):
        targets.points({"tip": [0, 0, 80]}, {"tpi": 1})


def test_a_circle_is_level_closed_and_repeats():
    target = targets.circle("tip", radius_mm=15, period_s=10, height_mm=70, centre_mm=(1, 2))

    places = target.position_mm[:, 0]
    assert target.repeat
    assert target.time_s[-1] == 10
    assert np.allclose(np.hypot(places[:, 0] - 1, places[:, 1] - 2), 15)
    assert np.allclose(places[:, 2], 70)
    assert np.allclose(places[0], places[-1])
    assert np.allclose(places[30], [1, 17, 70])


@pytest.mark.parametrize(
    "wrong", [{"radius_mm": np.nan}, {"period_s": 0}, {"period_s": -1}, {"height_mm": np.inf}]
)
def test_a_circle_that_nothing_could_follow_is_refused(wrong):
    asked = {"radius_mm": 15, "period_s": 10, "height_mm": 70, "centre_mm": (0, 0), **wrong}

    with pytest.raises((InvalidMessageError, CommandError)):
        targets.circle("tip", **asked)


@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: np.linalg.norm(axis) > 0.1))
def test_a_tilted_circle_goes_round_its_axis_right_handed(axis):
    places = targets.on_circle(
        np.linspace(0, 1, 9), radius_mm=5, height_mm=80, centre_mm=(1, 2), axis=tuple(axis)
    )
    normal, away = np.array(axis) / np.linalg.norm(axis), places - [1, 2, 80]
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 5)
    np.testing.assert_allclose(away @ normal, 0, atol=1e-9)
    assert (np.cross(away[:-1], away[1:]) @ normal > 0).all()
    others = np.linspace(0, 1, 100)
    farthest = targets.on_circle(others, radius_mm=5, height_mm=80, centre_mm=(1, 2), axis=tuple(axis))
    assert places[0, 0] >= farthest[:, 0].max() - 1e-3


def test_a_line_goes_from_a_stand_to_a_stand_and_back_when_it_repeats():
    once = targets.line("tip", (0, 0, 85), (10, 0, 85), Pace(duration_s=4.0))
    assert not once.repeat
    assert once.time_s[-1] == 4
    np.testing.assert_allclose(once.position_mm[[0, 60, 120], 0], [(0, 0, 85), (5, 0, 85), (10, 0, 85)])
    assert np.linalg.norm(np.diff(once.position_mm[:2, 0], axis=0)) < 1e-4
    again = targets.line("tip", (0, 0, 85), (10, 0, 85), Pace(duration_s=4.0), repeat=True)
    assert again.repeat
    assert again.time_s[-1] == 8
    np.testing.assert_allclose(again.position_mm[120:, 0], once.position_mm[::-1, 0])


@pytest.mark.parametrize(
    ("pace", "peak_mm_s", "duration_s"),
    [
        (Pace(speed_mm_s=5.0), 5.0, 1.875 * 10 / 5),
        (Pace(easy_mm_s=2.0), 2.0, 1.875 * 10 / 2),
        (Pace(duration_s=4.0, timing=Timing.TRAPEZOID), 10 / 3, 4.0),
        (Pace(speed_mm_s=5.0, acceleration_mm_s2=10.0, timing=Timing.TRAPEZOID), 5.0, 2.5),
        (Pace(speed_mm_s=50.0, acceleration_mm_s2=10.0, timing=Timing.TRAPEZOID), 10.0, 2.0),
        (Pace(duration_s=2.5, acceleration_mm_s2=10.0, timing=Timing.TRAPEZOID), 5.0, 2.5),
    ],
)
def test_a_pace_keeps_to_its_speed_its_duration_and_its_acceleration(pace, peak_mm_s, duration_s):
    time_s, share = pace.spent(10.0)
    speed = np.diff(10 * share) / np.diff(time_s)
    assert time_s[-1] == pytest.approx(duration_s)
    assert speed.max() == pytest.approx(peak_mm_s, rel=0.02)
    assert (speed >= 0).all()
    assert share[-1] == pytest.approx(1)
    if pace.acceleration_mm_s2:
        assert np.abs(np.diff(speed) / np.diff(time_s)[1:]).max() < pace.acceleration_mm_s2 * 1.01


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"duration_s": 0.0}, "a duration of 0 s is impossible"),
        ({"speed_mm_s": -3.0}, "a speed of -3 mm/s is impossible"),
        ({"speed_mm_s": np.nan}, "a speed of nan mm/s is impossible"),
        ({"duration_s": 2.0, "speed_mm_s": 3.0}, "a duration or a speed, not both"),
        ({"acceleration_mm_s2": 3.0}, "belongs to the timing trapezoid, not to minimum-jerk"),
    ],
)
def test_a_pace_that_contradicts_itself_is_refused(wrong, complaint):
    with pytest.raises(CommandError, match=complaint):
        Pace(**wrong)


def test_a_duration_that_is_too_short_for_its_acceleration_says_what_it_needs():
    pace = Pace(duration_s=2.0, acceleration_mm_s2=5.0, timing=Timing.TRAPEZOID)
    with pytest.raises(
        CommandError, match=r"10.0 mm in 2 s need an acceleration of 10.0 mm/s² at least; 5 was"
    ):
        pace.spent(10.0)


@pytest.mark.parametrize("closed", [False, True])
def test_a_spline_goes_through_its_places_smoothly(closed):
    places = [(10, 0, 85), (0, 10, 88), (-10, 0, 85), (0, -10, 82)]
    target = targets.spline("tip", places, Pace(speed_mm_s=8.0), closed=closed)
    led = target.position_mm[:, 0]
    for place in places:
        assert np.linalg.norm(led - place, axis=1).min() < 0.5
    np.testing.assert_allclose(led[0], places[0])
    np.testing.assert_allclose(led[-1], places[0] if closed else places[-1], atol=1e-9)
    assert target.repeat is closed
    speed = np.linalg.norm(np.diff(led, axis=0), axis=1) / np.diff(target.time_s)
    assert speed.max() == pytest.approx(8.0, rel=0.01)
    if closed:
        assert speed.min() == pytest.approx(8.0, rel=0.01)


@pytest.mark.parametrize(
    ("places", "complaint"),
    [
        ([(0, 0, 80), (5, 0, 80)], "three places or more, .* 2 are given$"),
        ([(0, 0, 80), (0, 0, 80), (5, 0, 80)], "two that follow one another are the same"),
    ],
)
def test_a_spline_that_goes_nowhere_is_refused(places, complaint):
    with pytest.raises(CommandError, match=complaint):
        targets.spline("tip", places, Pace())


def test_a_curve_that_cannot_be_is_refused():
    with pytest.raises(CommandError, match="axis is 0, 0, 0; it must point somewhere"):
        targets.on_circle(np.zeros(1), radius_mm=5, height_mm=80, axis=(0, 0, 0))
    with pytest.raises(CommandError, match="two ends are one place"):
        targets.line("tip", (0, 0, 80), (0, 0, 80), Pace(), repeat=True)
    with pytest.raises(CommandError, match="run through evenly"):
        Pace(acceleration_mm_s2=3.0, timing=Timing.TRAPEZOID).evenly(10.0)


def csv(tmp_path, text):
    file = tmp_path / "path.csv"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_path_is_read_from_a_file(tmp_path):
    file = csv(tmp_path, "time_s,a.x,a.y,a.z,b.x,b.y,b.z\n0,1,2,3,4,5,6\n2.5,7,8,9,10,11,12\n")

    target = targets.path(file, {"b": 0}, repeat=True)

    assert target.name == "path"
    assert target.node_names == ("a", "b")
    assert target.weights.tolist() == [1, 0]
    assert target.time_s.tolist() == [0, 2.5]
    assert target.position_mm[1].tolist() == [[7, 8, 9], [10, 11, 12]]
    assert target.repeat


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "not a CSV file with a header"),
        ("time,a.x,a.y,a.z\n0,1,2,3\n", "columns are time, a.x, a.y, a.z"),
        ("time_s,a.x,a.z,a.y\n0,1,2,3\n", "columns are"),
        ("time_s\n0\n", "columns are time_s;"),
        ("time_s,a.x,a.y,a.z\n0,1,2\n", "line 2 has 3 values; the header names 4"),
        ("time_s,a.x,a.y,a.z\n0,1,two,3\n", "line 2: a.y is 'two', which is not a number"),
    ],
)
def test_a_path_file_is_refused_by_line_and_column(tmp_path, text, complaint):
    with pytest.raises(CommandError, match=complaint):
        targets.path(csv(tmp_path, text), {}, repeat=False)


@pytest.mark.parametrize("rows", ["", "1,1,2,3\n", "0,1,2,3\n0,1,2,3\n", "0,1,nan,3\n"])
def test_a_path_that_nothing_could_follow_is_refused(tmp_path, rows):
    with pytest.raises(InvalidMessageError):
        targets.path(csv(tmp_path, "time_s,a.x,a.y,a.z\n" + rows), {}, repeat=False)


def test_a_missing_path_file_is_named(tmp_path):
    with pytest.raises(CommandError, match=r"none.csv: cannot be read"):
        targets.path(tmp_path / "none.csv", {}, repeat=False)
