"""`nodal calibrate robot` as a whole, on a bench in virtual time: what it begins with, what it writes, and how it ends."""

import shutil
import threading
import tomllib
from contextlib import contextmanager

import numpy as np
import pytest

from calibration.robot_plan import Plan
from drivers.simulated.robot.settings import SectionSettings, SimulatedRobotSettings
from nodal.__main__ import main
from nodal.bench_file import bench_path, read_bench
from nodal.calibrate.robot import calibrating
from nodal.toml_file import read_table, written
from nodal.virtual.bench import VirtualBench
from nodal.virtual.hand import VirtualHand
from nodal.virtual.settings import ServoSettings, ShapeSettings, VirtualBenchSettings

TRUE = VirtualBenchSettings(
    robot=SimulatedRobotSettings(centreline_points=21, sections=(SectionSettings(),)),
    shape=ShapeSettings(node_names=("middle", "tip"), node_arc_mm=(20.0, 40.0)),
    servos=ServoSettings(gain=(1.1, 0.8, 1.03)),
)


class Lab:
    """A bench of one section whose processes are this test: every controller that is started anew is a virtual bench, with its
    pulleys wound as `wound` says.
    """

    def __init__(self, folder):
        self.path = folder / "bench.toml"
        table = read_table(bench_path("simulated"))
        shutil.copy(bench_path("simulated").with_name(table["calibration"]), folder / "rig.json")
        table |= {"calibration": "rig.json", "robot": {"section_length_mm": [40.0]}}
        table["sensing"]["nodal_points"] = [
            {"name": "middle", "arc_mm": 20.0},
            {"name": "tip", "arc_mm": 40.0},
        ]
        table["servos"]["tendons"] = table["servos"]["tendons"][:2]
        del table["simulation"]
        table["controller"] = {
            "sections": [{"pair_angle_deg": [0.0, 90.0]}],
            "jog": {"mm_s": 5.0},
            "homing": {"find_slack": False},
        }
        self.path.write_text(written(table), encoding="utf-8")
        self.wound = np.array([1.0, 1.0])
        self.already = frozenset()
        self.stop = threading.Event()
        self.started = []
        self.at_start = lambda hand: None

    @contextmanager
    def with_processes(self, bench, process, needed):
        if "control" in needed:
            settings = bench.checked()
            running = VirtualBench(TRUE, settings.controller, settings.robot)
            believed = np.sign([axis.mm_per_rad for axis in settings.servos.tendons])
            running.plant.mm_per_rad[:2] *= self.wound * believed
            running.run(0.2)
            self.started.append(VirtualHand(running))
            self.at_start(self.started[-1])
        yield self

    def alive(self):
        return self.already

    def run(self, *words):
        return main(["calibrate", "robot", "--config", str(self.path), *words])

    @property
    def identified(self):
        return tomllib.loads(self.path.read_text(encoding="utf-8"))["controller"].get("identified")

    @property
    def mode(self):
        return self.started[-1].bench.state.mode


def few_poses(*_):
    """A plan that is quickly gone through."""
    alone = [[2, 0], [0, 0], [-2, 0], [0, 0], [0, 2], [0, 0], [0, -2], [0, 0]]
    together, held_out = [[2, 1], [1, -2], [-2, -1], [-1, 2]], [[1, 1], [-1.5, -1]]
    alone, together, held_out = (
        np.column_stack([poses, np.zeros(len(poses))]) for poses in (alone, together, held_out)
    )
    return Plan(alone_mm=alone, together_mm=together, held_out_mm=held_out)


@pytest.fixture
def lab(tmp_path, monkeypatch):
    lab = Lab(tmp_path)
    monkeypatch.setattr(calibrating, "with_processes", lab.with_processes)
    monkeypatch.setattr(calibrating, "BenchHand", lambda session: session.started[-1])
    monkeypatch.setattr(calibrating, "stop_on_signals", lambda: lab.stop)
    monkeypatch.setattr(calibrating, "plan_for", few_poses)
    return lab


def test_what_is_found_is_written_and_the_tendons_are_let_go(lab, capsys):
    assert lab.run() == 0
    settings = read_bench(lab.path).checked()
    mm_per_rad = tuple(axis.mm_per_rad for axis in settings.servos.axes)
    assert settings.controller.identified.drawing == settings.controller.drawing(settings.robot, mm_per_rad)
    assert (lab.path.parent / "robot.json").exists()
    assert lab.mode == "idle"
    assert "written: [controller.identified]" in capsys.readouterr().out


