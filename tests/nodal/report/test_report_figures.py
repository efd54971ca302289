"""A report's figures, on a run made up so that each of them is known."""

import dataclasses

import msgspec
import numpy as np
import pytest

from controller.settings import ControllerSettings
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.robot.settings import SimulatedRobotSettings, ideal
from messaging.settings import RobotSettings
from messaging.shape import Flag
from nodal import targets
from nodal.errors import ReportError
from nodal.report.bench_run import Accepted, BenchRun, FrameSets
from nodal.report.figures.sensing import sensing
from nodal.report.findings import Findings
from nodal.report.open_loop import open_loop_path, solved
from nodal.report.run_charts import run_charts
from nodal.report.summary import CIRCLE, HOLD, summary_of
from nodal.report.tracking import true_tracking_of
from nodal.report.truth import TrueShapes

SETS = 60


@pytest.fixture
def run(said):
    """Estimates 0.2 mm off; the tip 0.5 mm off on the circle, 1 mm off while a hold settles and 0.1 mm off after."""
    times = [said.START_NS + index * said.PERIOD_NS for index in range(SETS)]
    frames = FrameSets()
    for index in range(SETS):
        frames.hear("left", index)
        frames.hear("right", index)
    circle = dataclasses.replace(
        targets.circle("tip", radius_mm=15, period_s=10, height_mm=85, centre_mm=(0, 0)), name=CIRCLE
    )
    hold = dataclasses.replace(targets.points({"tip": [15, 0, 85]}, {}), name=HOLD)
    return BenchRun(
        rig=default_cameras(),
        losses=3,
        frames=frames,
        shapes=[said.shape(index, time, 0.2) for index, time in enumerate(times)],
        truths=[
            said.truth_at(time)
            for time in range(said.START_NS - said.PERIOD_NS, times[-1] + said.PERIOD_NS, 20_000_000)
        ],
        states=[
            *(said.state(index, times[index], 0.5) for index in range(20)),
            *(said.state(index, times[index], 1.0, HOLD) for index in range(20, 39)),
            *(said.state(index, times[index], 0.1, HOLD) for index in range(40, 60)),
        ],
        commands=[said.command(age) for age in (-1, 10_000_000, -1, 20_000_000)],
        accepted=[Accepted(time_ns=said.START_NS, target=target) for target in (circle, hold)],
    )


def test_the_figures_of_a_run(run):
    summary = msgspec.to_builtins(summary_of(run, "demo.mcap", 6.0))

    assert summary == {
        "frame_sets": 60,
        "estimates": 60,
        "estimate_rate_hz": pytest.approx(30, abs=0.01),
        "flagged": 0,
        "node_error_mm": {"mean": 0.2, "p95": 0.2, "max": 0.2},
        "tip_error_mm": {"mean": 0.2, "p95": 0.2, "max": 0.2},
        "tracking_error_mm": {"rms": 0.5, "steady": 0.1},
        "open_loop_error_mm": {"rms": 6.0},
        "capture_to_command_ms": {"p50": 15.0, "p99": pytest.approx(19.9)},
        "control_lateness_ms": {"p50": 2.0, "p99": 2.0},
        "recording": "demo.mcap",
        "recording_losses": 3,
    }


def test_refused_estimates_do_not_count_and_flagged_ones_do(run, said):
    run.shapes[7] = said.refused(7, run.shapes[7].capture_time_ns, "camera left: no robot")
    run.shapes[9] = said.shape(9, run.shapes[9].capture_time_ns, 5.0, flags=(Flag.LARGE_RESIDUAL.value,))

    summary = summary_of(run, "demo.mcap", None)

    assert summary.frame_sets == 60
    assert summary.estimates == 59
    assert summary.flagged == 1
    assert summary.node_error_mm.max == 5.0
    assert summary.open_loop_error_mm.rms is None


def test_a_run_without_tracking_has_no_tracking_figures(run):
    run.states.clear()
    run.commands.clear()
    run.accepted.clear()

    summary = summary_of(run, "demo.mcap", None)

    assert summary.tracking_error_mm.rms is None
    assert summary.tracking_error_mm.steady is None
    assert summary.capture_to_command_ms.p50 is None
    assert summary.control_lateness_ms.p99 is None


def test_a_run_without_estimates_has_no_errors(run):
    run.shapes.clear()
    run.states.clear()
    run.accepted.clear()

    summary = summary_of(run, "demo.mcap", None)

    assert summary.estimates == 0
    assert summary.estimate_rate_hz is None
    assert summary.node_error_mm.mean is None


def test_a_run_without_truth_is_refused(run):
    run.truths.clear()

    with pytest.raises(ReportError, match="holds 0 true shapes"):
        summary_of(run, "demo.mcap", None)


def test_only_weighted_points_are_judged(run, said):
    target = dataclasses.replace(
        targets.points({"middle": [0, 0, 40], "tip": [0, 0, 80]}, {"middle": 0}), name=CIRCLE
    )
    run.accepted[:] = [Accepted(time_ns=said.START_NS, target=target)]
    run.states[:] = [
        dataclasses.replace(
            one,
            node_names=("middle", "tip"),
            desired_mm=np.vstack([np.zeros(3), one.desired_mm]),
            measured_mm=np.vstack([np.zeros(3), one.measured_mm]),
        )
        for one in run.states
    ]

    tracking = true_tracking_of(run, TrueShapes(run.truths), CIRCLE)

    assert tracking.names == ("tip",)
    assert tracking.rms_mm() == pytest.approx(0.5)


