"""A small made-up run in a real recording: a straight robot that leans further and further over, in grey pictures.

The nodal points are renamed on the way, one frame set is refused, one flagged, one never estimated, and the controller
tracks a target for a while.
"""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.rig import default_cameras
from messaging.control import ActionRequest, ControllerState, State, Target, TendonCommand, TendonState
from messaging.frames import CameraCalibration, Frame
from messaging.history import Asked, Memory
from messaging.shape import ShapeEstimate, Truth
from messaging.views import (
    CameraPoseView,
    CameraView,
    CentrelineView,
    DesiredPointsView,
    LogLine,
    NodalPointsView,
    TargetPathView,
)
from nodal.__main__ import main
from nodal.calibration_file import rig_text
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 50_000_000
SETS, TRACKED, REFUSED, FLAGGED, UNESTIMATED, RENAMED = 30, range(8, 24), 12, 15, 18, 20
ARC_MM = np.linspace(0, 80, 41)
GREY = 90


def quartered(camera):
    """The same camera with pixels of four times the size; integer coordinates are pixel centres."""
    intrinsics = camera.intrinsics.copy()
    intrinsics[:2] /= 4
    intrinsics[:2, 2] += 0.5 / 4 - 0.5
    return CameraCalibration(
        camera=camera.camera,
        width_px=camera.width_px // 4,
        height_px=camera.height_px // 4,
        intrinsics=intrinsics,
        distortion=np.array([-0.2, 0.05, 0.001, -0.001, 0.0]),
        camera_from_robot=camera.camera_from_robot,
    )


def capture_ns(number):
    return START_NS + number * PERIOD_NS


def leaning(number):
    angle = 0.02 * number
    return ARC_MM[:, None] * np.array([np.sin(angle), 0.0, np.cos(angle)])


def names_of(number):
    return ("middle", "tip") if number < RENAMED else ("tip", "base")


def nodes_of(number):
    return np.array([{"base": 0.0, "middle": 40.0, "tip": 80.0}[name] for name in names_of(number)])


def shape_of(number):
    points, arcs = leaning(number), nodes_of(number)
    known = number != REFUSED
    rows = np.searchsorted(ARC_MM, arcs)
    return ShapeEstimate(
        sequence=number,
        capture_time_ns=capture_ns(number),
        capture_to_publish_ns=20_000_000 + number,
        refusal="" if known else "camera left: no robot in view",
        method="refined",
        flags=("tip_unseen",) if number == FLAGGED else (),
        arc_mm=ARC_MM if known else [],
        centreline_mm=points if known else np.zeros((0, 3)),
        epipolar_angle_rad=np.ones(ARC_MM.size if known else 0),
        node_names=names_of(number) if known else (),
        node_arc_mm=arcs if known else [],
        node_mm=points[rows] if known else np.zeros((0, 3)),
        node_covariance_mm2=np.tile(np.diag([1.0, 2.0, 3.0]) * 1e-4, (2, 1, 1))
        if known
        else np.zeros((0, 3, 3)),
        length_mm=80.0 + 0.01 * number,
        known_length_mm=80.0,
        insertion_mm=0.0,
        ray_gap_mm=0.01,
        ray_bias_mm=0.0,
        residual_px=0.1,
        camera_names=("left", "right") if known else (),
        camera_residual_px=[0.1, 0.25] if known else [],
        visible_mm=[80.0, 61.5] if known else [],
        stage_names=("decode", "refine"),
        stage_s=[0.004, 0.006],
    )


TARGET = Target(
    name="rise",
    node_names=("tip", "middle"),
    weights=[1.0, 0.0],
    time_s=[0.0, 1.0, 2.0],
    position_mm=np.arange(18.0).reshape(3, 2, 3) + 60,
    repeat=False,
)


def desired_of(number):
    return leaning(number)[[40, 20]] + [0.0, 0.5, 0.0]


def state_of(number):
    tracking = number in TRACKED
    return ControllerState(
        time_ns=capture_ns(number) + 30_000_000,
        state=State.TRACKING if tracking else State.HOLD,
        reason="" if tracking else "the operator asked to hold",
        target_name="rise" if tracking else "",
        node_names=TARGET.node_names if tracking else (),
        desired_mm=desired_of(number) if tracking else np.zeros((0, 3)),
        measured_mm=leaning(number)[[40, 20]] if tracking else np.zeros((0, 3)),
        tracking_error_mm=0.5 if tracking else 0.0,
        shape_sequence=number,
        shape_age_s=0.03,
        lateness_s=0.0002,
        busy_s=0.001,
        overruns=0,
        now_s=1.0,
        dt_s=0.005,
        sighted_capture_ns=capture_ns(number),
        sighted_age_s=0.025,
        drive_absence="",
        commanded=tracking,
    )


def tendons_of(number):
    return TendonState(
        time_ns=capture_ns(number),
        displacement_mm=[0.1 * number, 0, 0, 0],
        displacement_mm_s=[2, 0, 0, 0],
        insertion_mm=1.0,
        insertion_mm_s=0.0,
        current_ma=[1, 2, 3, 4, 5],
        temperature_c=[30] * 5,
        voltage_v=[12] * 5,
        hardware_error=[0] * 5,
        torque=True,
    )


def command_of(number):
    return TendonCommand(
        time_ns=capture_ns(number) + 30_000_000,
        displacement_mm=[0.1 * number + 0.05, 0, 0, 0],
        insertion_mm=1.0,
        shape_sequence=number,
        capture_to_command_ns=30_000_000,
    )


