"""A recording as its user reads it: parts as one, by time, as arrays and tables; files that others wrote."""

import dataclasses
import json

import numpy as np
import pytest
from mcap.writer import CompressionType, IndexType, Writer

from messaging import topics
from messaging.control import TendonCommand
from messaging.errors import CodecError
from messaging.frames import Frame
from messaging.shape import ShapeEstimate
from messaging.views import LogLine
from recordings import Log
from recordings.errors import DamagedRecordingError, FieldError, UnknownTopicError, UnreadableError
from recordings.part import Beginning, begin_part
from recordings.parts import GOES_ON_IN
from recordings.settings import RecorderSettings
from recordings.stored_chunk import HEAD
from recordings.writer import RecordingWriter

START_NS = 1_700_000_000_000_000_000
SECOND_NS = 1_000_000_000
SMALL = RecorderSettings(chunk_bytes=4096)


def command(number):
    return TendonCommand(
        time_ns=number,
        displacement_mm=[number, 0.5],
        insertion_mm=1.0,
        shape_sequence=number,
        capture_to_command_ns=0,
    )


def shape(number, nodes=("middle", "tip"), refusal=""):
    count = 0 if refusal else len(nodes)
    return ShapeEstimate(
        sequence=number,
        capture_time_ns=number,
        capture_to_publish_ns=1,
        refusal=refusal,
        method="refined",
        flags=(),
        arc_mm=[],
        centreline_mm=np.zeros((0, 3)),
        epipolar_angle_rad=[],
        node_names=nodes[:count],
        node_arc_mm=np.arange(count),
        node_mm=np.full((count, 3), number),
        node_covariance_mm2=np.zeros((count, 3, 3)),
        length_mm=80.0,
        known_length_mm=80.0,
        insertion_mm=0.0,
        ray_gap_mm=0.0,
        ray_bias_mm=0.0,
        residual_px=0.0,
        camera_names=(),
        camera_residual_px=[],
        visible_mm=[],
        stage_names=(),
        stage_s=[],
    )


def write(recording, topic, message, number, after_s=None):
    """The message `number`, logged that many seconds after the start."""
    time_ns = START_NS + int((number if after_s is None else after_s) * SECOND_NS)
    recording.write(
        topic.key,
        type(message).protobuf,
        message.to_bytes(),
        sequence=number,
        publish_time_ns=time_ns - 5,
        log_time_ns=time_ns,
    )


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def commands(path):
    """One command a second for 1000 seconds, in many chunks."""
    with RecordingWriter(path, SMALL) as recording:
        for number in range(1000):
            write(recording, topics.TENDON_COMMAND, command(number), number)
    return path


def cut_off(path):
    """The same file as a killed recorder leaves it."""
    path.write_bytes(path.read_bytes()[:-5000])
    return path


class TestTime:
    @pytest.mark.parametrize("ending", [lambda path: path, cut_off])
    @pytest.mark.parametrize(("start", "end"), [(0, 1), (500, 520), (499.5, 500.5), (-10, 3), (7, 7)])
    def test_a_span_is_from_and_before(self, commands, start, end, ending):
        found = Log(ending(commands)).messages(
            None, START_NS + int(start * SECOND_NS), START_NS + int(end * SECOND_NS)
        )
        assert [one.sequence for one in found] == [number for number in range(1000) if start <= number < end]

    def test_what_lies_outside_is_not_read(self, commands, monkeypatch):
        asked = []
        log = Log(commands)
        reader = log.files[0]
        assert reader.span_ns == log.span_ns == (START_NS, START_NS + 999 * SECOND_NS)
        monkeypatch.setattr(
            "recordings.file_reader.contents",
            lambda source, chunk, **options: asked.append(chunk) or original(source, chunk, **options),
        )
        from recordings.stored_chunk import contents as original  # noqa: PLC0415

        assert next(log.messages(None, START_NS + 700 * SECOND_NS)).sequence == 700
        [chunk] = asked
        assert chunk.start_ns <= START_NS + 700 * SECOND_NS <= chunk.end_ns

    def test_one_chunk_at_a_time(self, commands, monkeypatch):
        from recordings.stored_chunk import contents as original  # noqa: PLC0415

        read = []
        monkeypatch.setattr(
            "recordings.file_reader.contents",
            lambda source, chunk, **options: read.append(chunk.end_ns) or original(source, chunk, **options),
        )
        for one in Log(commands).messages():
            assert len(read) < 2 or read[-2] <= one.log_time_ns

    def test_topics_are_chosen(self, path):
        with RecordingWriter(path, SMALL) as recording:
            for number, name in enumerate(["left", "right", "left"]):
                frame = Frame(camera=name, capture_time_ns=1, jpeg=b"x")
                write(recording, topics.CAMERA.named(name), frame, number)
        log = Log(path)
        assert [one.sequence for one in log.messages([topics.CAMERA])] == [0, 1, 2]
        assert [one.sequence for one in log.messages([topics.CAMERA.named("left")])] == [0, 2]
        assert not list(log.messages([]))


