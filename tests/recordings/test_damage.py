"""Files cut, overwritten, shortened and lengthened at random: every message of every whole chunk comes back, nothing else."""

import random
from dataclasses import dataclass
from pathlib import Path

import pytest

from messaging.control import TendonCommand
from messaging.frames import Frame
from messaging.shape import Truth
from recordings.errors import DamagedRecordingError
from recordings.file_reader import FileReader
from recordings.settings import RecorderSettings
from recordings.source import Source
from recordings.walk import walked
from recordings.writer import RecordingWriter

START_NS = 1_700_000_000_000_000_000
TOPICS = (("camera/left", Frame), ("tendon/command", TendonCommand), ("truth", Truth))
COUNT = 400
ROUNDS = 60


@dataclass
class Made:
    """A recording, its bytes, its messages, and which of them each chunk holds, by the chunk's first and last byte."""

    path: Path
    data: bytes
    messages: list[tuple]
    chunks: list[tuple[int, int, list[tuple]]]


def identity(one):
    return one.topic, one.log_time_ns, one.publish_time_ns, one.sequence, one.payload


def make(path, compression):
    chance = random.Random(7)
    with RecordingWriter(path, RecorderSettings(chunk_bytes=4096, compression=compression)) as recording:
        recording.attach("bench.toml", b"name = 'bench'\n" * 30, START_NS)
        recording.describe("VERSIONS", {"nodal": "0"})
        for number in range(COUNT):
            key, kind = TOPICS[number % 3]
            recording.write(
                key,
                kind.protobuf,
                chance.randbytes(chance.randrange(300)) + number.to_bytes(8, "little"),
                sequence=number // 3,
                publish_time_ns=START_NS + number * 10**8 - 5,
                log_time_ns=START_NS + number * 10**8,
            )
            if chance.random() < 0.02:
                recording.flush()
        recording.describe("SUMMARY", {"duration_s": "1"})
    return described(path)


def described(path):
    reader = FileReader(path)
    messages = [identity(one) for one in reader.messages()]
    assert not reader.damage
    with Source(path) as source:
        outline = walked(source)
    assert not outline.damage
    chunks = [
        (chunk.offset, chunk.end, [one for one in messages if chunk.start_ns <= one[1] <= chunk.end_ns])
        for chunk in outline.chunks
    ]
    return Made(path=path, data=path.read_bytes(), messages=messages, chunks=chunks)


@pytest.fixture(scope="module", params=["none", "lz4"])
def made(request, tmp_path_factory):
    made = make(tmp_path_factory.mktemp("whole") / "a.mcap", request.param)
    assert len(made.messages) == COUNT
    assert len(made.chunks) > 15
    assert sum(len(held) for _, _, held in made.chunks) == COUNT
    return made


@pytest.fixture
def spoilt(tmp_path):
    return tmp_path / "spoilt.mcap"


def check(made, spoilt, data, untouched):
    """What comes back of this data; `untouched` says of a chunk's first and last byte whether they are all in place."""
    spoilt.write_bytes(data)
    reader = FileReader(spoilt)
    due = [one for begin, end, held in made.chunks if untouched(begin, end) for one in held]
    try:
        back = [identity(one) for one in reader.messages()]
    except DamagedRecordingError:
        if due:
            raise
        return reader
    rest = iter(made.messages)
    assert all(one in rest for one in back), "wrong, twice or out of order"
    assert set(due) <= set(back), (
        f"lost: {sorted(one[3] for one in set(due) - set(back))}: {[str(one) for one in reader.damage]}"
    )
    if len(back) < len(made.messages):
        assert reader.damage, "lost silently"
    for damage in reader.damage:
        assert 0 <= damage.offset <= damage.offset + damage.length <= len(data)
        assert str(damage).startswith("spoilt.mcap, byte ")
    return reader


def test_a_file_cut_at_any_byte_gives_back_every_whole_chunk(made, spoilt):
    places = {0, 1, 7, 8, 9, len(made.data) - 1, *(place for chunk in made.chunks for place in chunk[:2])}
    places |= {
        place + shift for place in set(places) for shift in (-1, 1) if 0 <= place + shift < len(made.data)
    }
    chance = random.Random(1)
    for size in sorted(places | {chance.randrange(len(made.data)) for _ in range(ROUNDS)}):
        reader = check(made, spoilt, made.data[:size], lambda begin, end, size=size: end <= size)
        assert "cut off" in str(reader.damage[-1]), (size, reader.damage)


