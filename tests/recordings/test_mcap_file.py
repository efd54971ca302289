"""The file that we build is what everybody else's readers expect, and stays readable where it is damaged."""

import io

import lz4.frame
import pytest
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from recordings.chunk import Packing
from recordings.mcap_file import REPEAT_NS, McapFile

START_NS = 1_700_000_000_000_000_000
STEP_NS = REPEAT_NS // 20
PACKINGS = {"none": Packing(), "lz4": Packing(name="lz4", compress=lz4.frame.compress)}


def written(packing=PACKINGS["none"], count=100):
    """A file of two channels, the second known from message 50 on; 10 messages a chunk, 20 in each repeat period."""
    stream = io.BytesIO()
    file = McapFile(stream, 2**30, packing)
    file.attachment("a.txt", "text/plain", b"attached", START_NS)
    file.metadata("NOTE", {"key": "value"})
    schema = file.schema("s", "raw", b"described")
    channels = [file.channel("first", "raw", schema)]
    for number in range(count):
        if number == 50:
            channels.append(file.channel("second", "raw", file.schema("t", "raw", b"")))
        channel = channels[number % len(channels)]
        file.message(channel, number, START_NS + STEP_NS * number, START_NS - number, b"%d" % number)
        if number % 10 == 9:
            file.end_chunk()
    return file, stream


def finished(**chosen):
    file, stream = written(**chosen)
    file.finish()
    return stream.getvalue()


@pytest.mark.parametrize("packing", PACKINGS.values(), ids=PACKINGS)
def test_the_librarys_readers_agree(packing):
    data = finished(packing=packing)
    reader = make_reader(io.BytesIO(data), validate_crcs=True)
    back = [
        (c.topic, s.name, m.sequence, m.log_time, m.publish_time, m.data)
        for s, c, m in reader.iter_messages()
    ]
    assert [one[2:] for one in back] == [
        (number, START_NS + STEP_NS * number, START_NS - number, b"%d" % number) for number in range(100)
    ]
    assert {one[:2] for one in back} == {("first", "s"), ("second", "t")}
    assert [(one.name, one.data) for one in reader.iter_attachments()] == [("a.txt", b"attached")]
    assert [(one.name, one.metadata) for one in reader.iter_metadata()] == [("NOTE", {"key": "value"})]
    summary = reader.get_summary()
    assert summary.statistics.channel_message_counts == {1: 75, 2: 25}
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (
        START_NS,
        START_NS + 99 * STEP_NS,
    )
    assert (len(summary.chunk_indexes), summary.statistics.chunk_count) == (10, 10)


def test_seeking_finds_what_lies_between_two_times():
    reader = make_reader(io.BytesIO(finished()))
    found = reader.iter_messages(
        ["second"], starting_at=START_NS + 60 * STEP_NS, ending_before=START_NS + 70 * STEP_NS
    )
    assert [message.sequence for _, _, message in found] == [61, 63, 65, 67, 69]


def test_the_sequential_reader_checks_every_sum():
    records = list(StreamReader(io.BytesIO(finished()), validate_crcs=True, emit_chunks=True).records)
    for chunk in records:
        if isinstance(chunk, Chunk):
            breakup_chunk(chunk, validate_crc=True)
    assert sum(isinstance(record, Chunk) for record in records) == 10


@pytest.mark.parametrize("lost", range(10))
def test_a_lost_chunk_takes_no_more_than_itself(lost):
    chunks = [
        record
        for record in StreamReader(io.BytesIO(finished()), emit_chunks=True).records
        if isinstance(record, Chunk)
    ]
    del chunks[lost]
    known, back = set(), []
    for record in (record for chunk in chunks for record in breakup_chunk(chunk)):
        if isinstance(record, (Schema, Channel)):
            known.add((type(record), record.id))
        elif isinstance(record, Message):
            assert {(Channel, record.channel_id), (Schema, record.channel_id)} <= known
            back.append(record.sequence)
    assert back == [number for number in range(100) if number // 10 != lost]


def test_descriptions_are_repeated_every_few_seconds_and_no_more_often():
    chunks = [
        breakup_chunk(record)
        for record in StreamReader(io.BytesIO(finished()), emit_chunks=True).records
        if isinstance(record, Chunk)
    ]
    described = [sum(isinstance(record, Schema) for record in chunk) for chunk in chunks]
    # chunks last half a period; one description is new in the first chunk, and one in the sixth
    assert described == [1, 1, 0, 1, 0, 2, 2, 0, 2, 0]


def test_messages_are_counted_by_the_bytes_that_hold_them():
    file, stream = written()
    assert file.messages_within(len(stream.getvalue())) == 100
    assert file.messages_within(100) == 0
    ends = [
        (index.chunk_start_offset + index.chunk_length)
        for index in make_reader(io.BytesIO(finished())).get_summary().chunk_indexes
    ]
    assert [file.messages_within(end) for end in ends] == list(range(10, 101, 10))
    assert [file.messages_within(end - 1) for end in ends] == list(range(0, 100, 10))
    file.message(1, 0, START_NS + 2 * REPEAT_NS, 0, b"")
    assert file.messages_within(2**40) == 100


def test_a_file_without_messages_is_a_file():
    stream = io.BytesIO()
    McapFile(stream, 2**20, Packing()).finish()
    assert make_reader(io.BytesIO(stream.getvalue())).get_summary().statistics.message_count == 0
