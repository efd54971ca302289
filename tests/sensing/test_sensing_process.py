"""The sensing process on a real Zenoh session: frames in as a simulated camera hands them over, everything else out."""

import socket
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest

from drivers.cameras import SimulatedCameraSettings
from messaging import topics
from messaging.control import Reply, TendonState
from messaging.frames import Frame
from messaging.session import open_rendezvous, open_session
from messaging.settings import RobotSettings, ZenohSettings
from messaging.shape import NodalPoints, ShapeEstimate
from messaging.views import POINT
from sensing.process import run
from sensing.settings import NodalPointSetting, SensingSettings

DEADLINE_S = 30.0
PERIOD_NS = 33_000_000
ROBOT = RobotSettings(section_length_mm=(40.0, 40.0))
SETTINGS = SensingSettings(
    nodal_points=(NodalPointSetting(name="middle", arc_mm=40.0), NodalPointSetting(name="tip", arc_mm=80.0))
)
POSE = (0.5, 0.4, 0.3, 0.4)


def eventually(condition):
    deadline = time.monotonic() + DEADLINE_S
    while not (value := condition()):
        assert time.monotonic() < deadline, f"nothing came of it within {DEADLINE_S:g} s"
        time.sleep(0.005)
    return value


@pytest.fixture(scope="module")
def zenoh_settings():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return ZenohSettings(rendezvous=f"tcp/127.0.0.1:{probe.getsockname()[1]}")


class Outside:
    """Everybody else on the bench: the cameras, the controller, a recorder."""

    def __init__(self, session, cameras):
        self.session = session
        self._cameras = {name: session.publisher(topics.SIMULATED_CAMERA.named(name)) for name in cameras}
        self.tendon_state = session.publisher(topics.TENDON_STATE)
        self._shapes = session.every(topics.SHAPE, 100)
        self.frames = {name: session.every(topics.CAMERA.named(name), 100) for name in cameras}
        self.calibrations = session.every(topics.CAMERA_CALIBRATION, 100)
        self.poses = session.every(topics.CAMERA_POSE, 100)
        self.centrelines = session.every(topics.CENTRELINE, 100)
        self.nodal_points = session.every(topics.NODAL_POINTS, 100)
        self._captured_ns = time.monotonic_ns()

    def show(self, pictures):
        """Hand over one frame of each camera, taken at the same time; returns when, on CLOCK_MONOTONIC."""
        self._captured_ns = max(time.monotonic_ns(), self._captured_ns + PERIOD_NS)
        for name, jpeg in pictures.items():
            self._cameras[name].put(Frame(camera=name, capture_time_ns=self._captured_ns, jpeg=jpeg))
        return self._captured_ns

    def report_stage(self, insertion_mm=0.0):
        self.tendon_state.put(
            TendonState(
                time_ns=time.time_ns(),
                displacement_mm=np.zeros(4),
                displacement_mm_s=np.zeros(4),
                insertion_mm=insertion_mm,
                insertion_mm_s=0.0,
                current_ma=np.zeros(5),
                temperature_c=np.zeros(5),
                voltage_v=np.zeros(5),
                hardware_error=np.zeros(5),
                torque=True,
            )
        )

    def next_shape(self):
        return ShapeEstimate.from_bytes(eventually(self._shapes.take).payload)

    def shape_of(self, pictures):
        """The estimate of a frame set that is shown once."""
        self.show(pictures)
        return self.next_shape()


@pytest.fixture(scope="module")
def outside(small_bench, zenoh_settings):
    """A running sensing process; afterwards it must still be alive, and end when it is told to."""
    names = [camera.camera for camera in small_bench.rig]
    stop, failure, healthy = threading.Event(), [], threading.Event()

    @contextmanager
    def _running(session):
        def sensing():
            try:
                run(
                    SETTINGS,
                    ROBOT,
                    small_bench.rig,
                    {},
                    dict.fromkeys(names, SimulatedCameraSettings()),
                    session,
                    stop,
                    healthy.set,
                )
            except Exception as error:  # noqa: BLE001  whatever ends the process is the test's business
                failure.append(error)

        thread = threading.Thread(target=sensing)
        thread.start()
        try:
            yield
        finally:
            alive = thread.is_alive()
            stop.set()
            thread.join(DEADLINE_S)
        assert failure == []
        assert alive
        assert not thread.is_alive()

    with (
        open_rendezvous(zenoh_settings, "sensing-test"),
        open_session(zenoh_settings, "sensing-test", "sensing") as inner,
        open_session(zenoh_settings, "sensing-test", "outside") as outer,
        _running(inner),
    ):
        everybody_else = Outside(outer, names)
        assert healthy.wait(DEADLINE_S)
        # the rig is said every second: once it is heard, everybody hears everybody
        eventually(everybody_else.poses.take)
        yield everybody_else


@pytest.fixture(scope="module")
def seen(small_bench, arcs, outside):
    """Pictures of one pose, which the process has seen once already: the way to it is open."""
    pictures = small_bench.photograph(arcs(*POSE))
    outside.show(pictures)
    while outside._shapes.take() is None:
        outside.show(pictures)
        time.sleep(0.2)
    while time.sleep(0.5) or outside._shapes.take() is not None:
        pass
    for subscription in (*outside.frames.values(), outside.centrelines, outside.nodal_points):
        while subscription.take() is not None:
            pass
    return pictures


