"""Frames that were taken together: one of each camera, nearest to one another in capture time. Pure.

The cameras run freely, so frames are matched by their capture times, never by their order of arrival. When the oldest
waiting frame lies too far from another camera's oldest one, it has lost its partner for good: what comes later is later
still.

A camera that falls silent does not silence the others: when its newest frame is older than theirs by ABSENT_S, they make
sets without it while they are two at least, until it is back. Only capture times decide, never when a frame arrived.
"""

import dataclasses
from collections import Counter, deque
from collections.abc import Sequence

from drivers.cameras.camera import CameraFrame
from drivers.cameras.errors import UnknownCameraError

WAITING_AT_MOST = 8
NEW_CLOCK_S = 1.0
ABSENT_S = 0.5
LEAST_CAMERAS = 2
NS_PER_S = 1e9


def worst_skew_periods(cameras: int) -> float:
    """How far apart in time, in periods of a frame, sets of so many cameras at the same rate can be at worst.

    The cameras' moments divide a period into as many gaps as there are cameras; the largest, which a set goes around, is
    shortest when all are the same.
    """
    return 1 - 1 / cameras


@dataclasses.dataclass(frozen=True, kw_only=True)
class FrameSet:
    """One frame of each camera that is not absent, in the cameras' order."""

    frames: tuple[CameraFrame, ...]

    @property
    def capture_monotonic_ns(self) -> int:
        """The mean of the capture times, on the host's CLOCK_MONOTONIC."""
        return sum(frame.capture_monotonic_ns for frame in self.frames) // len(self.frames)

    @property
    def skew_s(self) -> float:
        """Between the first and the last capture."""
        times_ns = [frame.capture_monotonic_ns for frame in self.frames]
        return (max(times_ns) - min(times_ns)) / NS_PER_S


class FrameSetPairing:
    """Feed it frames as they come; it gives sets as they become complete.

    `unpaired` and `out_of_order` count the frames of each camera that went into no set: those without a partner, and
    those that came repeatedly, or later than a newer one. A camera whose times jump back by more than a second has a new
    clock, and everybody starts anew.
    """

    def __init__(self, names: Sequence[str], maximum_skew_s: float) -> None:
        self.names = tuple(names)
        self.maximum_skew_s = maximum_skew_s
        self._maximum_skew_ns = maximum_skew_s * NS_PER_S
        self._waiting: dict[str, deque[CameraFrame]] = {name: deque() for name in names}
        self._present = dict(self._waiting)
        self._newest_ns: dict[str, int] = {}
        self._begun_ns = 0
        self.unpaired: Counter[str] = Counter()
        self.out_of_order: Counter[str] = Counter()

    def feed(self, frame: CameraFrame) -> FrameSet | None:
        """The set that this frame completes, if any; raises UnknownCameraError."""
        if frame.name not in self._waiting:
            raise UnknownCameraError(f"camera {frame.name} is not one of {', '.join(self._waiting)}")
        newest_ns = self._newest_ns.get(frame.name)
        if newest_ns is not None and frame.capture_monotonic_ns <= newest_ns:
            if newest_ns - frame.capture_monotonic_ns < NEW_CLOCK_S * NS_PER_S:
                self.out_of_order[frame.name] += 1
                return None
            self._start_anew()
        self._begun_ns = self._begun_ns if self._newest_ns else frame.capture_monotonic_ns
        self._newest_ns[frame.name] = frame.capture_monotonic_ns
        queue = self._waiting[frame.name]
        queue.append(frame)
        if len(queue) > WAITING_AT_MOST:
            self._drop_oldest(frame.name)
        self._present = self._those_present()
        return self._complete_set()

    def _those_present(self) -> dict[str, deque[CameraFrame]]:
        """The queues of the cameras of the next sets: all, or those two or more that go on while another is silent."""
        newest_ns = max(self._newest_ns.values())
        present = {
            name: queue
            for name, queue in self._waiting.items()
            if newest_ns - self._newest_ns.get(name, self._begun_ns) < ABSENT_S * NS_PER_S
        }
        if len(present) < LEAST_CAMERAS:
            return self._waiting
        for name in self._waiting.keys() - present.keys():
            self._drop_all(name)
        return present

    def _complete_set(self) -> FrameSet | None:
        while all(self._present.values()):
            oldest = min(self._present, key=lambda name: self._waiting[name][0].capture_monotonic_ns)
            if self._skew_ns() <= self._maximum_skew_ns and not self._next_is_nearer(oldest):
                return FrameSet(frames=tuple(queue.popleft() for queue in self._present.values()))
            self._drop_oldest(oldest)
        return None

    def _next_is_nearer(self, oldest: str) -> bool:
        queue = self._waiting[oldest]
        if len(queue) < 2:
            return False
        skew_ns = self._skew_ns()
        first = queue.popleft()
        nearer = self._skew_ns() < skew_ns
        queue.appendleft(first)
        return nearer

    def _skew_ns(self) -> int:
        times_ns = [queue[0].capture_monotonic_ns for queue in self._present.values()]
        return max(times_ns) - min(times_ns)

    def _drop_oldest(self, name: str) -> None:
        self._waiting[name].popleft()
        self.unpaired[name] += 1

    def _start_anew(self) -> None:
        for name in self._waiting:
            self._drop_all(name)
        self._newest_ns.clear()

    def _drop_all(self, name: str) -> None:
        while self._waiting[name]:
            self._drop_oldest(name)
