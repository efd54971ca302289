"""Laws by name and from a file; and what every law that comes with the controller must do on a bench."""

import re

import numpy as np
import pytest

from controller.belief import BeliefSettings, Learning
from controller.errors import ControllerSetupError
from controller.laws import law_names, make_law
from controller.loop import Loop
from controller.plant import Plant
from controller.settings import ControllerSettings, HomingSettings
from messaging.control import Action, ActionRequest
from messaging.settings import RobotSettings
from nodal import targets
from nodal.virtual.bench import VirtualBench
from nodal.virtual.settings import VirtualBenchSettings

ROBOT = RobotSettings(section_length_mm=(40.0, 40.0))
PLANT = Plant.of(ControllerSettings(), ROBOT)
STANDING_STILL = """
import msgspec

class Tuning(msgspec.Struct, forbid_unknown_fields=True):
    patience: float = 1.0

class StandsStill:
    lead_s = 0.0
    def start(self, beginning):
        return beginning.command_mm
    def step(self, state, inputs):
        return state, state

def make(tuning, plant):
    return StandsStill()
"""


def law(**settings):
    settings = ControllerSettings(**settings)
    return make_law(settings, Plant.of(settings, ROBOT))


def asked_of(samples):
    """(n, A) every command that was sent."""
    command = samples.command_mm.reshape(-1, samples.command_mm.shape[-1])
    return command[~np.isnan(command).any(axis=1)]


def test_laws_are_the_files_of_their_folder():
    assert law_names() == ("model_free", "resolved_rate")
    assert type(law(law="model_free")).__name__ == "ModelFree"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"law": "mine"}, "law 'mine' is not known; known are model_free, resolved_rate"),
        ({"tuning": {"feedback_per_s": -1}}, r"controller.tuning of law resolved_rate: .*feedback_per_s"),
        ({"tuning": {"belief": {"bound": 2}}}, r"controller.tuning of law resolved_rate: .*belief.bound"),
        ({"tuning": {"feedbak": 1}}, "unknown field `feedbak`"),
        (
            {"law_file": "nowhere/mine.py"},
            "controller.law_file = nowhere/mine.py: there is no such Python file",
        ),
        ({"law_file": "nowhere/model_free.py"}, "model_free is the name of a law that comes with nodal"),
    ],
)
def test_laws_and_tunings_that_cannot_be_are_refused_by_name(settings, message):
    with pytest.raises(ControllerSetupError, match=message):
        law(**settings)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import msgspec\nclass Tuning(msgspec.Struct): ...", "offers no make"),
        ("def make(", "SyntaxError"),
        ("raise RuntimeError('no luck')", "RuntimeError: no luck"),
    ],
)
def test_files_that_hold_no_law_are_refused_in_their_own_words(tmp_path, text, message):
    file = tmp_path / "broken.py"
    file.write_text(text)
    with pytest.raises(ControllerSetupError, match=message):
        law(law_file=str(file))


def test_a_law_of_ones_own_is_one_file_and_homing_does_not_depend_on_it(tmp_path):
    file = tmp_path / "stands_still.py"
    file.write_text(STANDING_STILL)
    settings = ControllerSettings(
        law_file=str(file), tuning={"patience": 2.0}, homing=HomingSettings(find_slack=False)
    )
    bench = VirtualBench(VirtualBenchSettings(), settings, ROBOT)
    bench.home()
    bench.target(targets.points({"tip": [5.0, 0.0, 83.0]}, {}))
    assert bench.do("arm").accepted
    samples, _ = bench.run(0.5)
    assert samples.mode[-1] == "tracking"
    assert np.ptp(asked_of(samples), axis=0).max() == 0.0
    assert type(bench.state).from_bytes(bench.state.to_bytes()).to_bytes() == bench.state.to_bytes()


@pytest.mark.parametrize("name", law_names())
def test_every_law_leads_the_tip_to_its_place_within_all_limits(name):
    settings = ControllerSettings(law=name)
    bench = VirtualBench(VirtualBenchSettings(), settings, ROBOT)
    bench.home()
    place = np.array([10.0, -4.0, 84.0])
    assert bench.target(targets.points({"tip": place.tolist()}, {})).accepted
    bench.do("arm")
    samples, _ = bench.run(9.0)
    assert set(samples.mode[10:]) == {"tracking"}
    tip = samples.node_mm[:, samples.node_names.index("tip")]
    assert np.linalg.norm(tip[-60:] - place, axis=1).max() < 0.3
    limits, command = Plant.of(settings, ROBOT).limits, asked_of(samples)
    assert (command >= limits.low_mm).all()
    assert (command <= limits.high_mm).all()
    assert (np.abs(np.diff(command, axis=0)) <= limits.rate_mm_s / settings.rate_hz * (1 + 1e-6)).all()


