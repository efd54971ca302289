"""Losses are what was numbered and never came: no more, no less."""

from hypothesis import given
from hypothesis import strategies as st

from recordings.losses import Gap, Losses


def settled(losses):
    return losses.settle() + losses.settle()


def heard(*sequences, key="shape", epoch=1):
    losses = Losses()
    for sequence in sequences:
        losses.hear(key, epoch, sequence)
    return losses


def test_a_gap_is_told_with_its_ends():
    assert settled(heard(5, 6, 9)) == [Gap(key="shape", first=7, last=8)]
    assert str(Gap(key="shape", first=7, last=8)) == "shape: 2 lost (sequence 7 to 8)"
    assert str(Gap(key="shape", first=7, last=7)) == "shape: 1 lost (sequence 7)"


def test_what_was_said_before_is_not_lost():
    assert settled(heard(1000, 1001)) == []


def test_a_restart_is_not_a_loss():
    losses = heard(0, 1, 2)
    losses.hear("shape", 2, 50)
    losses.hear("shape", 2, 51)
    losses.hear("shape", 3, 0)
    assert settled(losses) == []


def test_cameras_count_for_themselves():
    losses = Losses()
    for key, sequence in [("camera/left", 1), ("camera/right", 1), ("camera/left", 2), ("camera/right", 3)]:
        losses.hear(key, 9, sequence)
    assert settled(losses) == [Gap(key="camera/right", first=2, last=2)]
    assert losses.lost == {"camera/right": 1}


def test_a_latecomer_has_one_more_period_to_arrive():
    losses = heard(1, 3)
    assert losses.settle() == []
    losses.hear("shape", 1, 2)
    assert losses.settle() == []
    assert losses.lost == {}


def test_a_loss_is_told_once():
    losses = heard(1, 3)
    assert len(settled(losses)) == 1
    assert settled(losses) == []
    assert losses.lost == {"shape": 1}


def test_a_leap_of_numbers_costs_nothing():
    assert settled(heard(0, 2**63))[0].count == 2**63 - 1


@given(
    first=st.integers(0, 2**40),
    fates=st.lists(st.sampled_from(["heard", "heard", "lost", "twice", "late"]), min_size=1, max_size=60),
)
def test_every_loss_is_counted_whatever_else_happens(first, fates):
    fates = ["heard", *fates, "heard"]
    order = []
    for sequence, fate in enumerate(fates, first):
        place = sequence + (2.5 if fate == "late" else 0)
        order += [(place, sequence)] * {"lost": 0, "twice": 2}.get(fate, 1)
    losses = heard(*(sequence for _, sequence in sorted(order)))
    missing = {first + position for position, fate in enumerate(fates) if fate == "lost"}
    gaps = settled(losses)
    assert {sequence for gap in gaps for sequence in range(gap.first, gap.last + 1)} == missing
    assert sum(losses.lost.values()) == len(missing)
