"""A recording as its user sees it: all its parts as one, in order of time, read as it is needed."""

import os
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from messaging.topics import Topic
from recordings.damage import Damage
from recordings.errors import DamagedRecordingError, UnreadableError
from recordings.parts import parts
from recordings.reader import Recorded, attachments, messages, metadata


class Log:
    """The recording at this path with the parts that follow it; a path that names a later part is that part alone.

    Raises UnreadableError when there is no such file. Times are log times, Unix ns.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.parts = parts(self.path)
        self.damage: list[Damage] = []
        if not self.parts:
            raise UnreadableError(self.path, "there is no such recording")

    def messages(
        self, topics: Collection[Topic] | None = None, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[Recorded]:
        """Every publication of these topics (None: of all) logged from `start_ns` on and before `end_ns`, by log time."""
        for part in self.parts:
            try:
                for recorded in messages(part, topics):
                    if (start_ns is None or recorded.log_time_ns >= start_ns) and (
                        end_ns is None or recorded.log_time_ns < end_ns
                    ):
                        yield recorded
            except DamagedRecordingError as error:
                self.damage.append(Damage(path=part, offset=error.offset, length=0, problem=str(error)))

    @cached_property
    def attachments(self) -> dict[str, bytes]:
        """The attached files by name, of the first part that holds any: bench file and calibration."""
        return next((found for part in self.parts if (found := attachments(part))), {})

    def metadata(self, name: str) -> dict[Path, dict[str, str]]:
        """The notes of this name (VERSIONS, SUMMARY) in each part; a part that holds none is left out."""
        notes = {part: metadata(part) for part in self.parts}
        return {part: note[name] for part, note in notes.items() if name in note}

    def arrays(self, topic: Topic, *fields: str) -> dict[str, NDArray[Any]]:
        """Fields of this topic's messages stacked over time, beside `log_time_ns`."""
        recorded = list(self.messages([topic]))
        columns: dict[str, NDArray[Any]] = {
            "log_time_ns": np.array([one.log_time_ns for one in recorded], np.int64)
        }
        return columns | {
            field: np.array([getattr(one.message, field) for one in recorded]) for field in fields
        }