def test_flipped_bytes(made, spoilt):
    chance = random.Random(2)
    for _ in range(2 * ROUNDS):
        data = bytearray(made.data)
        places = {chance.randrange(len(data)) for _ in range(chance.choice([1, 1, 1, 2, 5]))}
        for place in places:
            data[place] ^= chance.randrange(1, 256)
        check(
            made, spoilt, data, lambda begin, end, places=places: not any(begin <= at < end for at in places)
        )


def test_flipped_bytes_in_heads_of_records_and_in_what_describes_the_file(made, spoilt):
    chance = random.Random(3)
    edges = [
        place for begin, end, _ in made.chunks for place in (*range(begin, begin + 64), *range(end, end + 30))
    ]
    for place in [*range(60), *chance.sample(edges, ROUNDS), *range(len(made.data) - ROUNDS, len(made.data))]:
        data = bytearray(made.data)
        data[place] ^= chance.choice([1, 0x80, 0xFF])
        check(made, spoilt, data, lambda begin, end, place=place: not begin <= place < end)


def test_a_damaged_head_of_a_record_takes_no_message(made, spoilt):
    for begin, _, _ in made.chunks:
        for place in range(begin, begin + 9):
            data = bytearray(made.data)
            data[place] ^= 0x55
            reader = check(made, spoilt, data, lambda *_: True)
            assert [damage.problem for damage in reader.damage] == [
                "the head of a chunk is damaged; its messages are whole"
            ]


@pytest.mark.parametrize("finished", [True, False])
@pytest.mark.parametrize("kind", ["zeros", "noise", "another place"])
def test_overwritten_stretches(made, spoilt, kind, finished):
    chance = random.Random(kind)
    size = len(made.data) if finished else made.chunks[-1][1]
    for _ in range(ROUNDS):
        data = bytearray(made.data[:size])
        begin = chance.randrange(size)
        length = min(int(2 ** chance.uniform(0, 15)), size - begin)
        origin = chance.randrange(size - length + 1)
        by = {"zeros": bytes(length), "noise": chance.randbytes(length)}
        data[begin : begin + length] = by.get(kind, made.data[origin : origin + length])
        end = begin + length
        check(made, spoilt, data, lambda first, last, begin=begin, end=end: last <= begin or first >= end)


@pytest.mark.parametrize("finished", [True, False])
@pytest.mark.parametrize("kind", ["lost", "inserted", "doubled"])
def test_lost_inserted_and_doubled_stretches(made, spoilt, kind, finished):
    chance = random.Random(kind)
    size = len(made.data) if finished else made.chunks[-1][1]
    whole = made.data[:size]
    for _ in range(ROUNDS):
        begin = chance.randrange(size)
        end = begin + min(int(2 ** chance.uniform(0, 15)), size - begin)
        if kind == "lost":
            data = whole[:begin] + whole[end:]
            check(made, spoilt, data, lambda first, last, a=begin, b=end: last <= a or first >= b)
            continue
        added = chance.randbytes(end - begin) if kind == "inserted" else whole[begin:end]
        check(
            made, spoilt, whole[:end] + added + whole[end:], lambda first, last, at=end: not first < at < last
        )


def test_chunks_that_were_doubled_whole_come_once(made, spoilt):
    begin, end, _ = made.chunks[3]
    reader = check(made, spoilt, made.data[:end] + made.data[begin:end] + made.data[end:], lambda *_: True)
    assert "a chunk that stands in the file twice" in {damage.problem for damage in reader.damage}


def test_chunks_that_changed_places_come_in_order(made, spoilt):
    (a, _, _), (b, _, _), (c, _, _) = made.chunks[3:6]
    data = made.data
    check(made, spoilt, data[:a] + data[b:c] + data[a:b] + data[c:], lambda *_: True)


@pytest.mark.parametrize("length", [2**60, 2**64 - 1, 2**40, 2**31])
def test_absurd_lengths(made, spoilt, length):
    for begin, end, _ in made.chunks[:5]:
        for place in (begin + 1, begin + 25, begin + 41, begin + 45, end + 1):
            data = bytearray(made.data)
            data[place : place + 8] = length.to_bytes(8, "little")
            for size in (len(data), made.chunks[-1][1]):
                check(
                    made,
                    spoilt,
                    data[:size],
                    lambda a, b, place=place, size=size: b <= size and not a <= place < b,
                )


