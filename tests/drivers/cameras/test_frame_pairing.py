"""Frame sets from frames that come in any manner."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cameras import CameraFrame, FrameSetPairing, UnknownCameraError

MS = 1_000_000
PERIOD = 33 * MS
SKEW_S = 0.010


def frame(name: str, time_ns: int, number: int = 0) -> CameraFrame:
    return CameraFrame(name=name, jpeg=b"", capture_monotonic_ns=time_ns, number=number)


def feed(pairing: FrameSetPairing, *frames: CameraFrame) -> list:
    sets = [pairing.feed(one) for one in frames]
    return [one for one in sets if one is not None]


def times(frame_set) -> list[int]:
    return [one.capture_monotonic_ns for one in frame_set.frames]


def test_a_set_is_complete_with_its_last_frame_and_keeps_the_cameras_order() -> None:
    pairing = FrameSetPairing(("left", "right"), SKEW_S)
    assert feed(pairing, frame("right", 3 * MS)) == []
    (only,) = feed(pairing, frame("left", 0))
    assert [one.name for one in only.frames] == ["left", "right"]
    assert only.capture_monotonic_ns == 3 * MS // 2
    assert only.skew_s == pytest.approx(0.003)


def test_one_camera_alone_makes_sets_of_one() -> None:
    pairing = FrameSetPairing(("only",), SKEW_S)
    assert len(feed(pairing, *(frame("only", n * PERIOD) for n in range(1, 5)))) == 4


def test_a_frame_without_partner_is_dropped_and_counted() -> None:
    pairing = FrameSetPairing(("a", "b"), SKEW_S)
    (only,) = feed(pairing, frame("a", 0), frame("a", PERIOD), frame("b", PERIOD + MS))
    assert times(only) == [PERIOD, PERIOD + MS]
    assert pairing.unpaired == {"a": 1}


def test_the_nearer_of_two_waiting_frames_is_taken() -> None:
    pairing = FrameSetPairing(("a", "b"), 0.050)
    (only,) = feed(pairing, frame("a", 0), frame("a", PERIOD), frame("b", PERIOD - MS))
    assert times(only) == [PERIOD, PERIOD - MS]


def test_repeated_and_late_frames_are_counted_and_left_out() -> None:
    pairing = FrameSetPairing(("a", "b"), SKEW_S)
    sets = feed(
        pairing,
        frame("a", PERIOD),
        frame("a", PERIOD),
        frame("a", 5 * MS),
        frame("b", PERIOD),
        frame("b", 4 * MS),
    )
    assert len(sets) == 1
    assert pairing.out_of_order == {"a": 2, "b": 1}


def test_a_clock_that_jumps_back_starts_everything_anew() -> None:
    pairing = FrameSetPairing(("a", "b"), SKEW_S)
    hour = 3_600_000 * MS
    assert len(feed(pairing, frame("a", hour), frame("b", hour), frame("a", hour + PERIOD))) == 1
    sets = feed(pairing, frame("a", 0), frame("b", MS), frame("a", PERIOD), frame("b", PERIOD))
    assert [times(one) for one in sets] == [[0, MS], [PERIOD, PERIOD]]


def test_a_camera_that_comes_back_is_paired_again() -> None:
    pairing = FrameSetPairing(("a", "b"), SKEW_S)
    feed(pairing, *(frame("a", n * PERIOD) for n in range(100)))
    assert pairing.unpaired["a"] == 92
    sets = feed(pairing, frame("b", 99 * PERIOD), frame("a", 100 * PERIOD), frame("b", 100 * PERIOD))
    assert [times(one)[0] for one in sets] == [99 * PERIOD, 100 * PERIOD]


def names(frame_set) -> str:
    return "".join(one.name for one in frame_set.frames)


def test_a_camera_that_falls_silent_does_not_silence_two_others_and_is_taken_back() -> None:
    pairing = FrameSetPairing(("a", "b", "c"), SKEW_S)
    silent = range(10, 60)
    moments = {
        n: feed(pairing, *(frame(name, n * PERIOD) for name in "abc" if name != "b" or n not in silent))
        for n in range(80)
    }
    assert all([names(one) for one in moments[n]] == ["abc"] for n in (*range(10), *range(60, 80)))
    assert not any(moments[n] for n in range(10, 25))
    later = [one for n in range(25, 60) for one in moments[n]]
    assert {names(one) for one in later} == {"ac"}
    # what had piled up until then, and from then on every moment
    assert [times(one)[0] // PERIOD for one in later] == list(range(25 + 1 - 8, 60))
    assert pairing.unpaired == {"a": 8, "c": 8}


def test_a_camera_that_never_spoke_is_waited_for_and_then_left_out() -> None:
    pairing = FrameSetPairing(("a", "b", "c"), SKEW_S)
    first = feed(pairing, *(frame(name, n * PERIOD) for n in range(15) for name in "ab"))
    assert first == []
    after = feed(pairing, *(frame(name, n * PERIOD) for n in range(15, 20) for name in "ab"))
    assert {names(one) for one in after} == {"ab"}
    (whole,) = feed(pairing, *(frame(name, 20 * PERIOD) for name in "cab"))
    assert names(whole) == "abc"


def test_of_two_cameras_none_goes_on_alone() -> None:
    pairing = FrameSetPairing(("a", "b"), SKEW_S)
    assert feed(pairing, *(frame("a", n * PERIOD) for n in range(100))) == []


def test_an_unknown_camera_is_named() -> None:
    with pytest.raises(UnknownCameraError, match="camera c is not one of a, b"):
        FrameSetPairing(("a", "b"), SKEW_S).feed(frame("c", 0))


@given(
    phases=st.lists(st.integers(0, 9 * MS), min_size=1, max_size=4),
    lost=st.sets(st.tuples(st.integers(0, 3), st.integers(0, 19))),
    lag=st.lists(st.integers(0, 3), min_size=4, max_size=4),
)
def test_every_moment_that_all_cameras_saw_becomes_a_set(phases, lost, lag) -> None:
    """Whatever is lost, and whichever camera's frames arrive some periods later than another's."""
    names = "abcd"[: len(phases)]
    pairing = FrameSetPairing(tuple(names), SKEW_S)
    arrivals = sorted(
        ((n + lag[c]) * PERIOD + phase, c, n * PERIOD + phase)
        for c, phase in enumerate(phases)
        for n in range(20)
        if (c, n) not in lost
    )
    sets = feed(pairing, *(frame(names[c], captured) for _, c, captured in arrivals))
    whole = [n for n in range(20) if not any((c, n) in lost for c in range(len(phases)))]
    assert [times(one) for one in sets] == [[n * PERIOD + phase for phase in phases] for n in whole]
    in_sets = len(sets) * len(phases)
    waiting = sum(len(queue) for queue in pairing._waiting.values())
    assert in_sets + pairing.unpaired.total() + waiting == len(arrivals)
    assert pairing.out_of_order.total() == 0


@given(st.lists(st.tuples(st.sampled_from("abc"), st.integers(0, 5000).map(lambda t: t * MS)), max_size=200))
def test_sets_are_tight_and_use_no_frame_twice_whatever_comes(feeding) -> None:
    pairing = FrameSetPairing(("a", "b", "c"), SKEW_S)
    frames = [frame(name, time_ns, number) for number, (name, time_ns) in enumerate(feeding)]
    sets = feed(pairing, *frames)
    used = [one.number for frame_set in sets for one in frame_set.frames]
    assert len(used) == len(set(used))
    assert all(frame_set.skew_s <= SKEW_S for frame_set in sets)
    waiting = sum(len(queue) for queue in pairing._waiting.values())
    assert len(used) + pairing.unpaired.total() + pairing.out_of_order.total() + waiting == len(frames)
    assert all(len(queue) <= 8 for queue in pairing._waiting.values())