def picture_of(camera):
    picture = np.full((camera.height_px, camera.width_px, 3), GREY, np.uint8)
    return cv2.imencode(".jpg", picture)[1].tobytes()


class Tape:
    """Writes messages one after another, each with its own number and a later log time."""

    def __init__(self, writer):
        self.writer = writer
        self.numbers = {}

    def put(self, key, message, log_time_ns, sequence=None):
        number = self.numbers.get(key, 0) if sequence is None else sequence
        self.numbers[key] = number + 1
        self.writer.write(
            key,
            type(message).protobuf,
            message.to_bytes(),
            sequence=number,
            publish_time_ns=log_time_ns - 1000,
            log_time_ns=log_time_ns,
        )


def record_rig(tape, rig, time_ns):
    for camera in rig:
        tape.put(f"camera/{camera.camera}/calibration", CameraView.of(camera, time_ns), time_ns)
        tape.put(f"camera/{camera.camera}/pose", CameraPoseView.of(camera, time_ns), time_ns)


def record_set(tape, rig, number):
    """One frame set with all that follows from it."""
    now_ns = capture_ns(number) + 10_000_000
    for camera in rig:
        frame = Frame(camera=camera.camera, capture_time_ns=capture_ns(number), jpeg=picture_of(camera))
        tape.put(f"camera/{camera.camera}", frame, now_ns, number)
    now_ns += 10_000_000
    tape.put(
        "truth",
        Truth(
            capture_time_ns=capture_ns(number),
            arc_mm=ARC_MM,
            centreline_mm=leaning(number) + np.array([0, 0.02, 0]),
            insertion_mm=0.0,
        ),
        now_ns,
    )
    if number != UNESTIMATED:
        shape = shape_of(number)
        tape.put("shape", shape, now_ns, number)
        if not shape.refusal:
            tape.put("shape/centreline", CentrelineView.of(shape), now_ns, number)
            tape.put("shape/nodal_points", NodalPointsView.of(shape), now_ns, number)
        now_ns += 10_000_000
        state = state_of(number)
        tape.put("controller/state", state, now_ns, number)
        if state.node_names:
            tape.put("controller/desired", DesiredPointsView.of(state), now_ns, number)
        tape.put("tendon/state", tendons_of(number), now_ns, number)
        tape.put("tendon/command", command_of(number), now_ns, number)


@pytest.fixture(scope="session")
def made():
    """What the recording was made of."""
    rig = tuple(quartered(camera) for camera in default_cameras())
    return SimpleNamespace(
        rig=rig,
        target=TARGET,
        start_ns=START_NS,
        sets=SETS,
        refused=REFUSED,
        flagged=FLAGGED,
        unestimated=UNESTIMATED,
        tracked=TRACKED,
        grey=GREY,
        capture_ns=capture_ns,
        shape_of=shape_of,
        state_of=state_of,
        tendons_of=tendons_of,
        picture_of=picture_of,
        desired_of=desired_of,
    )


@pytest.fixture(scope="session")
def recording(made, tmp_path_factory):
    """The run in two parts; the second begins with a repetition of the target."""
    first = tmp_path_factory.mktemp("recording") / "lean.mcap"
    calibration = rig_text(made.rig).encode()
    half = SETS // 2
    target_ns = capture_ns(TRACKED[0]) - 5_000_000
    numbers = {}
    for path, sets in ((first, range(half)), (first.with_name("lean.part2.mcap"), range(half, SETS))):
        with RecordingWriter(path, RecorderSettings()) as writer:
            tape = Tape(writer)
            tape.numbers = numbers
            begin_ns = capture_ns(sets[0])
            writer.attach("bench.toml", b"name = 'lean'\n", begin_ns)
            writer.attach("calibration.json", calibration, begin_ns)
            if sets[0]:
                writer.write(
                    "target",
                    Target.protobuf,
                    TARGET.to_bytes(),
                    sequence=0,
                    publish_time_ns=target_ns - 1000,
                    log_time_ns=begin_ns,
                )
            tape.put(
                "log", LogLine.of(time_ns=begin_ns, level=20, process="control", text="leaning"), begin_ns
            )
            record_rig(tape, made.rig, begin_ns)
            for number in sets:
                if number == TRACKED[0]:
                    request = Asked(
                        time_ns=target_ns,
                        service="controller/do",
                        request=ActionRequest(action="arm").to_bytes(),
                        accepted=True,
                        state="tracking",
                        reason="",
                    )
                    tape.put("asked", request, target_ns)
                    tape.put("target", TARGET, target_ns)
                    tape.put("target/path", TargetPathView.of(TARGET, target_ns), target_ns)
                    tape.put(
                        "controller/memory",
                        Memory(time_ns=target_ns, content=b"12345", publication=3),
                        target_ns,
                    )
                record_set(tape, made.rig, number)
            tape.put("someone/else", made.shape_of(0), capture_ns(sets[-1]) + PERIOD_NS)
    return first


@pytest.fixture
def nodal(capsys):
    """Run a command; returns its exit status, stdout lines and stderr lines."""

    def run(*words):
        try:
            status = main([str(word) for word in words])
        except SystemExit as exit_:
            status = exit_.code
        said = capsys.readouterr()
        return SimpleNamespace(status=status, out=said.out.splitlines(), err=said.err.splitlines())

    return run
