"""What a report is made of: stretches, targets, traffic, charts, words and numbers."""

import dataclasses
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from messaging import topics
from messaging.control import Action, ActionRequest, State
from messaging.history import Asked
from messaging.recorder import RecorderAction, RecorderRequest
from messaging.shape import NodalPoints
from nodal import targets
from nodal.report.bench_run import Accepted, BenchRun
from nodal.report.charts import MOST_POINTS, a_second, bands, histogram, line, over_time, overlaid, thinned
from nodal.report.figures.model import figures
from nodal.report.findings import Findings
from nodal.report.moments import telling_moments
from nodal.report.page.markup import CONTROL, document, element
from nodal.report.page.numbers import difference, with_unit
from nodal.report.pictures.chart import as_svg
from nodal.report.requests import request_in_words
from nodal.report.run_charts import run_charts
from nodal.report.stretches import pursuits, seconds_in, stretches, without_numbers
from nodal.report.traffic import TopicTraffic, restarts, topic_traffic
from recordings.reader import Recorded

SECOND_NS = 1_000_000_000
numbers = st.floats(-1e6, 1e6)


@pytest.fixture
def cycles(said):
    """Cycles every 10 ms between two times in s."""

    def made(begin_s, end_s, **changes):
        times = said.START_NS + np.arange(round(100 * begin_s), round(100 * end_s)) * 10_000_000
        return [dataclasses.replace(said.state(0, 0, 0.5), time_ns=int(time), **changes) for time in times]

    return made


def test_a_stretch_lasts_until_the_next_begins_and_ends_with_silence(cycles, said):
    states = [
        *cycles(0, 1),
        *cycles(1, 1.5, state=State.HOLD, reason="no trusted shape: none has come"),
        *cycles(4, 5, state=State.HOLD, reason="no trusted shape: none has come"),
        *cycles(5, 6, state=State.HOLD, reason="the operator asked to hold"),
    ]

    found = stretches(states)

    assert [round(one.duration_s, 2) for one in found] == [1.0, 0.49, 1.0, 0.99]
    assert [one.by_itself for one in found] == [False, True, True, False]
    assert seconds_in(found, State.HOLD) == pytest.approx(2.48)
    assert [(band.label, band.begin_s) for band in bands(found, said.START_NS)] == [
        ("circle", 0.0),
        ("holding", 1.0),
        ("holding", 4.0),
    ]


def test_what_was_limited_in_single_cycles_does_not_end_a_stretch(cycles):
    states = [
        *cycles(0, 1),
        *cycles(1, 1.1, reason="tendon 2: 5.7 mm/s asked, rate -5 to 5"),
        *cycles(1.1, 2),
    ]

    assert len(stretches(states)) == 1


def test_reasons_differ_in_kind_not_in_numbers():
    assert without_numbers("arrived 109 ms late, 100.5 allowed") == without_numbers(
        "arrived 7 ms late, 0.1 allowed"
    )


def test_targets_of_one_name_are_told_apart_and_the_same_asked_again_is_one(cycles, said):
    there, elsewhere = targets.points({"tip": [1, 0, 80]}, {}), targets.points({"tip": [2, 0, 80]}, {})
    run = BenchRun(
        rig=(),
        losses=0,
        states=[*cycles(0, 3, target_name="point"), *cycles(3, 4, target_name="point", state=State.HOLD)],
        accepted=[
            Accepted(time_ns=said.START_NS + second * SECOND_NS, target=target)
            for second, target in ((0, there), (1, elsewhere), (2, targets.points({"tip": [1, 0, 80]}, {})))
        ],
    )

    found = pursuits(run)

    assert [pursuit.label for pursuit in found] == ["point", "point (2)"]
    assert [pursuit.target for pursuit in found] == [there, elsewhere]
    assert found[0].duration_s > 2.5
    assert found[0].followed_s == pytest.approx(found[0].duration_s - 1, abs=0.2)


def test_a_target_from_before_the_recording_is_judged_by_all_its_points(cycles):
    run = BenchRun(rig=(), losses=0, states=cycles(0, 1))

    [pursuit] = pursuits(run)

    assert pursuit.target is None
    assert pursuit.names == ("tip",)


def recorded(sequence, time_ns, key="shape"):
    return Recorded(
        path=None,
        topic=key,
        schema="",
        log_time_ns=time_ns,
        publish_time_ns=time_ns,
        sequence=sequence,
        payload=b"123",
    )


def test_numbers_tell_of_losses_and_of_restarts():
    traffic = {}
    for sequence, time_ns in ((5, 10), (6, 20), (9, 30), (0, 90), (1, 100)):
        topic_traffic(traffic, "shape").hear(recorded(sequence, time_ns))

    heard = traffic["shape"]

    assert (heard.messages, heard.missing, heard.size_bytes) == (5, 2, 15)
    assert (heard.largest_gap_ns, heard.largest_gap_at_ns) == (60, 30)
    assert heard.rate_hz == pytest.approx(4 / 90e-9)
    assert restarts(traffic) == [(90, "sensing")]


def test_what_many_say_is_neither_lost_nor_begun_anew():
    heard = TopicTraffic(one_voice=False)
    for sequence, time_ns in ((5, 10), (0, 20), (9, 30)):
        heard.hear(recorded(sequence, time_ns, "log"))

    assert (heard.missing, heard.restarts_ns) == (0, [])


@given(st.lists(numbers, min_size=1, max_size=5 * MOST_POINTS))
def test_thinning_out_keeps_extremes(values):
    series = thinned(line("", np.arange(len(values)), values))

    assert len(series.x) <= MOST_POINTS
    assert (series.y.min(), series.y.max()) == (min(values), max(values))
    assert (np.diff(series.x) > 0).all()


