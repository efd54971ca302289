"""`nodal do` against a controller that answers from a script: what is asked, what is said, and with which exit status."""

import os
import shutil
import signal
import threading

import numpy as np
import pytest

from messaging import topics
from messaging.control import Action, ActionRequest, ControllerState, Reply, State
from messaging.session import open_rendezvous
from nodal.__main__ import main
from nodal.bench_file import bench_path
from nodal.toml_file import read_table, written
from nodal.watching import SILENT, line

FAULT = {
    "fault": "travel",
    "fault_value": 6.0,
    "fault_limit": 5.0,
    "fault_unit": "mm",
    "advice": "Look at the robot.",
}


def state(**changed):
    """A cycle of the controller."""
    nothing = np.zeros((0, 3))
    values = {
        "time_ns": 1, "state": State.TRACKING, "reason": "", "target_name": "circle", "node_names": (), "desired_mm": nothing,
        "measured_mm": nothing, "tracking_error_mm": 0.123, "shape_sequence": 1, "shape_age_s": 0.0, "lateness_s": 0.0,
        "busy_s": 0.0, "overruns": 0, "now_s": 1.0, "dt_s": 0.005, "sighted_capture_ns": 0, "sighted_age_s": 0.0,
        "drive_absence": "", "commanded": True, "progress": 0.25,
    }  # fmt: skip
    return ControllerState(**(values | changed))


class Scripted:
    """Answers everything with one reply, says one state over and over, and remembers what it hears."""

    def __init__(self, session, reply):
        self._answers = session.answers(topics.CONTROLLER_DO)
        self._states = session.publisher(topics.CONTROLLER_STATE)
        self._heartbeat = session.hears(topics.HEARTBEAT)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._live)
        self.reply, self.asked, self.beats = reply, [], 0
        self.says = state()

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join()

    def _live(self):
        while not self._end.wait(0.005):
            while (query := self._answers.take()) is not None:
                self.asked.append(query.request())
                query.reply(self.reply)
            self._states.put(self.says)
            self.beats += self._heartbeat.heard()


@pytest.fixture
def controller(zenoh_settings):
    started = Reply(accepted=True, state="idle", reason="started")
    with open_rendezvous(zenoh_settings, "simulated") as session, Scripted(session, started) as scripted:
        yield scripted


@pytest.fixture
def bench(tmp_path, zenoh_settings):
    table = read_table(bench_path("simulated"))
    table["zenoh"] = {"rendezvous": zenoh_settings.rendezvous}
    shutil.copy(bench_path("simulated").with_name("simulated-rig.json"), tmp_path)
    (tmp_path / "bench.toml").write_text(written(table), encoding="utf-8")
    return str(tmp_path / "bench.toml")


@pytest.fixture
def interruptible():
    """SIGINT works even if whoever started the tests had it ignored, as shells do for what runs in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_every_action_is_asked_for_and_what_was_answered_is_said(controller, bench, capsys):
    assert main(["do", "pause", "--config", bench]) == 0
    assert main(["do", "jog", "2", "-0.5", "--config", bench]) == 0
    assert main(["do", "--config", bench, "jog", "stage", "3"]) == 0
    assert [(a.action, a.axis, a.distance_mm) for a in controller.asked] == [
        (Action.PAUSE, "", 0.0),
        (Action.JOG, "2", -0.5),
        (Action.JOG, "stage", 3.0),
    ]
    assert capsys.readouterr().out == "idle: started\n" * 3


def test_a_fault_is_said_with_what_to_do_about_it(controller, bench, capsys):
    controller.reply = Reply(accepted=True, state="fault", reason="tendon 2: 6 mm", **FAULT)
    assert main(["do", "status", "--config", bench]) == 0
    assert capsys.readouterr().out == "fault: tendon 2: 6 mm\nwhat to do: Look at the robot.\n"
    controller.reply = Reply(accepted=False, state="fault", reason="arm is not possible in fault", **FAULT)
    assert main(["do", "arm", "--config", bench]) == 3
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        "nodal: refused: arm is not possible in fault (state: fault)\nwhat to do: Look at the robot.\n"
    )


@pytest.mark.parametrize("words", [["jog", "2"], ["jog", "2", "far"], ["jog", "2", "nan"], ["home", "2"]])
def test_words_that_do_not_fit_the_action_are_an_error(words, capsys):
    assert main(["do", *words, "--config", "simulated"]) == 2
    assert " ".join(words[1:]) in capsys.readouterr().err


def test_watch_says_what_changes_and_gives_a_heartbeat_until_it_is_interrupted(
    controller, bench, capsys, eventually, interruptible
):
    def interrupt():
        eventually(lambda: controller.beats > 3)
        controller.says = state(state=State.FAULT, reason="tendon 2: 6 mm", **FAULT)
        told = controller.beats
        eventually(lambda: controller.beats > told + 3)
        os.kill(os.getpid(), signal.SIGINT)

    interrupter = threading.Thread(target=interrupt)
    interrupter.start()
    assert main(["do", "watch", "--config", bench]) == 0
    interrupter.join()
    lines = capsys.readouterr().out.splitlines()
    assert lines == ["tracking | circle 25%, error 0.12 mm", "fault: tendon 2: 6 mm | Look at the robot."]
    assert controller.asked == []


def test_lines_of_a_watch():
    assert line(state(state=State.HOLD, reason="paused by the operator")).startswith(
        "hold: paused by the operator | circle 25%"
    )
    assert line(state(state=State.IDLE, reason="started")) == "idle: started"
    assert "silent" in SILENT
    assert ActionRequest(action=Action.HOME).axis == ""