def test_a_wrong_sign_is_corrected_and_the_controller_started_anew(lab, capsys):
    lab.wound[1] = -1.0
    assert lab.run() == 0
    assert [axis.mm_per_rad for axis in read_bench(lab.path).settings.servos.tendons] == [5.0, -5.0]
    assert len(lab.started) == 2
    assert lab.started[0].bench.state.mode == "idle"
    assert "signs corrected: proximal y" in capsys.readouterr().out


def test_what_was_identified_with_the_wrong_sign_goes_with_it(lab):
    assert lab.run() == 0
    lab.wound[1] = -1.0
    lab.already = frozenset({"controller"})
    assert lab.run() == 3
    assert lab.identified is None
    read_bench(lab.path).checked()


def test_all_signs_wrong_may_be_the_frame_and_nothing_is_written(lab, capsys):
    lab.wound[:] = -1.0
    before = lab.path.read_bytes()
    assert lab.run() == 3
    told = capsys.readouterr().err
    assert "all tendons bend the robot the other way" in told
    assert "turned by 180 degrees (nodal calibrate base), or mm_per_rad of every tendon" in told
    assert lab.path.read_bytes() == before
    assert lab.mode == "idle"


@pytest.mark.parametrize("state", ["ready", "fault"])
def test_a_robot_that_somebody_else_leads_is_left_alone(lab, capsys, state):
    def led(hand):
        hand.bench.home()
        if state == "fault":
            hand.bench.plant.servos[0].fail(0x20)
            hand.bench.run(0.5)

    lab.already, lab.at_start = frozenset({"controller"}), led
    assert lab.run() == 3
    told = capsys.readouterr().err
    assert f"the robot is not free to be led: its controller is in {state}" in told
    assert "what to do: " in told
    assert lab.mode == state


def test_a_signal_ends_it_with_the_tendons_let_go(lab, capsys, monkeypatch):
    def home(leader):
        lab.stop.set()
        leader._watched()

    monkeypatch.setattr("nodal.calibrate.robot.leading.Leader.home", home)
    assert lab.run() == 130
    told = capsys.readouterr().err
    assert told.index("the tendons are let go") < told.index("interrupted")
    assert lab.mode == "idle"
    assert lab.identified is None


def test_a_signal_while_the_controller_is_started_anew_moves_nothing_more(lab):
    lab.wound[1] = -1.0

    def start(hand):
        if len(lab.started) == 2:
            lab.stop.set()

    lab.at_start = start
    assert lab.run() == 130
    assert lab.mode == "idle"
    assert lab.started[-1].bench.state.supervision.reason == "started"


def test_a_signal_during_the_fit_writes_nothing(lab, monkeypatch):
    fit = calibrating.identify

    def interrupted(*words):
        lab.stop.set()
        return fit(*words)

    monkeypatch.setattr(calibrating, "identify", interrupted)
    assert lab.run() == 130
    assert lab.identified is None
    assert not (lab.path.parent / "robot.json").exists()


def test_what_is_not_to_be_believed_stays_out_of_the_bench_file(lab, capsys, monkeypatch):
    monkeypatch.setattr("nodal.calibrate.robot.results._CLEARLY", 0.01)
    assert lab.run() == 3
    told = capsys.readouterr()
    assert "not written: moves that nothing was fitted to are not foreseen clearly better" in told.out
    assert "nodal: refused: moves" in told.err
    assert "next:" not in told.err
    assert lab.identified is None
    assert "not foreseen clearly better" in (lab.path.parent / "robot.json").read_text(encoding="utf-8")


def test_before_the_base_is_known_nothing_is_started(lab, capsys):
    (lab.path.parent / "rig.json").unlink()
    assert lab.run() == 3
    assert "begin with `nodal calibrate base`" in capsys.readouterr().err
    assert not lab.started


def test_a_bench_file_that_cannot_be_written_is_found_out_first(lab, capsys):
    lab.path.with_name("bench.toml~").symlink_to("nowhere/bench.toml")
    assert lab.run() == 2
    assert "bench.toml: cannot be written" in capsys.readouterr().err
    assert not lab.started