@given(st.lists(st.floats(0, 1e6), max_size=50))
def test_a_histogram_holds_every_value(values):
    assert histogram("", values).y.sum() == pytest.approx(100 if values else 0)


def test_a_line_breaks_where_nothing_was_heard():
    series = over_time("", [0.0, 0.1, 0.5, 0.6], [1, 2, 3, 4])

    assert np.isnan(series.x).tolist() == [False, False, True, False, False]


def test_only_whole_seconds_are_counted():
    series = a_second("", np.arange(0.5, 4.2, 0.1))

    assert series.x.tolist() == [1.5, 2.5, 3.5]
    assert series.y.tolist() == [10, 10, 10]


@pytest.mark.parametrize(
    ("x", "y"), [([], []), ([1.0], [0.0]), ([1.0, np.nan, 2.0], [np.nan] * 3), ([0.0, 1.0], [-1.0, 0.0])]
)
def test_a_chart_of_next_to_nothing_can_be_drawn(x, y, said):
    run = BenchRun(
        rig=(), losses=0, shapes=[said.shape(0, said.START_NS)], states=[said.state(0, said.START_NS, 1)]
    )
    chart = next(chart for charts in run_charts(Findings(run)).values() for chart in charts if chart.wide)

    drawn = as_svg(dataclasses.replace(chart, series=(line("one", x, y),), logarithmic="y"), "salt")

    assert drawn.startswith("<svg ")
    assert "#" not in drawn.replace("url(#", "").replace('href="#', ""), "a colour is not the page's"


def test_charts_lie_over_one_another_by_the_names_of_their_runs(said):
    run = BenchRun(rig=(), losses=0, states=[said.state(0, said.START_NS, 1)])
    [chart] = [chart for chart in run_charts(Findings(run))["loop"] if chart.key == "loop"]

    together = overlaid({"first": chart, "second": chart})

    assert [series.label for series in together.series] == ["first", "second"]
    assert len({series.colour for series in together.series}) == 2
    assert together.title == "The control loop: lateness"
    assert "first: 0 to 100" in together.in_words()


def test_moments_that_fall_together_are_one(said):
    shapes = [said.shape(number, said.START_NS + number * said.PERIOD_NS) for number in range(3)]
    shapes[1] = said.refused(1, shapes[1].capture_time_ns, "camera left: no robot")

    moments = telling_moments(Findings(BenchRun(rig=(), losses=0, shapes=shapes[:2])))

    assert [moment.titles for moment in moments] == [
        ("the first estimate",),
        ("the first refusal: camera left: no robot", "the last frame set"),
    ]


@pytest.mark.parametrize(
    ("service", "request_bytes", "words"),
    [
        ("controller/do", ActionRequest(action=Action.HOME).to_bytes(), "home"),
        ("controller/target", targets.points({"tip": [1, 2, 3]}, {"tip": 2}).to_bytes(), "point: tip (weight 2) to 1.00, 2.00, 3.00 mm"),
        ("sensing/nodes", NodalPoints(names=("a", "b"), arc_mm=np.array([5.0, 7.5])).to_bytes(), "nodal points a at 5 mm, b at 7.5 mm"),
        ("recorder/do", RecorderRequest(action=RecorderAction.SAVE, file="x.mcap").to_bytes(), "save x.mcap"),
        ("controller/do", b"\xff\xff", "unreadable: "),
        ("somebody/else", b"123", "3 bytes to a service that this version does not know"),
    ],
)  # fmt: skip
def test_a_request_is_told_in_words(service, request_bytes, words):
    asked = Asked(time_ns=0, service=service, request=request_bytes, accepted=True, state="", reason="")

    assert request_in_words(asked).startswith(words)
    assert service in {known.key for known in topics.SERVICES} or "does not know" in words


@pytest.mark.parametrize(
    ("value", "base", "unit", "said_so"),
    [
        (0.2, 0.1, "mm", "+0.100 mm (+100 %)"),
        (0.05, 0.1, "mm", "−0.050 mm (−50 %)"),
        (80.02, 80.0, "mm", "+0.020 mm"),
        (0.1001, 0.1, "mm", ""),
        (3, 0, "", "+3"),
        (15.0, 10.0, "%", "+5.0 %"),
        (None, 1.0, "s", ""),
    ],
)
def test_differences_are_signed_and_say_how_much(value, base, unit, said_so):
    assert difference(value, base, unit).replace("\u202f", " ") == said_so


def test_every_figure_knows_its_unit():
    told = figures(rms_mm=("RMS", 1.23456), count=("count", np.int64(1234)), share_percent=("share", None))

    assert [figure.unit for figure in told] == ["mm", "", "%"]
    assert [with_unit(figure.value, figure.unit).replace("\u202f", " ") for figure in told] == [
        "1.235 mm",
        "1 234",
        "–",
    ]


@given(st.text())
def test_any_text_comes_out_as_text(text):
    class Reader(HTMLParser):
        def __init__(self):
            super().__init__()
            self.open, self.said, self.title = [], "", None

        def handle_starttag(self, tag, attributes):
            self.open.append(tag)
            self.title = dict(attributes).get("title", self.title)

        def handle_endtag(self, tag):
            self.open.pop()

        def handle_data(self, data):
            self.said += data if self.open[-1:] == ["b"] else ""

    reader = Reader()
    reader.feed(document("", "", element("b", text, title=text)))
    reader.close()

    assert reader.said == CONTROL.sub("\ufffd", text)
    assert reader.title == CONTROL.sub("\ufffd", text)
