"""Targets as an operator asks for them."""

import numpy as np
import pytest

from messaging.errors import InvalidMessageError
from nodal import targets
from nodal.errors import CommandError


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
