"""Writes a bench's publications into an MCAP file: message bytes as they came over the wire, one channel a topic."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

import lz4.frame
from google.protobuf.message import Message as ProtobufMessage
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap_protobuf.schema import build_file_descriptor_set

from recordings.chunk import Packing
from recordings.errors import UnwritableError
from recordings.mcap_file import McapFile
from recordings.metadata import sealed
from recordings.output import Output
from recordings.settings import RecorderSettings
from recordings.write_behind import WriteBehind

PACKINGS = {"none": Packing(), "lz4": Packing(name="lz4", compress=lz4.frame.compress)}
LARGEST_SEQUENCE = 2**32
"""MCAP keeps 32 bits of a sequence number."""
MEDIA_TYPES = {".json": "application/json", ".png": "image/png", ".jpg": "image/jpeg"}


class RecordingWriter:
    """A new recording; used in a `with` statement, which finishes the file unless writing it failed.

    One thread owns it, and never waits for the disk but at the end: the file is written in another, and every method
    raises the DiskFullError, DeletedError or UnwritableError that was met there. The file then ends with its last whole
    record and can still be read. Times are Unix ns.
    """

    def __init__(self, path: Path, settings: RecorderSettings) -> None:
        """Create the file; raises RecordingInUseError, RecordingExistsError or UnwritableError."""
        self.path = path
        self.messages: Counter[str] = Counter()
        self._disk = WriteBehind(Output(path))
        self._mcap = McapFile(self._disk, settings.chunk_bytes, PACKINGS[settings.compression])
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def attach(self, name: str, data: bytes, time_ns: int) -> None:
        """Put a file into the recording."""
        self._mcap.attachment(name, media_type(name), data, time_ns)

    def describe(self, name: str, facts: Mapping[str, str]) -> None:
        """Add a metadata record, with its checksum."""
        self._mcap.metadata(name, sealed(facts))

    def write(
        self,
        key: str,
        kind: type[ProtobufMessage],
        payload: bytes,
        *,
        sequence: int,
        publish_time_ns: int,
        log_time_ns: int,
    ) -> None:
        """Log one publication whose payload claims to be of this kind; it is not looked into. Log times never decrease."""
        self.messages[key] += 1
        channel = self._channels.get(key) or self._channel(key, kind)
        self._mcap.message(channel, sequence % LARGEST_SEQUENCE, log_time_ns, publish_time_ns, payload)

    def flush(self) -> None:
        """Close the chunk and ask for the file to be kept: neither kill -9 nor a power cut can take it once that is done."""
        self._mcap.end_chunk()
        self._disk.sync()

    def finish(self) -> None:
        """End the file with its summary and footer; nothing can be added any more."""
        self._mcap.finish()
        self._disk.end()

    def give_up(self) -> None:
        """Let go of the file as it is."""
        self._disk.end()

    def closed(self, timeout_s: float | None = None) -> bool:
        """True once the file, after `finish` or `give_up`, waits for the disk no longer; raises what went wrong."""
        closed = self._disk.wait(timeout_s)
        self._disk.check()
        return closed

    @property
    def size_bytes(self) -> int:
        """Bytes in the file so far, with those that wait for the disk."""
        return self._disk.tell()

    @property
    def waiting_bytes(self) -> int:
        """Bytes that wait for the disk."""
        return self._disk.waiting_bytes

    @property
    def unwritten(self) -> int:
        """How many publications are not in the file: they wait for the disk, or were lost with it."""
        return self.messages.total() - self._mcap.messages_within(self._disk.written_bytes)

    def __enter__(self) -> Self:
        """The recording, ready to be written."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the file, unless it could not be written; wait for it."""
        if isinstance(error, UnwritableError):
            self.give_up()
            self._disk.wait()
            return
        self.finish()
        self.closed()

    def _channel(self, key: str, kind: type[ProtobufMessage]) -> int:
        name = kind.DESCRIPTOR.full_name
        if name not in self._schemas:
            described = build_file_descriptor_set(kind).SerializeToString()
            self._schemas[name] = self._mcap.schema(name, SchemaEncoding.Protobuf, described)
        self._channels[key] = self._mcap.channel(key, MessageEncoding.Protobuf, self._schemas[name])
        return self._channels[key]


def media_type(name: str) -> str:
    """Of an attached file, by its name."""
    return MEDIA_TYPES.get(Path(name).suffix, "text/plain")
