"""What sensing remembers from frame set to frame set: the last track, the nodal points asked for, the stage's height."""

import time
from collections.abc import Callable, Mapping

from messaging.control import TendonState
from messaging.shape import NodalPoints, ShapeEstimate
from sensing.memory import SensingMemory, TrackMemory
from sensing.method import Method
from sensing.refined.track import Track
from sensing.set_inputs import SetInputs
from sensing.shape import covered_nodes
from sensing.stage_height import StageHeight
from sensing.step import Clocks, step


class Sensor:
    """Turns frame sets into estimates, one after the other."""

    def __init__(
        self, method: Method, points: NodalPoints, robot_length_mm: float, stage_age_limit_s: float
    ) -> None:
        self._method = method
        self._robot_length_mm = robot_length_mm
        self._points = covered_nodes(points, robot_length_mm)
        self._height = StageHeight(stage_age_limit_s)
        self._track: Track | None = None
        self.lost: Mapping[str, str] = {}
        """By camera, why its picture in the newest set could not be used though there is an estimate."""

    def name_points(self, points: NodalPoints) -> None:
        """Report these nodal points from now on; raises NodalPointError when one is not on the robot."""
        self._points = covered_nodes(points, self._robot_length_mm)

    def heard(self, state: TendonState) -> None:
        """Take note of where the stage is."""
        self._height.heard(state)

    @property
    def memory(self) -> SensingMemory:
        """What the next estimate will start from."""
        return SensingMemory(
            track=None if self._track is None else TrackMemory.of(self._track), points=self._points
        )

    def estimate(
        self, jpegs: Mapping[str, bytes], sequence: int, capture_time_ns: int, age_ns: Callable[[], int]
    ) -> ShapeEstimate:
        """The estimate of one frame set (camera name to coded picture), or its refusal; `age_ns` is read when it is done."""
        insertion_mm, known = self._height.at(capture_time_ns)
        inputs = SetInputs(
            jpegs=jpegs,
            sequence=sequence,
            capture_time_ns=capture_time_ns,
            insertion_mm=insertion_mm,
            base_known=known,
            points=self._points,
        )
        clocks = Clocks(stage_s=time.perf_counter, age_ns=age_ns)
        estimate, self._track, self.lost = step(self._method, inputs, self._track, clocks)
        return estimate