def test_a_chunk_without_its_checksum_is_not_believed(made, spoilt):
    begin, end, held = made.chunks[2]
    data = bytearray(made.data)
    data[begin + 33 : begin + 37] = bytes(4)
    for size in (len(data), made.chunks[-1][1]):
        reader = check(made, spoilt, data[:size], lambda a, b, size=size: a != begin and b <= size)
        [damage] = [damage for damage in reader.damage if damage.offset == begin]
        assert (damage.length, sum(damage.missing.values())) == (end - begin, len(held))
        assert damage.start_ns == made.chunks[1][2][-1][1]
        assert damage.end_ns == made.chunks[3][2][0][1]


def test_what_is_missing_is_said_in_words(made, spoilt):
    begin, end, held = made.chunks[2]
    data = bytearray(made.data)
    data[end - 5] ^= 1
    [damage] = check(made, spoilt, data, lambda a, _: a != begin).damage
    words = str(damage)
    assert words.startswith(f"spoilt.mcap, byte {begin} to {end}: a damaged chunk: its contents do not agree")
    assert "; between 22:13:" in words
    for topic, _ in TOPICS:
        assert f"{sum(one[0] == topic for one in held)} of {topic}" in words


def test_damaged_times_in_a_chunks_head_hide_no_message(made, spoilt):
    cut = made.chunks[-1][1] + 10
    for begin, _, held in made.chunks[:-1]:
        for place in range(begin + 9, begin + 25, 3):
            data = bytearray(made.data[:cut])
            data[place] ^= 0x41
            spoilt.write_bytes(data)
            back = FileReader(spoilt).messages(None, held[0][1], held[-1][1] + 1)
            assert [identity(one) for one in back] == held


def test_the_first_chunk_may_be_lost_with_all_that_describes_the_rest(made, spoilt):
    data = bytearray(made.data)
    begin, end, _ = made.chunks[0]
    data[begin:end] = bytes(end - begin)
    for size in (len(data), made.chunks[-1][1]):
        check(made, spoilt, data[:size], lambda a, b, size=size: a != begin and b <= size)


def test_attachments_and_metadata_are_whole_or_left_out(made, spoilt):
    chance = random.Random(5)
    for _ in range(ROUNDS):
        data = bytearray(made.data[: chance.choice([len(made.data), made.chunks[-1][1]])])
        place = chance.randrange(made.chunks[0][0])
        data[place] ^= chance.randrange(1, 256)
        spoilt.write_bytes(data)
        reader = FileReader(spoilt)
        assert reader.attachments() in ({"bench.toml": b"name = 'bench'\n" * 30}, {})
        known = reader.metadata()
        assert known.get("VERSIONS", {"nodal": "0"})["nodal"] == "0"
        assert len(known) + len(reader.attachments()) >= (2 if len(data) == len(made.data) else 1)


def test_changed_metadata_is_left_out_and_named(made, spoilt):
    place = made.data.index(b"nodal", made.data.index(b"VERSIONS")) + 9
    assert made.data[place : place + 1] == b"0"
    for size in (len(made.data), made.chunks[-1][1]):
        data = bytearray(made.data[:size])
        data[place] ^= 1
        reader = check(made, spoilt, data, lambda _, end, size=size: end <= size)
        assert "VERSIONS" not in reader.metadata()
        assert "a damaged record: metadata" in {damage.problem for damage in reader.damage}


def test_what_looks_like_a_chunk_inside_a_damaged_one_hides_none_behind_it(made, spoilt):
    cut = made.chunks[-1][1]
    (begin, end, _), (_, far, _) = made.chunks[2], made.chunks[6]
    length = far - (begin + 200) - 9
    lie = b"\x06" + length.to_bytes(8, "little") + bytes(28) + bytes(4) + (length - 40).to_bytes(8, "little")
    data = bytearray(made.data[:cut])
    data[begin : begin + 9] = bytes(9)
    data[begin + 200 : begin + 200 + len(lie)] = lie
    assert begin + 200 + len(lie) < end
    check(made, spoilt, data, lambda first, last: first != begin and last <= cut)