@pytest.mark.parametrize(("name", "restless_mm"), [("resolved_rate", 0.3), ("model_free", 6.0)])
def test_out_of_reach_is_as_near_as_it_gets_without_a_fault(name, restless_mm):
    """One that feels its way goes on feeling where nothing brings it nearer; one with a model comes to rest."""
    settings = ControllerSettings(law=name, reachable_within_mm=100.0)
    bench = VirtualBench(VirtualBenchSettings(), settings, ROBOT)
    bench.home()
    assert bench.target(targets.points({"tip": [75.0, 0.0, 60.0]}, {})).accepted
    bench.do("arm")
    samples, _ = bench.run(14.0)
    assert samples.mode[-1] == "tracking"
    tip = samples.node_mm[-130:, samples.node_names.index("tip")]
    assert np.ptp(tip, axis=0).max() < restless_mm
    assert np.linalg.norm(tip[-1] - [75.0, 0.0, 60.0]) < 20.0
    assert (np.abs(asked_of(samples)).max(axis=0) <= Plant.of(settings, ROBOT).limits.high_mm).all()


def test_a_snapshot_of_the_loop_keeps_what_a_law_has_learnt():
    bench = VirtualBench(VirtualBenchSettings(), ControllerSettings(), ROBOT)
    bench.home()
    bench.target(targets.points({"tip": [5.0, 0.0, 83.0]}, {}))
    bench.do("arm")
    bench.run(0.5)
    state = bench.state
    assert type(state).from_bytes(state.to_bytes()).to_bytes() == state.to_bytes()
    assert isinstance(Loop(ControllerSettings(), ROBOT).start().to_bytes(), bytes)


def test_what_a_law_has_learnt_outlives_a_hold_and_ends_with_a_homing():
    bench = VirtualBench(VirtualBenchSettings(), ControllerSettings(), ROBOT)
    bench.home()
    assert bench.state.learnt is None
    bench.target(targets.points({"tip": [12.0, 0.0, 82.0]}, {}))
    bench.do("arm")
    bench.run(3.0)
    learnt = bench.state.task.law_state.belief.mean[:20]
    bench.do("hold")
    bench.target(targets.points({"middle": [3.0, 0.0, 41.0]}, {}))
    bench.do("arm")
    assert np.abs(learnt).max() > 0.05
    np.testing.assert_allclose(bench.state.task.law_state.belief.mean[:20], learnt, atol=0.05)
    bench.do("hold")
    bench.do("home")
    assert bench.state.learnt is None


BROKEN = {
    "no numbers": ("(state, None)", "must be 5 finite numbers|float"),
    "a list of words": ("(state, ['a'] * 5)", "could not convert"),
    "too few": ("(state, [0.0, 0.0])", "must be 5 finite numbers"),
    "nan": ("(state, [float('nan')] * 5)", "must be 5 finite numbers"),
    "an error": ("1 / 0", "ZeroDivisionError"),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_whatever_a_law_answers_it_ends_in_a_fault_and_not_in_the_process(tmp_path, fault):
    answer, words = BROKEN[fault]
    file = tmp_path / "broken_law.py"
    file.write_text(STANDING_STILL.replace("return state, state", f"return {answer}"))
    settings = ControllerSettings(law_file=str(file), homing=HomingSettings(find_slack=False))
    bench = VirtualBench(VirtualBenchSettings(), settings, ROBOT)
    bench.home()
    bench.target(targets.points({"tip": [5.0, 0.0, 83.0]}, {}))
    bench.do("arm")
    samples, _ = bench.run(0.1)
    assert samples.mode[-1] == "fault"
    assert re.search(words, samples.reason[-1])
    assert not samples.torque[-1]


def test_a_law_whose_memory_cannot_be_kept_is_a_fault_when_it_begins(tmp_path):
    file = tmp_path / "forgetful.py"
    file.write_text(STANDING_STILL.replace("return beginning.command_mm", "return {1, 2}"))
    settings = ControllerSettings(law_file=str(file), homing=HomingSettings(find_slack=False))
    bench = VirtualBench(VirtualBenchSettings(), settings, ROBOT)
    bench.home()
    bench.target(targets.points({"tip": [5.0, 0.0, 83.0]}, {}))
    bench.do("arm")
    samples, _ = bench.run(0.1)
    assert samples.mode[-1] == "fault"
    assert "a snapshot cannot keep a set" in samples.reason[-1]


def test_after_a_jog_in_a_hold_the_law_begins_where_the_robot_is_seen():
    """Where axes stand in their lost motion is forgotten in a hold; what was learnt of the robot is not."""
    bench = VirtualBench(VirtualBenchSettings(), ControllerSettings(), ROBOT)
    bench.home()
    bench.target(targets.points({"tip": [5.0, 0.0, 83.0]}, {}))
    bench.do("arm")
    bench.run(2.0)
    learnt = bench.state.task.law_state.belief.mean[:20]
    bench.do("hold")
    _, (jogged,) = bench.run(3.0, ActionRequest(action=Action.JOG, axis="1", distance_mm=2.0))
    assert jogged.accepted
    bench.do("arm")
    state, learning = bench.state.task.law_state, Learning(BeliefSettings(), PLANT.kinematics)
    believed, _ = learning.nodes(
        state.belief, learning.felt_mm(state.belief, state.axes), state.belief.arc_mm
    )
    np.testing.assert_allclose(believed, bench.state.seen.shape.node_mm, atol=0.3)
    np.testing.assert_allclose(state.belief.mean[:20], learnt, atol=0.05)
    samples, _ = bench.run(3.0)
    assert samples.error_mm("tip")[-1] < 0.2
