"""`nodal target`: what it says, what it sends, and how it waits, against a controller and a camera that stand in."""

import contextlib
import dataclasses
import socket
import threading
import time

import numpy as np
import pytest

from controller.planning.space import Space
from controller.plant import Plant
from messaging.control import ControllerState, Reply, State, Target
from messaging.session import open_rendezvous, open_session
from messaging.shape import ShapeEstimate
from messaging.topics import CONTROLLER_STATE, CONTROLLER_TARGET, SHAPE
from nodal.__main__ import main
from nodal.bench_file import bench_path, load_bench
from nodal.targets.following import Following
from nodal.targets.present import Present
from nodal.toml_file import read_table, written

NAMES, ARCS = ("proximal", "middle", "distal", "tip"), (20.0, 40.0, 60.0, 80.0)
LAMP = {"kind": "sphere", "name": "lamp", "centre_mm": [22.0, 0.0, 62.0], "radius_mm": 6.0}
BEHIND_THE_LAMP = "tip=35,0,60"
STATE = ControllerState(
    time_ns=1,
    state=State.TRACKING,
    reason="because",
    target_name="point",
    node_names=("tip",),
    desired_mm=[[1, 2, 83]],
    measured_mm=[[0, 0, 80]],
    tracking_error_mm=0.25,
    shape_sequence=1,
    shape_age_s=0.01,
    lateness_s=0.0,
    busy_s=0.001,
    overruns=0,
    now_s=1.0,
    dt_s=0.005,
    sighted_capture_ns=0,
    sighted_age_s=0.0,
    drive_absence="",
    commanded=True,
)


