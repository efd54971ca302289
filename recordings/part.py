"""One file of a recording, which stands for itself: it begins with all that a reader of it alone needs to know."""

import platform
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path

from recordings.backlog import Heard
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

PACKAGES = (
    "nodal",
    "eclipse-zenoh",
    "foxglove-schemas-protobuf",
    "mcap",
    "numpy",
    "opencv-python-headless",
    "protobuf",
    "scipy",
)


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What a recording, or a part of one, holds: publications and losses by topic, its length in time and in bytes.

    `refused` counts publications without an envelope, which cannot be logged.
    """

    path: Path
    messages: Mapping[str, int]
    lost: Mapping[str, int]
    refused: int
    duration_s: float
    size_bytes: int

    def facts(self) -> dict[str, str]:
        """The same in words, for the recording's metadata."""
        return {
            **{f"messages/{key}": str(count) for key, count in self.messages.items()},
            **{f"lost/{key}": str(count) for key, count in self.lost.items()},
            "refused": str(self.refused),
            "duration_s": f"{self.duration_s:.3f}",
        }


@dataclass(frozen=True, kw_only=True)
class Beginning:
    """What stands at the beginning of a part.

    `newest` are the newest publications of the topics that are said seldom. They are repeated with the publish time and the
    sequence number that they had, and come first: the PART record says how many they are.
    """

    number: int
    recording: str
    because: str
    attachments: Mapping[str, bytes] = field(repr=False)
    newest: Collection[Heard] = field(repr=False)

    def facts(self) -> dict[str, str]:
        """For the PART record."""
        return {
            "number": str(self.number),
            "recording": self.recording,
            "because": self.because,
            "repeated": str(len(self.newest)),
        }


def begin_part(path: Path, settings: RecorderSettings, beginning: Beginning, now_ns: int) -> RecordingWriter:
    """A new file, begun; raises RecordingInUseError, RecordingExistsError or UnwritableError."""
    part = RecordingWriter(path, settings)
    for name, data in beginning.attachments.items():
        part.attach(name, data, now_ns)
    part.describe("VERSIONS", versions())
    part.describe("PART", beginning.facts())
    for heard in beginning.newest:
        write_heard(part, heard, now_ns)
    return part


def write_heard(part: RecordingWriter, heard: Heard, log_time_ns: int) -> None:
    """Write one publication as it was heard."""
    received = heard.received
    part.write(
        received.key,
        heard.topic.type.protobuf,
        received.payload,
        sequence=received.sequence,
        publish_time_ns=received.publish_time_ns,
        log_time_ns=log_time_ns,
    )


@cache
def versions() -> dict[str, str]:
    """What wrote a recording: the interpreter, the machine, and the packages that its numbers depend on."""
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "libc": " ".join(platform.libc_ver()),
        **{package: version(package) for package in PACKAGES},
    }
