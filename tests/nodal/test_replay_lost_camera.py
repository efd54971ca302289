"""A log in which a camera is silent for a while: its sets are replayed from the frames they had."""

from pathlib import Path

import numpy as np
import pytest

from messaging.frames import Frame
from messaging.shape import Flag, ShapeEstimate
from nodal.replay.frame_sets import FrameSetRecord, pictured
from recordings.reader import Recorded

CAMERAS = ("a", "b", "c")
PERIOD_NS = 33_000_000
SILENT = range(20, 80)


class LogOfFrames:
    """Stands in for a log: frames alone, `lost` ones among them missing."""

    def __init__(self, lost=()):
        self._lost = lost

    def messages(self, _topics, begin_ns, end_ns):
        for n in range(100):
            for camera in CAMERAS:
                if (n, camera) not in self._lost and begin_ns <= n * PERIOD_NS <= end_ns:
                    yield self._recorded(n, camera)

    @staticmethod
    def _recorded(n, camera):
        frame = Frame(camera=camera, capture_time_ns=n * PERIOD_NS, jpeg=b"%d" % n)
        return Recorded(
            path=Path("log"),
            topic=f"camera/{camera}",
            schema=Frame.protobuf.DESCRIPTOR.full_name,
            log_time_ns=n * PERIOD_NS,
            publish_time_ns=n * PERIOD_NS,
            sequence=n,
            payload=frame.to_bytes(),
        )


def estimate_of(n, names):
    """No shape, but what it says of the cameras."""
    return ShapeEstimate(
        sequence=n,
        capture_time_ns=n * PERIOD_NS,
        capture_to_publish_ns=0,
        refusal="",
        method="refined",
        flags=(str(Flag.CAMERA_LOST),) if n in SILENT else (),
        arc_mm=np.zeros(0),
        centreline_mm=np.zeros((0, 3)),
        epipolar_angle_rad=np.zeros(0),
        node_names=(),
        node_arc_mm=np.zeros(0),
        node_mm=np.zeros((0, 3)),
        node_covariance_mm2=np.zeros((0, 3, 3)),
        length_mm=0.0,
        known_length_mm=0.0,
        insertion_mm=0.0,
        ray_gap_mm=0.0,
        ray_bias_mm=0.0,
        residual_px=0.0,
        camera_names=names,
        camera_residual_px=np.zeros(len(names)),
        visible_mm=np.zeros(len(names)),
        stage_names=(),
        stage_s=np.zeros(0),
    )


def records(refused=()):
    """Sets of which those while camera b was silent say so."""
    for n in range(100):
        names = ("a", "c") if n in SILENT else CAMERAS
        yield FrameSetRecord(
            sequence=n,
            capture_time_ns=n * PERIOD_NS,
            insertion_mm=0.0,
            base_known=True,
            publication=n,
            publish_time_ns=n * PERIOD_NS,
            log_time_ns=n * PERIOD_NS,
            estimate=estimate_of(n, () if n in refused else names),
        )


SILENCE = {(n, "b") for n in SILENT}


@pytest.mark.parametrize("refused", [(), range(30, 40)], ids=["estimated", "some refused"])
def test_sets_without_a_camera_are_those_that_say_so(refused):
    found = list(pictured(LogOfFrames(SILENCE), list(records(refused)), CAMERAS))
    assert [sorted(jpegs) for _, jpegs in found] == [
        ["a", "c"] if n in SILENT else ["a", "b", "c"] for n in range(100)
    ]
    assert all(set(jpegs.values()) == {b"%d" % record.sequence} for record, jpegs in found)


def test_a_frame_that_was_there_and_is_not_in_the_log_is_missing():
    lost = SILENCE | {(5, "b"), (25, "a")}
    found = list(pictured(LogOfFrames(lost), list(records()), CAMERAS))
    assert [record.sequence for record, jpegs in found if jpegs is None] == [5, 25]
