"""What belongs to one frame set: its pictures, the estimate made of them, and what the controller did with it. Pure."""

import dataclasses
from collections.abc import Iterator, Mapping

from messaging.control import ControllerState, Target
from messaging.frames import Frame
from messaging.message import Message
from messaging.shape import ShapeEstimate

SETTLED_NS = 500_000_000
"""So long after a frame set was logged, whatever belongs to it was logged too."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """One frame set. `shape` is None when it was not estimated; `state` is the controller's first that worked with it,
    or else what the controller did when the set came.
    """

    time_ns: int
    frames: Mapping[str, Frame]
    shape: ShapeEstimate | None
    state: ControllerState | None
    target: Target | None

    @property
    def acted_on(self) -> bool:
        """True when `state` tells of this very estimate."""
        return bool(self.shape and self.state and self.state.shape_sequence == self.shape.sequence)


@dataclasses.dataclass(kw_only=True, eq=False)
class _Draft:
    logged_ns: int
    meanwhile: ControllerState | None
    frames: dict[str, Frame] = dataclasses.field(default_factory=dict)
    shape: ShapeEstimate | None = None
    state: ControllerState | None = None


class Scenes:
    """Puts scenes together from publications in order of recording; holds what half a second brings, and no more.

    Frames and estimates of a set share their number. Sensing counts anew when it begins anew, which takes longer than a
    set is waited for, so numbers are unmistakable among those that wait.
    """

    def __init__(self) -> None:
        self._drafts: dict[int, _Draft] = {}
        self._targets: dict[str, Target] = {}
        self._newest: ControllerState | None = None

    def hear(self, sequence: int, logged_ns: int, message: Message) -> Iterator[Scene]:
        """One publication; yields the scenes that nothing can be added to any more."""
        yield from self._settled(logged_ns - SETTLED_NS)
        match message:
            case Frame() as frame:
                draft = self._drafts.setdefault(sequence, _Draft(logged_ns=logged_ns, meanwhile=self._newest))
                draft.frames[frame.camera] = frame
            case ShapeEstimate() as shape:
                if shape.sequence in self._drafts:
                    self._drafts[shape.sequence].shape = shape
            case ControllerState() as state:
                self._newest = state
                draft_seen = self._drafts.get(state.shape_sequence)
                if draft_seen and draft_seen.shape and draft_seen.state is None:
                    draft_seen.state = state
            case Target() as target:
                self._targets[target.name] = target

    def rest(self) -> Iterator[Scene]:
        """What is left at the end of the recording."""
        yield from self._settled(None)

    def _settled(self, until_ns: int | None) -> Iterator[Scene]:
        while self._drafts:
            sequence, draft = next(iter(self._drafts.items()))
            if until_ns is not None and draft.logged_ns > until_ns:
                return
            del self._drafts[sequence]
            state = draft.state or draft.meanwhile
            yield Scene(
                time_ns=min(frame.capture_time_ns for frame in draft.frames.values()),
                frames=draft.frames,
                shape=draft.shape,
                state=state,
                target=self._targets.get(state.target_name) if state else None,
            )
