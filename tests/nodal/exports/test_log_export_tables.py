"""Tables: every element has its name, every value comes back, in each of the formats."""

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodal.exports.columns import AXES, Column, joined


@pytest.fixture
def exported(nodal, recording, tmp_path):
    def export(kind, *more):
        out = tmp_path / f"out.{kind}"
        answer = nodal("log", "export", recording, "--to", kind, "-o", out, *more)
        assert (answer.status, answer.err) == (0, [])
        assert answer.out
        return out

    return export


def read(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_nodal_point_has_columns_under_its_name(exported, made):
    rows = read(exported("csv") / "shape.csv")
    assert len(rows) == made.sets - 1
    for row in rows:
        shape = made.shape_of(int(row["sequence"]))
        for name, place, covariance in zip(
            shape.node_names, shape.node_mm, shape.node_covariance_mm2, strict=True
        ):
            assert [float(row[f"node_mm.{name}.{axis}"]) for axis in AXES] == place.tolist()
            assert float(row[f"node_covariance_mm2.{name}.yy"]) == covariance[1, 1]
        for name in {"middle", "tip", "base"} - set(shape.node_names):
            assert row[f"node_mm.{name}.x"] == row[f"node_arc_mm.{name}"] == ""
        assert row["flags"] == " ".join(shape.flags)
        assert row["refusal"] == shape.refusal


def test_a_camera_has_columns_under_its_name(exported, made):
    for row in read(exported("csv") / "shape.csv"):
        shape = made.shape_of(int(row["sequence"]))
        said = [
            row[f"{field}.{name}"]
            for field in ("camera_residual_px", "visible_mm")
            for name in ("left", "right")
        ]
        assert said == (["", "", "", ""] if shape.refusal else ["0.1", "0.25", "80.0", "61.5"])
        assert (row["method"], row["known_length_mm"], row["ray_bias_mm"]) == ("refined", "80.0", "0.0")
        assert row["epipolar_angle_rad.angle1"] == ("" if shape.refusal else "1.0")


def test_times_are_in_seconds_from_the_beginning_and_in_unix_ns(exported, made):
    rows = read(exported("csv") / "shape.csv")
    for row in rows:
        number = int(row["sequence"])
        assert int(row["capture_time_ns"]) == made.capture_ns(number)
        assert float(row["capture_time_s"]) == pytest.approx(0.05 * number)
        assert int(row["log_time_ns"]) == made.start_ns + round(1e9 * float(row["log_time_s"]))
        assert int(row["log_sequence"]) == number


def test_points_pairs_and_servos_are_numbered_from_1(exported, made):
    folder = exported("csv")
    first = read(folder / "shape.csv")[0]
    assert float(first["centreline_mm.point41.z"]) == made.shape_of(0).centreline_mm[40, 2]
    assert float(first["stage_s.refine"]) == 0.006
    tendons = read(folder / "tendon_state.csv")[3]
    assert float(tendons["displacement_mm.pair1"]) == made.tendons_of(3).displacement_mm[0]
    assert float(tendons["current_ma.servo5"]) == 5
    assert tendons["torque"] == "True"


def test_a_target_is_a_row_for_each_moment_and_counts_once_in_two_parts(exported, made):
    rows = read(exported("csv") / "target.csv")
    assert [float(row["time_s"]) for row in rows] == [0, 1, 2]
    assert {(row["name"], row["weights.tip"], row["repeat"]) for row in rows} == {("rise", "1.0", "False")}
    assert [float(row["position_mm.middle.y"]) for row in rows] == made.target.position_mm[:, 1, 1].tolist()


def test_what_was_asked_and_log_lines_are_readable(exported):
    folder = exported("csv")
    (asked,) = read(folder / "asked.csv")
    assert (asked["service"], asked["request"]) == ("controller/do", '{"action": "arm"}')
    lines = read(folder / "log.csv")
    assert [(line["process"], line["level"], line["text"]) for line in lines] == [
        ("control", "2", "leaning")
    ] * 2
    (memory,) = read(folder / "controller_memory.csv")
    assert memory["content_bytes"] == "5"


def test_numpy_reads_the_same_without_pickle(exported, made):
    with np.load(exported("npz"), allow_pickle=False) as arrays:
        names = arrays["shape/node_names"].tolist()
        assert names == ["middle", "tip", "base"]
        for row, number in enumerate(arrays["shape/sequence"]):
            shape = made.shape_of(number)
            own = [names.index(name) for name in shape.node_names]
            assert np.array_equal(arrays["shape/node_mm"][row, own], shape.node_mm)
            others = np.delete(arrays["shape/node_mm"][row], own, axis=0)
            assert np.isnan(others).all()
        assert arrays["shape/centreline_mm"].shape == (made.sets - 1, 41, 3)
        assert arrays["controller/state/state"][10] == "tracking"
        assert "someone/else" not in "".join(arrays)


def test_parquet_has_the_columns_of_csv_with_nulls_for_what_is_missing(exported, made):
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra `export`")
    table = parquet.read_table(exported("parquet") / "shape.parquet")
    assert table.column_names == list(read(exported("csv") / "shape.csv")[0])
    heights = table["node_mm.base.z"].to_pylist()
    assert heights[0] is None
    assert heights[-1] == 0.0
    assert table["capture_time_ns"].to_pylist()[0] == made.start_ns


def test_only_the_topics_and_the_stretch_that_are_asked_for(exported, made):
    folder = exported("csv", "--topics", "tendon/state", "camera/left", "--from", "0.5", "--until", "1")
    assert sorted(path.name for path in folder.iterdir()) == ["camera_left.csv", "tendon_state.csv"]
    times = [float(row["log_time_s"]) for row in read(folder / "camera_left.csv")]
    assert len(times) == 10
    assert min(times) >= 0.5
    assert max(times) < 1
    (size,) = {int(row["jpeg_bytes"]) for row in read(folder / "camera_left.csv")}
    assert size == len(made.picture_of(made.rig[0]))


def test_a_stretch_may_be_named_in_utc(exported):
    folder = exported(
        "csv", "--topics", "shape", "--from", "2023-11-14T22:13:21Z", "--until", "2023-11-14T22:13:21.25"
    )
    assert [int(row["sequence"]) for row in read(folder / "shape.csv")] == [20, 21, 22, 23, 24]


@st.composite
def parts(draw):
    """A few parts of one column whose labels come and go."""
    known = draw(st.lists(st.lists(st.sampled_from("abcd"), unique=True, max_size=4), min_size=1, max_size=4))
    rows = draw(st.lists(st.integers(0, 3), min_size=len(known), max_size=len(known)))
    return [
        Column(
            name="c",
            values=100.0 * part + np.arange(count * len(labels) * 3.0).reshape(count, len(labels), 3),
            labels=(tuple(labels), AXES),
        )
        for part, (labels, count) in enumerate(zip(known, rows, strict=True))
    ]


@given(parts())
def test_joined_parts_keep_every_value_under_its_label(given_parts):
    flat = joined(given_parts).flat()
    begin = 0
    for part in given_parts:
        end = begin + len(part.values)
        own = part.flat()
        for element, values in flat.items():
            if element in own:
                assert np.array_equal(values[begin:end], own[element])
            else:
                assert np.isnan(values[begin:end]).all()
        begin = end
    assert all(len(values) == begin for values in flat.values())
