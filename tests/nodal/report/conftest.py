"""Messages of a made-up run whose figures are known, and recordings made of them."""

import dataclasses
import math
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from drivers.simulated.cameras.rig import default_cameras
from messaging import topics
from messaging.control import ControllerState, State, TendonCommand, TendonState
from messaging.frames import Frame
from messaging.history import Asked
from messaging.shape import ShapeEstimate, Truth
from messaging.views import LogLine
from nodal.calibration_file import save_rig
from nodal.report.summary import CIRCLE
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 33_333_333
CYCLE_NS = 10_000_000
ARC_MM = np.linspace(0, 80, 81)
NOTHING_SEEN = {
    "arc_mm": np.zeros(0),
    "centreline_mm": np.zeros((0, 3)),
    "epipolar_angle_rad": np.zeros(0),
    "node_names": (),
    "node_arc_mm": np.zeros(0),
    "node_mm": np.zeros((0, 3)),
    "node_covariance_mm2": np.zeros((0, 3, 3)),
}


def line(offset_mm=(0.0, 0.0, 0.0)):
    return np.column_stack([np.zeros(81), np.zeros(81), ARC_MM]) + offset_mm


def truth_at(time_ns):
    """A straight robot that drifts along x by 10 mm a second."""
    x_mm = 10 * (time_ns - START_NS) / 1e9
    return Truth(capture_time_ns=time_ns, arc_mm=ARC_MM, centreline_mm=line((x_mm, 0, 0)), insertion_mm=0.0)


def shape(sequence, time_ns, offset_mm=0.0, **changes):
    points = truth_at(time_ns).centreline_mm + np.array([0, offset_mm, 0])
    return ShapeEstimate(
        **{
            "sequence": sequence,
            "capture_time_ns": time_ns,
            "capture_to_publish_ns": 10_000_000,
            "refusal": "",
            "method": "refined",
            "flags": (),
            "arc_mm": ARC_MM,
            "centreline_mm": points,
            "epipolar_angle_rad": np.ones(len(ARC_MM)),
            "node_names": ("middle", "tip"),
            "node_arc_mm": np.array([40.0, 80.0]),
            "node_mm": points[[40, 80]],
            "node_covariance_mm2": np.zeros((2, 3, 3)),
            "length_mm": 80.0,
            "known_length_mm": 80.0,
            "insertion_mm": 0.0,
            "ray_gap_mm": 0.0,
            "ray_bias_mm": 0.0,
            "residual_px": 0.0,
            "camera_names": (),
            "camera_residual_px": np.zeros(0),
            "visible_mm": np.zeros(0),
            "stage_names": (),
            "stage_s": np.zeros(0),
            **changes,
        }
    )


def refused(sequence, time_ns, reason):
    return shape(sequence, time_ns, refusal=reason, **NOTHING_SEEN)


def state(sequence, capture_ns, off_mm, target=CIRCLE, **changes):
    desired = truth_at(capture_ns).centreline_mm[80] + np.array([0, 0, off_mm])
    return ControllerState(
        **{
            "time_ns": capture_ns + 15_000_000,
            "state": State.TRACKING,
            "reason": "",
            "target_name": target,
            "node_names": ("tip",),
            "desired_mm": desired[None],
            "measured_mm": desired[None],
            "tracking_error_mm": 0.0,
            "shape_sequence": sequence,
            "shape_age_s": 0.015,
            "lateness_s": 0.002,
            "busy_s": 0.001,
            "overruns": 0,
            "now_s": 0.0,
            "dt_s": 0.005,
            "sighted_capture_ns": 0,
            "sighted_age_s": 0.0,
            "drive_absence": "",
            "commanded": True,
            **changes,
        }
    )


def command(age_ns, time_ns=0):
    return TendonCommand(
        time_ns=time_ns,
        displacement_mm=np.zeros(4),
        insertion_mm=0.0,
        shape_sequence=0,
        capture_to_command_ns=age_ns,
    )


def tendons(time_ns):
    return TendonState(
        time_ns=time_ns,
        displacement_mm=np.full(4, 0.25),
        displacement_mm_s=np.zeros(4),
        insertion_mm=1.0,
        insertion_mm_s=0.0,
        current_ma=np.array([10.0, -20.0, 30.0, 40.0, 50.0]),
        temperature_c=np.full(5, 31.0),
        voltage_v=np.full(5, 11.8),
        hardware_error=np.zeros(5),
        torque=True,
    )


