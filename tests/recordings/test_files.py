"""What is written can be read: by us and by mcap's own reader, and on a full disk too."""

import dataclasses

import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from mcap.reader import make_reader

from messaging.control import TendonCommand
from messaging.errors import CodecError
from messaging.frames import Frame
from messaging.topics import CAMERA, LOG, SHAPE, TENDON_COMMAND, TOPICS
from recordings.errors import DamagedRecordingError, DiskFullError, UnknownTopicError, UnreadableError
from recordings.file_reader import FileReader
from recordings.metadata import sealed
from recordings.settings import RecorderSettings
from recordings.source import finished
from recordings.writer import RecordingWriter

START_NS = 1_700_000_000_000_000_000
JPEG = bytes(range(256)) * 20
COMMAND = TendonCommand(
    time_ns=1, displacement_mm=[1, 2, 3, 4], insertion_mm=5.0, shape_sequence=6, capture_to_command_ns=7
)


def record(path, count=40, **chosen):
    """A recording of frames and commands in turn, in several chunks; the payloads in order."""
    payloads = []
    with RecordingWriter(path, RecorderSettings(chunk_bytes=16384, **chosen)) as recording:
        recording.attach("bench.toml", b"name = 'bench'", START_NS)
        recording.describe("VERSIONS", {"nodal": "0"})
        for number in range(count):
            if number % 2:
                key, message = TENDON_COMMAND.key, dataclasses.replace(COMMAND, time_ns=number)
            else:
                key, message = "camera/left", Frame(camera="left", capture_time_ns=number, jpeg=JPEG)
            payloads.append(message.to_bytes())
            recording.write(
                key,
                type(message).protobuf,
                payloads[-1],
                sequence=2**32 + number,
                publish_time_ns=START_NS + number,
                log_time_ns=START_NS + 10 * number,
            )
    return payloads


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "a.mcap"
    return path, record(path)


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_everything_comes_back_in_order(tmp_path, compression):
    payloads = record(tmp_path / "a.mcap", compression=compression)
    back = list(FileReader(tmp_path / "a.mcap").messages())
    assert [one.payload for one in back] == payloads
    assert [one.sequence for one in back] == list(range(40))
    assert [one.publish_time_ns - START_NS for one in back] == list(range(40))
    assert [one.log_time_ns - START_NS for one in back] == list(range(0, 400, 10))
    assert back[0].message.jpeg == JPEG
    assert back[1].message == dataclasses.replace(COMMAND, time_ns=1)
    assert finished(tmp_path / "a.mcap")


def test_topics_are_chosen_from_the_table(recorded):
    path, _ = recorded
    assert {one.topic for one in FileReader(path).messages([CAMERA])} == {"camera/left"}
    assert len(list(FileReader(path).messages([CAMERA.named("left"), TENDON_COMMAND]))) == 40
    assert list(FileReader(path).messages([CAMERA.named("right"), SHAPE])) == []


def test_attachments_and_notes_come_back(recorded):
    path, _ = recorded
    assert FileReader(path).attachments() == {"bench.toml": b"name = 'bench'"}
    assert FileReader(path).metadata() == {"VERSIONS": sealed({"nodal": "0"})}


def test_mcaps_own_reader_agrees(recorded):
    path, payloads = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        counts = reader.get_summary().statistics
        assert (counts.message_count, counts.channel_count, counts.schema_count) == (40, 2, 2)
        assert [message.data for _, _, message in reader.iter_messages()] == payloads
        assert [attachment.name for attachment in reader.iter_attachments()] == ["bench.toml"]


def test_schemas_are_complete(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap", RecorderSettings()) as recording:
        for topic in TOPICS:
            recording.write(topic.key, topic.type.protobuf, b"", sequence=0, publish_time_ns=0, log_time_ns=0)
    with (tmp_path / "a.mcap").open("rb") as file:
        schemas = make_reader(file).get_summary().schemas.values()
    assert {schema.name for schema in schemas} == {
        topic.type.protobuf.DESCRIPTOR.full_name for topic in TOPICS
    }
    for schema in schemas:
        pool = DescriptorPool()
        for each in FileDescriptorSet.FromString(schema.data).file:
            pool.Add(each)
        assert pool.FindMessageTypeByName(schema.name).fields


@pytest.mark.parametrize("content", [b"PK\x03\x04 something else", b"\x89MCAP0\r\r"])
def test_other_files_are_not_recordings(tmp_path, content):
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(DamagedRecordingError, match=r"damaged at byte 0: .*not an MCAP file"):
        list(FileReader(tmp_path / "a.mcap").messages())


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(UnreadableError, match=r"nowhere\.mcap: it cannot be read: No such file"):
        list(FileReader(tmp_path / "nowhere.mcap").messages())


@pytest.mark.parametrize(
    ("key", "words"), [("weather", "knows no topic 'weather'"), (SHAPE.key, "holds nodal.TendonCommand")]
)
def test_what_this_version_does_not_know_is_kept_and_named(tmp_path, key, words):
    with RecordingWriter(tmp_path / "a.mcap", RecorderSettings()) as recording:
        recording.write(key, TendonCommand.protobuf, b"", sequence=0, publish_time_ns=0, log_time_ns=0)
    [one] = FileReader(tmp_path / "a.mcap").messages()
    with pytest.raises(UnknownTopicError, match=words):
        _ = one.message


def test_a_bad_payload_is_recorded_and_refused_only_when_decoded(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap", RecorderSettings()) as recording:
        recording.write(LOG.key, LOG.type.protobuf, b"\xff", sequence=0, publish_time_ns=0, log_time_ns=0)
    [one] = FileReader(tmp_path / "a.mcap").messages()
    assert one.payload == b"\xff"
    with pytest.raises(CodecError):
        _ = one.message


def test_a_full_disk_leaves_a_readable_recording(tmp_path, small_disk):
    path = tmp_path / "a.mcap"
    with small_disk(50_000), pytest.raises(DiskFullError, match=r"a\.mcap: no room is left"):
        record(path)
    back = list(FileReader(path).messages())
    assert len(back) >= 10
    assert FileReader(path).attachments()
    assert not finished(path)