def test_numbers_that_begin_anew_are_told_apart_by_their_time(run, said):
    again = run.shapes[-1].capture_time_ns + said.PERIOD_NS
    run.shapes.append(said.shape(0, again))
    run.truths.append(said.truth_at(again + said.PERIOD_NS))

    assert run.shape_seen(0, said.START_NS + said.PERIOD_NS).capture_time_ns == said.START_NS
    assert run.shape_seen(0, again + 1).capture_time_ns == again
    assert run.shape_seen(0, said.START_NS - 1) is None


def test_the_truth_is_interpolated_but_not_over_gaps(run, said):
    truth = TrueShapes(
        [
            said.truth_at(said.START_NS),
            said.truth_at(said.START_NS + 100_000_000),
            said.truth_at(said.START_NS + 900_000_000),
        ]
    )
    times = said.START_NS + np.array([-1, 50_000_000, 500_000_000, 1_000_000_000])

    assert truth.covers(times).tolist() == [False, True, False, False]
    assert truth.points_mm(times[1:2], np.array([12.5, 80.0])) == pytest.approx(
        np.array([[[0.5, 0, 12.5], [0.5, 0, 80]]])
    )


def test_frame_sets_are_complete_or_do_not_count():
    frames = FrameSets()
    for camera, sequence in (("left", 0), ("right", 0), ("left", 1), ("left", 2), ("right", 2)):
        frames.hear(camera, sequence)

    assert frames.complete() == 2


def test_frame_sets_of_a_restarted_sensing_count_apart():
    frames = FrameSets()
    for _ in range(2):
        for sequence in range(5):
            frames.hear("left", sequence)
            frames.hear("right", sequence)

    assert frames.complete() == 10


@pytest.fixture
def kinematics():
    return ControllerSettings().kinematics(RobotSettings(section_length_mm=(40.0, 40.0)))


def test_the_model_is_solved_for_a_place(kinematics):
    arc, place = np.array([80.0]), np.array([[12.0, -5.0, 82.0]])

    command = solved(kinematics, arc, place, np.zeros(kinematics.axes))

    assert kinematics.nodes_mm(command, arc) == pytest.approx(place, abs=2e-3)


@pytest.mark.parametrize(
    ("build", "low_mm", "high_mm"), [(ideal, 0.0, 1.5), (lambda build: build, 2.0, 20.0)]
)
def test_open_loop_misses_a_real_robot_and_hardly_an_ideal_one(kinematics, build, low_mm, high_mm):
    time_s = np.linspace(0, 5, 50)
    desired = targets.on_circle(time_s / 10, radius_mm=15, height_mm=85)[:, None]

    reached = open_loop_path(desired, time_s, np.array([80.0]), kinematics, build(SimulatedRobotSettings()))

    rms_mm = np.sqrt(((reached - desired) ** 2).sum(axis=-1).mean())
    assert low_mm <= rms_mm <= high_mm


@pytest.fixture
def told(run, said):
    """The same run with what each camera told; every other claim is too bold by half, and one frame set lost a camera."""
    for index, shape in enumerate(run.shapes):
        sigma_mm = 0.1 if index % 2 else 0.05
        names = ("left", "right") if index != 3 else ("left",)
        run.shapes[index] = dataclasses.replace(
            shape,
            node_covariance_mm2=np.tile(sigma_mm**2 * np.eye(3), (2, 1, 1)),
            epipolar_angle_rad=np.radians(np.linspace(80, 20 + index, len(shape.arc_mm))),
            known_length_mm=79.5,
            ray_bias_mm=-0.01,
            camera_names=names,
            camera_residual_px=np.array([0.1, 0.3])[: len(names)],
            visible_mm=np.array([78.0, 60.0])[: len(names)],
            flags=(Flag.HIDDEN.value,) if index in (4, 5) else (),
        )
    return Findings(run)


def values(chapters, chapter, group):
    [found] = [
        one for known in chapters if known.key == chapter for one in known.groups if one.title == group
    ]
    return {figure.key: figure.value for figure in found.figures}


def test_what_sensing_knows_about_itself(told):
    chapters = sensing(told)

    assert values(chapters, "truth", "all nodal points")["inside_percent"] == pytest.approx(50)
    assert values(chapters, "truth", "nodal point tip")["inside_percent"] == pytest.approx(50)
    assert values(chapters, "quality", "smallest epipolar angle") == pytest.approx(
        {"min_deg": 20.0, "mean_deg": 49.5, "max_deg": 79.0}
    )
    assert values(chapters, "quality", "measured length less the known one")["mean_mm"] == pytest.approx(0.5)
    assert values(chapters, "quality", "bias of the ray gap")["mean_mm"] == pytest.approx(-0.01)
    assert values(chapters, "cameras", "camera left") == {
        "estimates": 60,
        "residual_mean_px": 0.1,
        "residual_p95_px": 0.1,
        "visible_mean_mm": 78.0,
        "visible_min_mm": 78.0,
    }
    assert values(chapters, "cameras", "camera right")["estimates"] == 59


def test_charts_show_each_camera_and_each_flag(told):
    charts = {chart.key: chart for chapter in run_charts(told).values() for chart in chapter}

    assert [series.label for series in charts["camera-residual"].series] == ["left", "right"]
    assert np.isnan(charts["visible"].series[1].y[3])
    assert charts["flags"].rows == ("hidden",)
    assert len(charts["flags"].series[0].x) == 2
    assert [series.label for series in charts["length"].series] == ["measured", "known"]
    assert [series.label for series in charts["ray-gap"].series] == ["mean", "bias"]
    assert charts["epipolar"].series[0].y[:2] == pytest.approx([20, 21])