class TestParts:
    def part(self, path, number, repeated, numbers, goes_on=""):
        file = path if number == 1 else path.with_name(f"{path.stem}.part{number}.mcap")
        beginning = Beginning(number=number, recording=path.name, because="", attachments={}, newest=())
        with begin_part(file, SMALL, beginning, START_NS) as recording:
            if number == 1:
                recording.attach("bench.toml", b"name = 'bench'", START_NS)
            for repeat in repeated:
                recording.write(
                    topics.LOG.key,
                    LogLine.protobuf,
                    b"",
                    sequence=repeat,
                    publish_time_ns=START_NS + repeat * SECOND_NS - 5,
                    log_time_ns=START_NS + min(numbers) * SECOND_NS,
                )
            for each in numbers:
                write(recording, topics.LOG, LogLine.of(time_ns=0, level=20, process="a", text=""), each)
            recording.describe("SUMMARY", {GOES_ON_IN: goes_on})
        return file

    def test_parts_follow_one_another_and_repeats_are_left_out(self, path):
        self.part(path, 1, (), range(5))
        self.part(path, 2, (4,), range(5, 9))
        self.part(path, 3, (8,), range(9, 12))
        log = Log(path)
        assert [one.sequence for one in log.messages()] == list(range(12))
        assert [file.name for file in log.parts] == ["a.mcap", "a.part2.mcap", "a.part3.mcap"]
        assert list(log.attachments) == ["bench.toml"]
        assert [note["number"] for note in log.metadata("PART").values()] == ["1", "2", "3"]
        assert not log.damage

    def test_a_span_over_parts_leaves_out_what_is_older(self, path):
        self.part(path, 1, (), range(5))
        self.part(path, 2, (1,), range(5, 9))
        found = Log(path).messages(None, START_NS + 3 * SECOND_NS)
        assert [one.sequence for one in found] == [3, 4, 5, 6, 7, 8]

    def test_a_later_part_by_its_name_stands_alone(self, path):
        self.part(path, 1, (), range(5))
        later = self.part(path, 2, (4,), range(5, 9))
        assert [one.sequence for one in Log(later).messages()] == [4, 5, 6, 7, 8]

    def test_a_missing_part_is_named(self, path):
        self.part(path, 1, (), range(5))
        self.part(path, 3, (), range(9, 12))
        log = Log(path)
        assert [one.sequence for one in log.messages()] == [0, 1, 2, 3, 4, 9, 10, 11]
        assert ["a.part2.mcap" in str(damage) for damage in log.damage] == [True]

    def test_no_recording_at_all(self, path):
        with pytest.raises(UnreadableError, match=r"a\.mcap: there is no such recording"):
            Log(path)


