"""Figures for a paper: what the recording holds is drawn, what it lacks is said."""

import pytest

from messaging.control import ControllerState
from messaging.shape import ShapeEstimate
from nodal.exports.plots.figures import figures
from nodal.report.findings import Findings
from nodal.report.loading import load_run
from recordings import Log
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

EVERY = {
    "nodal-points",
    "tracking-error",
    "estimate-error",
    "tendons",
    "latency",
    "loop",
    "quality",
    "path",
}


@pytest.fixture(scope="module")
def only(recording, tmp_path_factory):
    """A recording of some of the run's topics."""

    def keep(*keys):
        path = tmp_path_factory.mktemp("only") / "only.mcap"
        kinds = {"shape": ShapeEstimate, "controller/state": ControllerState}
        with RecordingWriter(path, RecorderSettings()) as writer:
            for one in Log(recording).messages():
                if one.topic in keys:
                    writer.write(
                        one.topic,
                        kinds[one.topic].protobuf,
                        one.payload,
                        sequence=one.sequence,
                        publish_time_ns=one.publish_time_ns,
                        log_time_ns=one.log_time_ns,
                    )
        return path

    return keep


@pytest.fixture
def plotted(nodal, tmp_path):
    pytest.importorskip("matplotlib", reason="needs the extra `plots`")

    def plot(path, *formats):
        answer = nodal("log", "plot", path, "-o", tmp_path / "plots", "--format", *formats)
        assert answer.status == 0
        return {file.name for file in (tmp_path / "plots").iterdir()}, answer

    return plot


def test_every_figure_of_a_whole_run_in_each_format(plotted, recording, tmp_path):
    files, answer = plotted(recording, "pdf", "svg")
    assert files == {f"{name}.{kind}" for name in EVERY for kind in ("pdf", "svg")}
    assert answer.err == []
    assert (tmp_path / "plots" / "path.pdf").read_bytes().startswith(b"%PDF")
    assert b"CreationDate" not in (tmp_path / "plots" / "path.pdf").read_bytes()


def test_sensing_alone_leaves_the_other_figures_out_and_says_so(plotted, only):
    files, answer = plotted(only("shape"), "svg")
    assert files == {"nodal-points.svg", "quality.svg", "latency.svg"}
    for name in EVERY - {"nodal-points", "quality", "latency"}:
        assert any(f"no figure {name}:" in line for line in answer.err)


def test_without_a_truth_the_path_is_the_measured_one(plotted, only):
    files, answer = plotted(only("shape", "controller/state"), "svg")
    assert {"path.svg", "tracking-error.svg", "loop.svg"} <= files
    assert "estimate-error.svg" not in files
    assert [line for line in answer.err if "estimate-error" in line]


def test_a_recording_without_anything_to_draw_is_refused(nodal, only, tmp_path):
    answer = nodal("log", "plot", only("nothing"), "-o", tmp_path / "plots")
    assert answer.status == 2
    assert not (tmp_path / "plots").exists()


def test_nodal_points_over_time_are_those_of_the_estimates(recording, made):
    figure = next(one for one in figures(Findings(load_run(Log(recording)))) if one.name == "nodal-points")
    height = figure.rows[2][0]
    series = {one.label: one for one in height.series if one.label}
    assert set(series) == {"middle", "tip", "base", "target"}
    x, y = series["tip"].x, series["tip"].y
    assert dict(zip(x.round(3).tolist(), y.tolist(), strict=True))[0.5] == made.shape_of(10).node_mm[1, 2]
    asked = dict(zip(series["target"].x.round(3).tolist(), series["target"].y.tolist(), strict=True))
    assert asked[0.5] == made.desired_of(10)[0, 2]


def test_folders_are_not_overwritten(nodal, recording, tmp_path):
    assert nodal("log", "plot", recording, "-o", tmp_path).status == 2
