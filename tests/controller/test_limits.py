"""Nothing leaves the limits that is not finite, too far or too fast; what is cut short is said."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from controller.errors import CommandNotFiniteError
from controller.limits import Limits
from controller.settings import LimitSettings

LIMITS = Limits(
    LimitSettings(displacement_mm=5.0, insertion_mm=(0.0, 40.0), displacement_mm_s=4.0, insertion_mm_s=20.0),
    4,
)
DT_S = 0.005
anything = arrays(np.float64, 5, elements=st.floats(width=64, allow_nan=True, allow_infinity=True))
inside = arrays(np.float64, 5, elements=st.floats(0.0, 5.0))


@given(anything, inside)
def test_whatever_is_asked_what_is_sent_is_finite_near_and_slow(asked, previous):
    try:
        sent = LIMITS.apply(asked, previous, DT_S).command_mm
    except CommandNotFiniteError:
        assert not np.isfinite(asked).all()
        return
    assert np.isfinite(asked).all()
    assert (sent >= LIMITS.low_mm).all()
    assert (sent <= LIMITS.high_mm).all()
    assert (np.abs(sent - previous) <= LIMITS.rate_mm_s * DT_S * (1 + 1e-9) + 1e-12).all()


@given(inside)
def test_what_is_allowed_passes_unchanged_to_the_last_bit(asked):
    limited = LIMITS.apply(asked, asked + 0.01, DT_S)
    np.testing.assert_array_equal(limited.command_mm, asked)
    assert limited.at_travel == limited.at_rate == ()


def test_what_was_cut_short_is_said_with_value_and_bounds():
    limited = LIMITS.apply(np.array([0.0, 5.6, 0.0, 0.0, 10.0]), np.array([0.0, 5.0, 0.0, 0.0, 0.0]), DT_S)
    np.testing.assert_allclose(limited.command_mm, [0.0, 5.0, 0.0, 0.0, 0.1])
    assert limited.at_travel == ("tendon 2: 5.600 mm asked, travel -5 to 5",)
    assert limited.at_rate == ("stage: 2000.000 mm/s asked, rate -20 to 20",)


def test_a_command_of_another_size_is_refused():
    with pytest.raises(CommandNotFiniteError, match="must be 5 finite numbers"):
        LIMITS.apply(np.zeros(4), np.zeros(5), DT_S)


def test_standing_beyond_travel_is_said():
    assert LIMITS.beyond_travel(np.array([0, 0, 0, 5.4, 0.0]), 0.5) == ()
    assert LIMITS.beyond_travel(np.array([0, 0, 0, 5.6, 0.0]), 0.5) == ("tendon 4: 5.600 mm, travel -5 to 5",)
