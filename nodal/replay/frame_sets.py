"""The frame sets that sensing estimated, with their pictures, out of a log; pictures are read one set at a time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from messaging import topics
from messaging.frames import Frame
from messaging.shape import Flag, ShapeEstimate
from nodal.replay.typed import read
from recordings.log import Log
from recordings.reader import Recorded

NEAR_NS = 1_000_000_000
"""A frame of a set was captured this close to the set's own time; numbers alone begin anew with each start of sensing."""
LOGGED_WITHIN_NS = 1_000_000_000
"""A frame is logged this close to its capture, or to the estimate made of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameSetRecord:
    """What the log says of one frame set that was estimated: its number, its time, and where sensing held the stage to be.

    `publication` is the number of its estimate on `shape`; the times are those of that estimate, Unix ns.
    """

    sequence: int
    capture_time_ns: int
    insertion_mm: float
    base_known: bool
    publication: int
    publish_time_ns: int
    log_time_ns: int
    estimate: ShapeEstimate | None
    """As logged; None for a set that was never estimated."""

    @property
    def age_ns(self) -> int:
        """From capture to estimate."""
        return 0 if self.estimate is None else self.estimate.capture_to_publish_ns

    def certain(self, cameras: Sequence[str]) -> Sequence[str]:
        """Of these cameras, those that had a frame in the set: all, unless the estimate says that some were lost.

        A lost one's frame is in the log if there was one, and could not be used.
        """
        if self.estimate is None or Flag.CAMERA_LOST not in self.estimate.flags:
            return cameras
        return self.estimate.camera_names

    @classmethod
    def of(cls, recorded: Recorded) -> "FrameSetRecord":
        """What a logged estimate says of its set; raises CodecError or InvalidMessageError."""
        estimate = read(recorded, ShapeEstimate)
        return cls(
            sequence=estimate.sequence,
            capture_time_ns=estimate.capture_time_ns,
            insertion_mm=estimate.insertion_mm,
            base_known=Flag.BASE_UNKNOWN not in estimate.flags,
            publication=recorded.sequence,
            publish_time_ns=recorded.publish_time_ns,
            log_time_ns=recorded.log_time_ns,
            estimate=estimate,
        )


def pictured(
    log: Log, sets: Sequence[FrameSetRecord], cameras: Sequence[str]
) -> Iterator[tuple[FrameSetRecord, dict[str, bytes] | None]]:
    """Each of these sets, in their order, with its coded pictures by camera; None when a frame of it is not in the log."""
    if not sets:
        return
    wanted = {record.sequence for record in sets}
    frames = log.messages(
        (topics.CAMERA,),
        min(record.log_time_ns - record.age_ns for record in sets) - LOGGED_WITHIN_NS,
        sets[-1].log_time_ns + LOGGED_WITHIN_NS,
    )
    waiting: dict[tuple[int, str], Frame] = {}
    for record in sets:
        keys = [(record.sequence, camera) for camera in cameras]
        while not all(_is_of(waiting.get(key), record) for key in keys):
            recorded = next(frames, None)
            if recorded is None:
                break
            if recorded.sequence in wanted:
                frame = read(recorded, Frame)
                waiting[recorded.sequence, frame.camera] = frame
            if recorded.log_time_ns > record.log_time_ns + LOGGED_WITHIN_NS:
                break
        jpegs = {key[1]: waiting[key].jpeg for key in keys if _is_of(waiting.get(key), record)}
        yield record, jpegs if jpegs.keys() >= set(record.certain(cameras)) else None
        earliest_ns = record.capture_time_ns - NEAR_NS
        waiting = {
            key: frame
            for key, frame in waiting.items()
            if key not in keys and frame.capture_time_ns >= earliest_ns
        }


def _is_of(frame: Frame | None, record: FrameSetRecord) -> bool:
    return frame is not None and abs(frame.capture_time_ns - record.capture_time_ns) < NEAR_NS


def never_estimated(log: Log, cameras: Sequence[str]) -> list[FrameSetRecord]:
    """The whole sets of a log in which nobody estimated anything, told apart by their numbers; the base's height is unknown."""
    captures: dict[int, dict[str, int]] = {}
    records: list[FrameSetRecord] = []
    for recorded in log.messages((topics.CAMERA,)):
        frame = read(recorded, Frame)
        captures.setdefault(recorded.sequence, {})[frame.camera] = frame.capture_time_ns
        if len(captures[recorded.sequence]) == len(cameras):
            times = captures.pop(recorded.sequence).values()
            records.append(
                FrameSetRecord(
                    sequence=recorded.sequence,
                    capture_time_ns=sum(times) // len(times),
                    insertion_mm=0.0,
                    base_known=False,
                    publication=len(records),
                    publish_time_ns=recorded.publish_time_ns,
                    log_time_ns=recorded.log_time_ns,
                    estimate=None,
                )
            )
    return records
