"""Writes a bench's publications into an MCAP file: message bytes as they came over the wire, one channel a topic."""

from collections import Counter
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from google.protobuf.message import Message as ProtobufMessage
from mcap.well_known import MessageEncoding
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import register_schema

from recordings.errors import UnwritableError
from recordings.output import Output
from recordings.settings import RecorderSettings

COMPRESSION = {"none": CompressionType.NONE, "lz4": CompressionType.LZ4}
LARGEST_SEQUENCE = 2**32
"""MCAP keeps 32 bits of a sequence number."""


class RecordingWriter:
    """A new recording; used in a `with` statement, which finishes the file unless writing it failed.

    One thread owns it. Every method raises DiskFullError or UnwritableError; the file then ends with its last whole
    record and can still be read. Times are Unix ns.
    """

    def __init__(self, path: Path, settings: RecorderSettings) -> None:
        """Create the file; raises RecordingInUseError, RecordingExistsError or UnwritableError."""
        self.path = path
        self.messages: Counter[str] = Counter()
        with ExitStack() as undo:
            self._output = undo.enter_context(Output(path))
            self._mcap = Writer(
                self._output,  # type: ignore[arg-type]  # it writes, tells and flushes; the library asks for no more
                chunk_size=settings.chunk_bytes,
                compression=COMPRESSION[settings.compression],
            )
            self._mcap.start(profile="", library="nodal")
            undo.pop_all()
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def attach(self, name: str, data: bytes, time_ns: int) -> None:
        """Put a file into the recording."""
        media_type = "application/json" if name.endswith(".json") else "text/plain"
        self._mcap.add_attachment(time_ns, time_ns, name, media_type, data)

    def describe(self, name: str, facts: Mapping[str, str]) -> None:
        """Add a metadata record."""
        self._mcap.add_metadata(name, dict(facts))

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
        """Log one publication whose payload claims to be of this kind; it is not looked into."""
        self._mcap.add_message(
            channel_id=self._channel(key, kind),
            log_time=log_time_ns,
            data=payload,
            publish_time=publish_time_ns,
            sequence=sequence % LARGEST_SEQUENCE,
        )
        self.messages[key] += 1

    def flush(self) -> None:
        """Close the chunk and have the device keep it: from now on neither kill -9 nor a power cut can take it."""
        self._mcap.flush()  # type: ignore[no-untyped-call]
        self._output.sync()

    @property
    def size_bytes(self) -> int:
        """Bytes in the file so far."""
        return self._output.tell()

    def __enter__(self) -> Self:
        """The recording, ready to be written."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the file with its summary and footer, unless it could not be written; let go of it."""
        with self._output:
            if not isinstance(error, UnwritableError):
                self._mcap.finish()  # type: ignore[no-untyped-call]
                self._output.sync()

    def _channel(self, key: str, kind: type[ProtobufMessage]) -> int:
        if key not in self._channels:
            name = kind.DESCRIPTOR.full_name
            if name not in self._schemas:
                self._schemas[name] = register_schema(self._mcap, kind)
            self._channels[key] = self._mcap.register_channel(
                key, MessageEncoding.Protobuf, self._schemas[name]
            )
        return self._channels[key]