class TestArrays:
    @pytest.fixture
    def shapes(self, path):
        with RecordingWriter(path, SMALL) as recording:
            for number in range(10):
                write(recording, topics.SHAPE, shape(number), number)
            write(recording, topics.SHAPE, shape(10, refusal="the robot is out of view"), 10)
            write(recording, topics.SHAPE, shape(11, nodes=("tip",)), 11)
        return Log(path)

    def test_fields_are_stacked_with_times_and_numbers(self, commands):
        arrays = Log(commands).arrays(topics.TENDON_COMMAND, "displacement_mm", "shape_sequence")
        assert arrays["displacement_mm"].shape == (1000, 2)
        np.testing.assert_array_equal(arrays["displacement_mm"][:, 0], np.arange(1000))
        np.testing.assert_array_equal(arrays["log_sequence"], np.arange(1000))
        np.testing.assert_array_equal(arrays["log_time_ns"], START_NS + np.arange(1000) * SECOND_NS)
        np.testing.assert_array_equal(arrays["log_time_ns"] - 5, arrays["publish_time_ns"])
        assert arrays["shape_sequence"].dtype == np.int64

    def test_another_shape_is_never_filled_up(self, shapes):
        with pytest.raises(
            FieldError, match=r"node_mm does not have one shape in all 12 messages: \(2, 3\) in 10"
        ):
            shapes.arrays(topics.SHAPE, "node_mm")
        selected = shapes.arrays(
            topics.SHAPE, "node_mm", "refusal", select=lambda shape: shape.node_names == ("middle", "tip")
        )
        assert selected["node_mm"].shape == (10, 2, 3)
        assert set(selected["refusal"]) == {""}

    def test_what_has_one_shape_needs_no_choice(self, shapes):
        assert list(shapes.arrays(topics.SHAPE, "sequence")["sequence"]) == list(range(12))

    def test_an_unknown_field_is_named_with_those_that_there_are(self, shapes):
        with pytest.raises(FieldError, match=r"has no field 'tip_mm'; it has sequence, capture_time_ns"):
            shapes.arrays(topics.SHAPE, "tip_mm")

    def test_nothing_recorded_gives_empty_arrays(self, shapes):
        arrays = shapes.arrays(topics.TENDON_COMMAND, "displacement_mm")
        assert {name: len(array) for name, array in arrays.items()} == {
            "log_time_ns": 0,
            "publish_time_ns": 0,
            "log_sequence": 0,
            "displacement_mm": 0,
        }

    def test_bytes_and_cameras(self, path):
        with RecordingWriter(path, SMALL) as recording:
            for number, name in enumerate(["left", "right"]):
                frame = Frame(camera=name, capture_time_ns=1, jpeg=b"x\0")
                write(recording, topics.CAMERA.named(name), frame, number)
        arrays = Log(path).arrays(topics.CAMERA, "jpeg")
        assert list(arrays["jpeg"]) == [b"x\0", b"x\0"]
        assert list(arrays["topic"]) == ["camera/left", "camera/right"]

    def test_fields_of_what_viewers_draw(self, path):
        with RecordingWriter(path, SMALL) as recording:
            write(recording, topics.LOG, LogLine.of(time_ns=0, level=30, process="sense", text="hm"), 0)
        assert list(Log(path).arrays(topics.LOG, "message")["message"]) == ["hm"]

    def test_a_table_has_a_row_a_message(self, shapes):
        pytest.importorskip("pyarrow")
        table = shapes.table(topics.SHAPE)
        assert table.num_rows == 12
        assert table.column("log_time").cast("int64").to_pylist()[1] == START_NS + SECOND_NS
        assert table.column("node_mm").to_pylist()[3] == [[3.0, 3.0, 3.0], [3.0, 3.0, 3.0]]
        assert table.column("node_mm").to_pylist()[10] == []
        assert table.column("node_names").to_pylist()[11] == ["tip"]
        assert table.column("refusal").to_pylist()[10] == "the robot is out of view"

    def test_tables_of_nothing_and_of_what_viewers_draw(self, path):
        pytest.importorskip("pyarrow")
        with RecordingWriter(path, SMALL) as recording:
            write(recording, topics.LOG, LogLine.of(time_ns=0, level=30, process="sense", text="hm"), 0)
        log = Log(path)
        assert json.loads(log.table(topics.LOG).column("json").to_pylist()[0])["message"] == "hm"
        assert log.table(topics.SHAPE).num_rows == 0
        assert "node_mm" in log.table(topics.SHAPE).column_names


@dataclasses.dataclass
class Foreign:
    """How another producer writes."""

    options: dict
    name: str


FOREIGN = [
    Foreign({"compression": CompressionType.ZSTD}, "zstd"),
    Foreign({"compression": CompressionType.LZ4, "enable_crcs": False}, "lz4 without checksums"),
    Foreign({"use_chunking": False}, "without chunks"),
    Foreign({"use_chunking": False, "index_types": IndexType.NONE, "enable_crcs": False}, "bare"),
    Foreign({"compression": CompressionType.NONE, "index_types": IndexType.NONE}, "without an index"),
    Foreign({"use_statistics": False, "repeat_channels": False, "repeat_schemas": False}, "sparing"),
]


