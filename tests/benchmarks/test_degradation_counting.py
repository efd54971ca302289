"""Silent errors, refusals and coverage are counted as they should be, on made-up estimates."""

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.degradations.looking import errors_in_words
from benchmarks.degradations.running import INSIDE, Outcome, held_against
from benchmarks.degradations.table import COLUMNS, Row, as_json, as_markdown, cells
from benchmarks.poses import NODES_MM, bent, centreline, true_nodes


def outcome(error_mm=0.1, *, warm=False, flags=(), refusal="", inside=True, seconds=0.01, broken=False):
    count = 0 if refusal else len(NODES_MM)
    return Outcome(
        warm=warm,
        frame=0,
        seconds=seconds,
        error_mm=np.full(count, error_mm),
        inside=np.full(count, inside),
        flags=flags,
        refusal=refusal,
        broken=broken,
    )


def row(*outcomes):
    return Row.of("refined", "case", "level", 1, outcomes)


@dataclass
class MadeUp:
    """A shape whose nodal points are off by (3,) with the same covariance at each."""

    truth_mm: np.ndarray
    off_mm: np.ndarray
    covariance: np.ndarray

    def nodes(self, arc_mm):
        found = true_nodes(self.truth_mm) + self.off_mm
        return found, np.broadcast_to(self.covariance, (len(arc_mm), 3, 3))


def test_an_error_is_silent_only_without_flag_and_refusal():
    assert outcome(1.01).silent
    assert outcome(math.nan).silent
    assert not outcome(0.99).silent
    assert not outcome(5.0, flags=("large_residual",)).silent
    assert not outcome(refusal="nothing there").silent


def test_one_bad_nodal_point_is_enough():
    off = outcome(0.1)
    off.error_mm[3] = 1.2

    assert off.silent


def test_silent_errors_are_named_by_how_the_estimate_began():
    found = [outcome(2.0), outcome(0.1, warm=True), outcome(3.25, warm=True), outcome(9.0, flags=("hidden",))]

    assert errors_in_words(found) == "off by mm: cold 2.00, warm-0 3.25"


def test_shares_are_of_all_estimates_of_a_kind():
    counted = row(
        outcome(2.0),
        outcome(refusal="gone"),
        outcome(3.0, flags=("tip_unseen",)),
        outcome(),
        outcome(4.0, warm=True),
        outcome(refusal="KeyError: 'left'", broken=True, warm=True),
    )

    cold, warm = counted.cold, counted.warm
    assert (cold.estimates, cold.refused, cold.flagged, cold.silent, cold.broken) == (4, 1, 1, 1, 0)
    assert (warm.estimates, warm.refused, warm.flagged, warm.silent, warm.broken) == (2, 1, 0, 1, 1)
    texts = dict(zip(COLUMNS, cells(counted), strict=True))
    assert (texts["refused %"], texts["flagged %"], texts["silent %"]) == ("25/50", "25/0", "25/50")


def test_errors_are_of_estimates_without_a_flag():
    counted = row(
        outcome(0.2), outcome(0.4, warm=True), outcome(9.0, flags=("hidden",)), outcome(refusal="gone")
    )

    assert counted.mean_mm == pytest.approx(0.3)
    assert counted.max_mm == pytest.approx(0.4)
    assert counted.tip_mm == pytest.approx(0.3)
    assert counted.reasons == {"hidden": 1, "! gone": 1}


def test_refusals_that_differ_in_numbers_alone_are_one_reason():
    counted = row(outcome(refusal="12.5 of 13 px"), outcome(refusal="2 of 13 px"))

    assert counted.reasons == {"! # of # px": 2}


def test_times_are_medians_of_each_kind():
    counted = row(*(outcome(seconds=seconds) for seconds in (1.0, 2.0, 9.0)), outcome(seconds=0.5, warm=True))

    assert (counted.cold.median_ms, counted.warm.median_ms) == (2000.0, 500.0)


def test_a_row_without_a_trusted_estimate_has_no_figures():
    counted = row(outcome(refusal="gone"))

    assert "-" in cells(counted)
    [plain] = json.loads(as_json([counted]))
    assert plain["mean_mm"] is None
    assert plain["warm"]["median_ms"] is None
    assert plain["cold"]["refused"] == 1


def test_markdown_has_a_line_for_each_row():
    lines = as_markdown([row(outcome()), row(outcome(refusal="a | b"))]).splitlines()

    assert lines[1].startswith("| --- | --- | ---: |")
    assert len(lines[2].split(" | ")) == len(COLUMNS)
    assert "a \\| b" in lines[3]


def test_coverage_is_by_the_ellipsoid_and_not_by_the_distance():
    truth = centreline(bent((0.4, 0.3), (0.0, 1.0)))
    covariance = np.diag([1.0, 1e-4, 1e-4])
    along = MadeUp(truth, np.array([1.0, 0, 0]), covariance)
    across = MadeUp(truth, np.array([0, 1.0, 0]), covariance)

    assert held_against(along, truth)[1].all()
    assert not held_against(across, truth)[1].any()
    np.testing.assert_allclose(held_against(across, truth)[0], 1.0)


@pytest.mark.parametrize(("share", "inside"), [(0.99, True), (1.01, False)])
def test_the_ellipsoid_ends_where_it_should(share, inside):
    truth = centreline(np.zeros((2, 2)))
    sigma = 0.3
    off = np.array([0.6, 0.0, 0.8]) * sigma * math.sqrt(share * INSIDE)

    assert (held_against(MadeUp(truth, off, sigma**2 * np.eye(3)), truth)[1] == inside).all()
    assert pytest.approx(7.815, abs=1e-3) == INSIDE


def test_certainty_in_a_direction_holds_no_truth_beside_it():
    truth = centreline(np.zeros((2, 2)))

    assert not held_against(MadeUp(truth, np.array([0, 0, 0.01]), np.diag([1.0, 1.0, 0.0])), truth)[1].any()
    assert held_against(MadeUp(truth, np.zeros(3), np.diag([1.0, 1.0, 0.0])), truth)[1].all()