class Story:
    """What a bench said, told in seconds since the start, and written as a recording."""

    def __init__(self):
        self._said = []
        self._numbers = Counter()
        _, jpeg = cv2.imencode(".jpg", np.full((1080, 1920, 3), 90, np.uint8))
        self._jpeg = jpeg.tobytes()

    def say(self, topic, message, at_s):
        number = self._numbers[topic.key]
        self._numbers[topic.key] += 1
        self._said.append((START_NS + round(at_s * 1e9), topic, message, number))

    def begin_anew(self, *restarted):
        """These topics' publishers count from 0 again."""
        for topic in restarted:
            self._numbers[topic.key] = 0

    def sense(self, begin_s, end_s, *, offset_mm=0.2, frames=True, **changes):
        for number in range(*(math.ceil(second * 1e9 / PERIOD_NS) for second in (begin_s, end_s))):
            time_ns = START_NS + number * PERIOD_NS
            at_s = (time_ns - START_NS) / 1e9
            for camera in ("left", "right") if frames else ():
                frame = Frame(camera=camera, capture_time_ns=time_ns, jpeg=self._jpeg)
                self.say(topics.CAMERA.named(camera), frame, at_s + 0.004)
            estimate = shape(self._numbers[topics.SHAPE.key], time_ns, offset_mm, **changes)
            self.say(topics.SHAPE, estimate, at_s + 0.01)

    def show_truth(self, begin_s, end_s):
        for at_s in np.arange(begin_s, end_s, 0.03):
            self.say(topics.TRUTH, truth_at(START_NS + round(at_s * 1e9)), at_s)

    def control(self, begin_s, end_s, *, off_mm=0.5, target=CIRCLE, **changes):
        for time_ns in range(START_NS + round(begin_s * 1e9), START_NS + round(end_s * 1e9), CYCLE_NS):
            number = max((time_ns - START_NS - 15_000_000) // PERIOD_NS, 0)
            capture_ns = START_NS + number * PERIOD_NS
            at_s = (time_ns - START_NS) / 1e9
            said = state(number, capture_ns, off_mm, target, **changes)
            self.say(topics.CONTROLLER_STATE, dataclasses.replace(said, time_ns=time_ns), at_s)
            self.say(topics.TENDON_COMMAND, command(20_000_000, time_ns), at_s)
            self.say(topics.TENDON_STATE, tendons(time_ns), at_s)

    def take_up(self, at_s, target):
        self.say(topics.TARGET, target, at_s)

    def ask(self, at_s, service, request, reason="", *, accepted=True):
        asked = Asked(
            time_ns=START_NS + round(at_s * 1e9),
            service=service.key,
            request=request.to_bytes(),
            accepted=accepted,
            state="tracking",
            reason=reason,
        )
        self.say(topics.ASKED, asked, at_s)

    def log(self, at_s, level, text, process="sensing"):
        time_ns = START_NS + round(at_s * 1e9)
        self.say(topics.LOG, LogLine.of(time_ns=time_ns, level=level, process=process, text=text), at_s)

    def write(self, path: Path, *, before_s=1e9, after_s=-1.0, attached=True, ended=True):
        """The recording of what was said within these times."""
        with RecordingWriter(path, RecorderSettings()) as recording:
            if attached:
                save_rig(path.with_suffix(".json"), default_cameras())
                recording.attach("calibration.json", path.with_suffix(".json").read_bytes(), START_NS)
                recording.attach("bench.toml", b'name = "made-up"\n', START_NS)
            recording.describe("VERSIONS", {"nodal": "1.2.3"})
            for time_ns, topic, message, number in sorted(self._said, key=lambda one: one[0]):
                if after_s <= (time_ns - START_NS) / 1e9 < before_s:
                    recording.write(
                        topic.key,
                        topic.type.protobuf,
                        message.to_bytes(),
                        sequence=number,
                        publish_time_ns=time_ns,
                        log_time_ns=time_ns,
                    )
            if ended:
                recording.describe("SUMMARY", {"lost/shape": "2"})
        return path


@pytest.fixture
def said():
    """Makers of single messages, and the times that they go by."""
    return SimpleNamespace(
        START_NS=START_NS,
        PERIOD_NS=PERIOD_NS,
        NOTHING_SEEN=NOTHING_SEEN,
        truth_at=truth_at,
        shape=shape,
        refused=refused,
        state=state,
        command=command,
        tendons=tendons,
    )


@pytest.fixture
def story():
    return Story()