class TestOtherProducers:
    @pytest.fixture(params=FOREIGN, ids=lambda foreign: foreign.name)
    def foreign(self, request, path):
        """500 messages of an unknown topic, a known one with another schema, and one without any; late and early by turns."""
        with path.open("wb") as file:
            writer = Writer(file, chunk_size=2000, **request.param.options)
            writer.start(profile="ros2", library="another")
            schema = writer.register_schema("geometry/Pose", "ros2msg", b"float64 x")
            channels = [
                writer.register_channel("weather", "json", 0, {"unit": "K"}),
                writer.register_channel("shape", "cdr", schema),
            ]
            writer.add_attachment(1, 1, "notes.txt", "text/plain", b"hello")
            writer.add_metadata("about", {"who": "another"})
            for number in range(500):
                writer.add_message(
                    channels[number % 2],
                    START_NS + (number ^ 3) * 1000,
                    b'{"t": %d}' % number,
                    START_NS,
                    number,
                )
            writer.finish()
        return path

    def test_their_messages_come_undecoded_in_order_of_time(self, foreign):
        log = Log(foreign)
        found = list(log.messages())
        assert [one.sequence for one in found] == [number ^ 3 for number in range(500)]
        assert not log.damage
        assert {(one.topic, one.schema) for one in found} == {("weather", ""), ("shape", "geometry/Pose")}
        assert found[0].payload == b'{"t": 3}'
        for one in found[:4]:
            with pytest.raises(UnknownTopicError, match=r"knows no topic 'weather'|holds geometry/Pose"):
                _ = one.message
        assert log.attachments == {"notes.txt": b"hello"}
        assert log.metadata("about") == {foreign: {"who": "another"}}

    def test_spans_of_time(self, foreign):
        found = Log(foreign).messages(None, START_NS + 100_000, START_NS + 110_000)
        assert [one.log_time_ns - START_NS for one in found] == list(range(100_000, 110_000, 1000))

    def test_arrays_and_tables_pass_over_them(self, foreign):
        log = Log(foreign)
        assert len(log.arrays(topics.SHAPE, "node_mm")["node_mm"]) == 0
        pytest.importorskip("pyarrow")
        assert log.table(topics.SHAPE).num_rows == 0

    def test_cut_off_they_are_read_as_far_as_they_go(self, foreign):
        whole = [one.sequence for one in Log(foreign).messages()]
        data = foreign.read_bytes()
        for share in (0.3, 0.6, 0.9):
            foreign.write_bytes(data[: int(share * len(data))])
            log = Log(foreign)
            back = [one.sequence for one in log.messages()]
            assert set(back) <= set(whole)
            assert "cut off" in str(log.damage[-1])
        assert len(back) > 250

    def test_records_of_an_unknown_kind_are_passed_over(self, path):
        with path.open("wb") as file:
            writer = Writer(file, compression=CompressionType.NONE)
            writer.start(library="another")
            file.write(HEAD.pack(0x90, 20) + bytes(range(20)))
            channel = writer.register_channel("weather", "json", 0)
            writer.add_message(channel, START_NS, b"{}", START_NS)
            writer.finish()
        log = Log(path)
        assert len(list(log.messages())) == 1
        assert not log.damage


def test_a_message_that_is_none_is_refused_when_decoded(path):
    with RecordingWriter(path, SMALL) as recording:
        recording.write(
            topics.SHAPE.key,
            ShapeEstimate.protobuf,
            b"\xff",
            sequence=0,
            publish_time_ns=0,
            log_time_ns=START_NS,
        )
    with pytest.raises(CodecError):
        Log(path).arrays(topics.SHAPE, "sequence")


@pytest.mark.parametrize("data", [b"", b"\x89MCAP0\r\n"])
def test_a_recorder_that_was_killed_at_once_leaves_a_recording_of_nothing(path, data):
    path.write_bytes(data)
    log = Log(path)
    assert not list(log.messages())
    assert log.span_ns is None
    assert [damage.problem for damage in log.damage] == ["the file was cut off here, it has no end"]


def test_another_kind_of_file_is_refused(path):
    path.write_bytes(b"PK\x03\x04" + bytes(10_000))
    with pytest.raises(DamagedRecordingError, match="it is not an MCAP file"):
        list(Log(path).messages())
