"""The frames of one camera in a recording of a bench, with the times at which they were captured."""

import logging
import struct
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from drivers.cameras.errors import CameraError
from drivers.cameras.files.picture import FilePicture
from messaging.errors import CodecError
from messaging.frames import Frame
from messaging.topics import CAMERA

logger = logging.getLogger(__name__)

SCHEMA = Frame.protobuf.DESCRIPTOR.full_name


def pictures_in_recording(file: Path, camera: str) -> Iterator[FilePicture]:
    """In their order, up to the first damage; raises CameraError when the file has none of this camera, or is no recording."""
    frames = _frames(file, camera)
    first = next(frames, None)
    if first is None:
        raise CameraError(
            f"{file}: no frame of camera {camera} can be read; cameras in it: {', '.join(_cameras(file)) or 'none'}"
        )
    return _with(first, frames)


def _with(first: FilePicture, others: Iterator[FilePicture]) -> Iterator[FilePicture]:
    yield first
    yield from others


def _frames(file: Path, camera: str) -> Iterator[FilePicture]:
    for topic, sequence, payload in _messages(file):
        if topic != CAMERA.named(camera).key:
            continue
        try:
            frame = Frame.from_bytes(payload)
        except CodecError as error:
            logger.warning("%s: frame %d of camera %s: %s", file, sequence, camera, error)
            continue
        yield FilePicture(offset_ns=frame.capture_time_ns, number=sequence, jpeg=partial(bytes, frame.jpeg))


def _cameras(file: Path) -> list[str]:
    beginning = CAMERA.key.removesuffix("*")
    return sorted({topic.removeprefix(beginning) for topic, _, _ in _messages(file)})


def _messages(file: Path) -> Iterator[tuple[str, int, bytes]]:
    """Topic, sequence number and bytes of every frame of any camera; ends at the first damage, which is logged."""
    from mcap.exceptions import InvalidMagic, McapError  # noqa: PLC0415  not everybody who reads settings has it
    from mcap.records import Channel, Message, Schema  # noqa: PLC0415
    from mcap.stream_reader import StreamReader  # noqa: PLC0415

    schemas: set[int] = set()
    topics: dict[int, str] = {}
    try:
        with file.open("rb") as stream:
            for record in StreamReader(stream).records:
                match record:
                    case Schema() if record.name == SCHEMA:
                        schemas.add(record.id)
                    case Channel() if record.schema_id in schemas:
                        topics[record.id] = record.topic
                    case Message() if record.channel_id in topics:
                        yield topics[record.channel_id], record.sequence, record.data
    except OSError as error:
        raise CameraError(f"{file}: cannot be read: {error.strerror}") from error
    except InvalidMagic as error:
        raise CameraError(f"{file}: not a recording (MCAP)") from error
    except (McapError, struct.error, ValueError, RuntimeError) as error:
        logger.warning("%s is damaged or cut off; its frames were read up to there (%s)", file, repr(error))