def test_a_frame_set_becomes_an_estimate(outside, seen, arcs):
    outside.report_stage()
    before_ns = time.time_ns()
    estimate = outside.shape_of(seen)
    assert estimate.refusal == ""
    assert np.abs(estimate.node_mm - arcs(*POSE)[[40, 80]]).max() < 0.3
    assert estimate.node_names == ("middle", "tip")
    assert abs(estimate.capture_time_ns - before_ns) < 10 * 1_000_000_000
    assert 0 < estimate.capture_to_publish_ns < DEADLINE_S * 1e9


def test_frames_go_out_as_they_came_with_their_sets_number(outside, seen):
    for subscription in outside.frames.values():
        while subscription.take() is not None:
            pass
    captured_ns = outside.show(seen)
    estimate = outside.next_shape()
    received = {name: eventually(subscription.take) for name, subscription in outside.frames.items()}
    assert {name: one.sequence for name, one in received.items()} == dict.fromkeys(
        received, estimate.sequence
    )
    frames = {name: Frame.from_bytes(one.payload) for name, one in received.items()}
    assert {name: frame.jpeg for name, frame in frames.items()} == seen
    assert {frame.capture_time_ns for frame in frames.values()} == {estimate.capture_time_ns}
    unix_from_monotonic_ns = time.time_ns() - time.monotonic_ns()
    assert estimate.capture_time_ns - captured_ns == pytest.approx(unix_from_monotonic_ns, abs=1_000_000_000)
    assert outside.shape_of(seen).sequence == estimate.sequence + 1


def test_the_base_is_unknown_until_the_stage_reports(outside, seen):
    outside.report_stage()
    eventually(lambda: outside.report_stage() or "base_unknown" not in outside.shape_of(seen).flags)


def test_viewers_get_the_centreline_the_nodal_points_and_the_rig(outside, seen):
    estimate = outside.shape_of(seen)

    def view(topic, subscription):
        """What viewers are told of this very estimate; those of earlier ones may still be on their way."""
        while True:
            wire = topic.type.from_bytes(eventually(subscription.take).payload).wire
            if wire.timestamp.ToNanoseconds() == estimate.capture_time_ns:
                return wire

    line = view(topics.CENTRELINE, outside.centrelines)
    assert line.frame_id == "robot"
    height_m = np.frombuffer(line.data, POINT)["z"]
    assert height_m == pytest.approx(1e-3 * estimate.centreline_mm[:, 2], abs=1e-6)
    nodes = view(topics.NODAL_POINTS, outside.nodal_points)
    height_m = np.frombuffer(nodes.data, POINT)["z"]
    assert height_m == pytest.approx(1e-3 * estimate.node_mm[:, 2], abs=1e-6)
    said = [eventually(outside.calibrations.take) for _ in range(2)]
    assert {one.key.split("camera/")[1] for one in said} == {"left/calibration", "right/calibration"}


def test_nodal_points_are_renamed_and_bad_ones_refused(outside, seen):
    def asked(names, arc_mm):
        request = NodalPoints(names=names, arc_mm=np.array(arc_mm))
        return outside.session.ask(topics.SENSING_NODES, request, DEADLINE_S)

    assert asked(("a", "b", "c"), [10.0, 20.0, 30.0]) == Reply(accepted=True, state="", reason="")
    assert outside.shape_of(seen).node_names == ("a", "b", "c")
    refused = asked(("far",), [80.5])
    assert not refused.accepted
    assert refused.reason == "nodal point far at 80.5 mm is beyond the robot; allowed are 0 to 80 mm"
    assert outside.shape_of(seen).node_names == ("a", "b", "c")
    assert asked(("middle", "tip"), [40.0, 80.0]).accepted


@pytest.mark.parametrize("damage", ["cut", "empty", "black"])
def test_a_damaged_frame_is_refused_and_the_next_one_estimated(outside, seen, encode, damage, caplog):
    frame = {"cut": seen["left"][:4000], "empty": b"", "black": encode(np.zeros((540, 960, 3)))}[damage]
    estimate = outside.shape_of({**seen, "left": frame})
    assert estimate.refusal.startswith("camera left: ")
    eventually(lambda: estimate.refusal in caplog.text)
    assert outside.shape_of(seen).refusal == ""


def test_what_is_not_a_message_does_no_harm(outside, seen, caplog):
    """Rubbish on the topics that sensing listens to, with an envelope and without."""

    class Rubbish:
        @staticmethod
        def to_bytes():
            return b"\xff\xff\xff rubbish"

    outside._cameras["left"].put(Rubbish())
    outside.tendon_state.put(Rubbish())
    eventually(lambda: outside.shape_of(seen) and "TendonState" in caplog.text)
    outside.session._session.put(topics.TENDON_STATE.key, b"without an envelope")
    eventually(lambda: outside.shape_of(seen) and "no envelope" in caplog.text)
    assert outside.shape_of(seen).refusal == ""


def test_frames_too_far_apart_make_no_set(outside, seen):
    captured_ns = outside.show({"left": seen["left"]})
    late = Frame(camera="right", capture_time_ns=captured_ns + 14_000_000, jpeg=seen["right"])
    outside._cameras["right"].put(late)
    outside._captured_ns = captured_ns + 100_000_000
    after = outside.shape_of(seen)
    assert after.refusal == ""
    assert outside._shapes.take() is None