@pytest.fixture
def bench_file(tmp_path):
    """The simulated bench with a lamp in it, on a bus of its own."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    table = read_table(bench_path("simulated"))
    table["calibration"] = str(bench_path("simulated").with_name("simulated-rig.json"))
    table["zenoh"] = {"rendezvous": f"tcp/127.0.0.1:{port}"}
    table["controller"] = {"forbidden": [LAMP]}
    file = tmp_path / "bench.toml"
    file.write_text(written(table), encoding="utf-8")
    return str(file)


def space_of(bench_file):
    bench = load_bench(bench_file).settings
    return bench, Space(Plant.of(bench.controller, bench.robot))


def shape_of(space, configuration, **changes):
    arcs = np.linspace(0, 80, 33)
    centreline, _ = space.nodes_and_jacobian(configuration, arcs)
    nodes, _ = space.nodes_and_jacobian(configuration, np.array(ARCS))
    shape = ShapeEstimate(
        sequence=1,
        capture_time_ns=1,
        capture_to_publish_ns=1,
        refusal="",
        method="refined",
        flags=(),
        arc_mm=arcs,
        centreline_mm=centreline,
        epipolar_angle_rad=np.ones(33),
        node_names=NAMES,
        node_arc_mm=ARCS,
        node_mm=nodes,
        node_covariance_mm2=np.zeros((4, 3, 3)),
        length_mm=80.0,
        known_length_mm=80.0,
        insertion_mm=float(configuration[-1]),
        ray_gap_mm=0.0,
        ray_bias_mm=0.0,
        residual_px=0.0,
        camera_names=(),
        camera_residual_px=[],
        visible_mm=[],
        stage_names=(),
        stage_s=[],
    )
    return dataclasses.replace(shape, **changes)


@contextlib.contextmanager
def standing_in(bench_file, shape, states=(), *, accepted=True):
    """Says this shape again and again, and these states in turn once a target has come; yields the targets that came."""
    bench, _ = space_of(bench_file)
    came: list[Target] = []
    end = threading.Event()

    def live():
        coming = iter(states)
        with (
            open_rendezvous(bench.zenoh, bench.name),
            open_session(bench.zenoh, bench.name, "control") as session,
        ):
            shapes, said = session.publisher(SHAPE), session.publisher(CONTROLLER_STATE)
            answers = session.answers(CONTROLLER_TARGET)
            state = None
            while not end.wait(0.02):
                shapes.put(shape)
                if (query := answers.take()) is not None:
                    came.append(query.request())
                    query.reply(Reply(accepted=accepted, state="tracking", reason="as it is"))
                if came:
                    state = next(coming, state)
                if state is not None:
                    said.put(state)

    thread = threading.Thread(target=live)
    thread.start()
    try:
        yield came
    finally:
        end.set()
        thread.join()


def target(bench_file, *words):
    return main(["target", "--config", bench_file, *words])


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["point", "tip=10,0,75"], 0, "can be reached from the straight robot; nothing was moved"),
        (["point", BEHIND_THE_LAMP], 0, "leads to its beginning, around regions"),
        (
            ["point", BEHIND_THE_LAMP, "--no-plan"],
            3,
            "on the straight way to its beginning the robot would be",
        ),
        (["point", "tip=22,0,70"], 3, "2.0 mm from region lamp 80 mm along its body"),
        (["point", "tip=90,0,75"], 3, "it lies 80.0 mm along the robot"),
        (
            ["circle", "tip", "--radius", "10", "--height", "85", "--axis", "-1,0,4"],
            0,
            "of which the last 10.0 s",
        ),
        (["circle", "tip", "--height", "85", "--period", "3"], 3, "at most 20 mm/s are allowed"),
        (["line", "tip", "-10,0,85", "10,0,85"], 0, "moves at 10.0 of 20 mm/s"),
        (["line", "tip", "-10,0,85", "10,0,85", "--duration", "1"], 3, "moves at 37.5 mm/s"),
        (["spline", "tip", "-10,0,85", "-5,5,87", "10,0,85", "--timing", "trapezoid"], 0, "moves at 10.0"),
        (["jog", "tip", "-5,0,0"], 0, "target jog can be reached"),
        (["jog", "elbow", "5,0,0"], 2, "no nodal point elbow; known are proximal, middle, distal, tip"),
    ],
)
def test_a_check_answers_by_the_bench_file_alone(bench_file, capsys, words, status, said):
    assert target(bench_file, *words, "--check") == status
    shown = capsys.readouterr()
    assert said in (shown.out if status == 0 else shown.err)


def test_what_is_ours_to_time_is_slowed_down_and_what_is_not_is_refused(tmp_path, bench_file, capsys):
    table = read_table(bench_path(bench_file))
    table["controller"]["limits"] = {"displacement_mm_s": 0.5}
    slow = tmp_path / "slow.toml"
    slow.write_text(written(table), encoding="utf-8")
    words = ["line", "tip", "-10,0,85", "10,0,85"]
    assert target(str(slow), *words, "--check") == 0
    assert "slowed down 1." in capsys.readouterr().out
    assert target(str(slow), *words, "--check", "--speed", "10") == 3
    assert "at most 0.5 mm/s are allowed, so it must take 1." in capsys.readouterr().err


def test_a_way_round_is_planned_where_it_must_be_and_where_it_is_asked_for(bench_file, capsys):
    _, space = space_of(bench_file)
    with standing_in(bench_file, shape_of(space, space.straight(5.0))) as came:
        assert target(bench_file, "point", "tip=-10,0,80") == 0
        assert target(bench_file, "point", "tip=-10,0,80", "--plan") == 0
        assert target(bench_file, "point", BEHIND_THE_LAMP) == 0
    plain, asked, around = came
    assert len(plain.time_s) == 1
    assert plain.node_names == ("tip",)
    for planned in (asked, around):
        assert len(planned.time_s) > 10
        assert set(planned.node_names) == set(NAMES)
        np.testing.assert_allclose(planned.position_mm[0, 0], [0, 0, 85], atol=0.1)
    np.testing.assert_allclose(around.position_mm[-1, 0], [35, 0, 60])
    assert "from the present shape leads to its beginning" in capsys.readouterr().out


def test_a_planned_way_does_not_pretend_to_keep_an_acceleration(bench_file, capsys):
    pace = ["--timing", "trapezoid", "--acceleration", "20", "--check"]
    line = ["line", "tip", "-10,0,85", "10,0,85", *pace]
    assert target(bench_file, *line) == 0
    assert target(bench_file, *line, "--plan") == 2
    assert (
        "does not keep to an acceleration of 20 mm/s²; go to its beginning first" in capsys.readouterr().err
    )
    behind = ["line", "tip", "35,0,60", "35,5,60", *pace]
    assert target(bench_file, *behind) == 2
    assert "does not keep to an acceleration" in capsys.readouterr().err


def test_a_jog_begins_where_the_point_is_led_or_seen(bench_file):
    _, space = space_of(bench_file)
    shape = shape_of(space, space.straight(5.0))
    led = Present.of(shape, STATE, space)
    np.testing.assert_allclose(led.node_mm["tip"], [1, 2, 83])
    np.testing.assert_allclose(led.node_mm["middle"], [0, 0, 45])
    seen = Present.of(shape, dataclasses.replace(STATE, state=State.HOLD), space)
    np.testing.assert_allclose(seen.node_mm["tip"], [0, 0, 85])
    with standing_in(bench_file, shape) as came:
        assert target(bench_file, "jog", "tip", "-5,0,-1", "--duration", "2") == 0
    np.testing.assert_allclose(came[0].position_mm[[0, -1], 0], [(0, 0, 85), (-5, 0, 84)], atol=1e-9)
    assert came[0].time_s[-1] == 2


def test_waiting_ends_when_the_target_has_arrived(bench_file, capsys):
    _, space = space_of(bench_file)
    states = [dataclasses.replace(STATE, progress=p) for p in (0.0, 0.0, 0.0, 0.3, 0.6, 1.0)]
    with standing_in(bench_file, shape_of(space, space.straight(5.0)), states):
        assert target(bench_file, "point", "tip=-10,0,80", "--wait") == 0
    assert "target point arrived" in capsys.readouterr().out


def test_waiting_ends_with_a_fault_and_for_want_of_a_controller(bench_file, capsys):
    _, space = space_of(bench_file)
    shape = shape_of(space, space.straight(5.0))
    fault = dataclasses.replace(STATE, state=State.FAULT, target_name="", reason="servo 3 is hot")
    with standing_in(bench_file, shape, [STATE, STATE, fault]):
        assert target(bench_file, "point", "tip=-10,0,80", "--wait") == 3
    assert "target point did not arrive: fault: servo 3 is hot" in capsys.readouterr().err
    with standing_in(bench_file, shape):
        assert (
            main(["target", "--config", bench_file, "--timeout", "0.5", "point", "tip=-10,0,80", "--wait"])
            == 3
        )
        assert "the controller has said nothing for 0.5 s" in capsys.readouterr().err
        assert target(bench_file, "circle", "tip", "--height", "90", "--wait") == 2
        assert "repeats for ever; --wait would never end" in capsys.readouterr().err


def test_a_refusal_and_an_untrusted_shape_are_told(bench_file, capsys):
    _, space = space_of(bench_file)
    shape = shape_of(space, space.straight(5.0))
    with standing_in(bench_file, shape, accepted=False):
        assert target(bench_file, "point", "tip=-10,0,80", "--wait") == 3
    assert "refused: as it is" in capsys.readouterr().err
    with standing_in(bench_file, dataclasses.replace(shape, flags=("hidden",))):
        assert main(["target", "--config", bench_file, "--timeout", "0.5", "point", "tip=-10,0,80"]) == 2
    assert "no trusted shape within 0.5 s: the newest is flagged hidden" in capsys.readouterr().err


def told(following, **changes):
    return following.turn(dataclasses.replace(STATE, **changes), time.monotonic())


def test_what_ends_a_target_is_told_apart_from_what_does_not():
    following = Following(target_name="point", silence_s=1.0)
    assert told(following, state=State.READY, target_name="") is None, "it waits to be armed"
    assert told(following, progress=0.5) is None
    assert told(following, state=State.HOLD, target_name="", progress=0.5) is None, "it goes on after a hold"
    assert told(following, state=State.HOLD, target_name="", progress=0.0) == "hold: because", "an abort"
    assert told(following, target_name="circle") == "target circle took its place"
    assert told(following, state=State.IDLE, target_name="") == "idle: because"
    assert told(following, state=State.FAULT, target_name="") == "fault: because"
    assert told(following, progress=1.0) == ""
    assert not following.silent(time.monotonic())
    assert following.silent(time.monotonic() + 2.0)
