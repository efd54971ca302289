"""What sensing remembers from frame set to frame set: the last shape, the nodal points asked for, the stage's height."""

import time
from collections.abc import Callable, Mapping

from messaging.control import TendonState
from messaging.shape import Flag, NodalPoints, ShapeEstimate
from sensing.errors import SensingError
from sensing.pipeline import Scene, Shape, covered_nodes, estimate
from sensing.reporting import estimate_message, refusal_message
from sensing.stage_height import StageHeight


class Sensor:
    """Turns frame sets into estimates, one after the other."""

    def __init__(
        self, scene: Scene, points: NodalPoints, robot_length_mm: float, stage_age_limit_s: float
    ) -> None:
        self._scene = scene
        self._robot_length_mm = robot_length_mm
        self._points = covered_nodes(points, robot_length_mm)
        self._height = StageHeight(stage_age_limit_s)
        self._last: Shape | None = None

    def name_points(self, points: NodalPoints) -> None:
        """Report these nodal points from now on; raises NodalPointError when one is not on the robot."""
        self._points = covered_nodes(points, self._robot_length_mm)

    def heard(self, state: TendonState) -> None:
        """Take note of where the stage is."""
        self._height.heard(state)

    def estimate(
        self, jpegs: Mapping[str, bytes], sequence: int, capture_time_ns: int, age_ns: Callable[[], int]
    ) -> ShapeEstimate:
        """The estimate of one frame set (camera name to coded picture), or its refusal; `age_ns` is read when it is done."""
        insertion_mm, known = self._height.at(capture_time_ns)
        try:
            pictures = {name: self._scene.picture(name, data) for name, data in jpegs.items()}
            self._last = estimate(pictures, self._scene, insertion_mm, self._last, time.perf_counter)
            extra = () if known else (Flag.BASE_UNKNOWN,)
            return estimate_message(self._last, self._points, sequence, capture_time_ns, age_ns(), extra)
        except SensingError as error:
            self._last = None
            return refusal_message(error, sequence, capture_time_ns, age_ns(), insertion_mm)
