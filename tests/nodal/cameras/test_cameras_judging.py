"""Pictures are judged: what is spoiled is found, with the right figure, and nothing else is."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.cameras import CameraFrame, FrameSetPairing, worst_skew_periods
from nodal.cameras.judging.annotating import annotated
from nodal.cameras.judging.focus import sharpest, sweep
from nodal.cameras.judging.measuring import look_at
from nodal.cameras.judging.sharpness import RISE, edges_in
from nodal.cameras.judging.steadiness import flicker_in, noise_in
from nodal.cameras.judging.suggestions import Held, suggestions_for
from nodal.cameras.judging.timing import Timing, skews_s, timing_of
from nodal.cameras.judging.verdicts import Verdict, finding_on_skew, finding_on_timing, findings_on
from nodal.errors import CommandError
from sensing.errors import UnreadableImageError
from sensing.pictures.light import LINEAR


def exposed(picture, share):
    """With so many times the light."""
    light = np.clip(LINEAR[picture] * share, 0, 255)
    return np.interp(light, LINEAR, np.arange(256)).astype(np.uint8)


def shaded(picture, share):
    """Darker from left to right, down to this share of the light."""
    return exposed(picture, np.linspace(1, share, picture.shape[1])[None, :, None])


def glaring(picture):
    glared = picture.copy()
    cv2.circle(glared, (200, 150), 70, (255, 255, 255), -1)
    return glared


def faded(picture):
    """Everything nearly the backdrop's colour."""
    colour = np.median(picture, axis=(0, 1))
    return (colour + 0.12 * (picture - colour)).astype(np.uint8)


SPOILED = {
    "sharpness": lambda picture: cv2.GaussianBlur(picture, (0, 0), 3.0),
    "exposure": lambda picture: exposed(picture, 0.1),
    "clipping": glaring,
    "contrast": faded,
    "backdrop": lambda picture: shaded(picture, 0.15),
}


def held(**values):
    """Controls whose least value is 0, and whose default is 128."""
    return {key: Held(value=value, least=0, default=128) for key, value in values.items()}


def suggested(look, rate_hz=30.0, **values):
    return {one.key: one.value for one in suggestions_for(look, held(**values), rate_hz)}


def verdicts(look):
    return {finding.subject: finding.verdict for finding in findings_on(look)}


def test_a_good_picture_is_found_good(scene, coded) -> None:
    look = look_at("left", [coded(scene, seed=seed) for seed in range(3)])
    assert set(verdicts(look).values()) == {Verdict.GOOD}
    assert set(verdicts(look)) == {*SPOILED, "noise", "flicker"}
    assert suggestions_for(look, held(exposure_s=0.008, power_line_hz=50, gain=20, sharpness=128), 30.0) == []


@pytest.mark.parametrize("subject", SPOILED)
def test_what_is_spoiled_is_named_with_what_to_do(subject, scene, coded) -> None:
    found = findings_on(look_at("left", [coded(SPOILED[subject](scene))]))
    poor = [
        finding for finding in found if finding.subject == subject and finding.verdict is not Verdict.GOOD
    ]
    assert poor
    assert all(finding.advice for finding in poor)
    assert all(not finding.advice for finding in found if finding.verdict is Verdict.GOOD)


@pytest.mark.parametrize("blur_px", [0.7, 1.5, 3.0, 6.0])
def test_an_edge_is_as_wide_as_it_was_blurred(blur_px) -> None:
    # the slanted edge of ISO 12233, drawn four times as fine and then averaged, which blurs by itself a little
    down, across = np.mgrid[:1200, :1600]
    fine = np.where(across + 0.1 * down > 800, 180.0, 60.0).astype(np.float32)
    sharp = cv2.resize(fine, (400, 300), interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(sharp, (0, 0), blur_px).round().astype(np.uint8)
    assert edges_in(blurred).width_px == pytest.approx(RISE * np.hypot(blur_px, 0.29), rel=0.12)


def test_far_blurred_edges_of_little_contrast_are_found_in_a_smaller_picture() -> None:
    across = np.mgrid[:400, :600][1]
    blurred = cv2.GaussianBlur(np.where(across > 300, 150.0, 100.0), (0, 0), 7.0).round().astype(np.uint8)
    assert edges_in(blurred).width_px == pytest.approx(RISE * 7, rel=0.15)


def test_soft_shadows_are_no_contrast(scene, coded) -> None:
    down, across = np.mgrid[: scene.shape[0], : scene.shape[1]]
    shadow = 0.5 * np.exp(-(((across - 200) / 120) ** 2) - ((down - 250) / 120) ** 2)
    without, shaded_by = (
        look_at("left", [coded(picture)]).lighting
        for picture in (scene, exposed(scene, 1 - shadow[..., None]))
    )
    assert shaded_by.standing_out_share > without.standing_out_share + 0.03
    assert shaded_by.contrast == pytest.approx(without.contrast, rel=0.15)


def test_an_even_picture_has_no_edges() -> None:
    noise = np.random.default_rng(0).normal(120, 3, (400, 600)).clip(0, 255).astype(np.uint8)
    assert edges_in(noise).width_px is None


@settings(max_examples=25)
@given(st.floats(1.0, 10.0), st.integers(0, 100))
def test_noise_is_measured_though_something_moves_and_the_light_changes(levels, seed) -> None:
    random = np.random.default_rng(seed)
    scenes = [np.full((192, 256), 110.0 + 4 * number) for number in range(3)]
    for number, moving in enumerate(scenes):
        moving[:, 10 * number : 10 * number + 30] += 50
    pictures = [
        (moving + random.normal(0, levels, moving.shape)).round().clip(0, 255).astype(np.uint8)
        for moving in scenes
    ]
    assert noise_in(pictures) == pytest.approx(levels, rel=0.15)


def test_bands_that_wander_are_flicker(scene) -> None:
    rows = np.arange(scene.shape[0])[:, None, None]
    pictures = [
        cv2.cvtColor(exposed(scene, 1 + 0.04 * np.sin(rows / 60 + 2.1 * number)), cv2.COLOR_BGR2GRAY)
        for number in range(6)
    ]
    assert flicker_in(pictures) == pytest.approx(0.08, abs=0.015)
    assert flicker_in([pictures[0]] * 3) == 0.0
    assert flicker_in(pictures[:2]) is None


def frames(camera, times_ms, first=0):
    return [
        CameraFrame(name=camera, jpeg=b"", capture_monotonic_ns=round(time * 1e6), number=number)
        for number, time in enumerate(times_ms, first)
        if time is not None
    ]


def test_rate_and_lost_frames_are_told_from_times_and_numbers() -> None:
    timing = timing_of(frames("a", [0, 40, None, 120, 160], first=7))
    assert timing == Timing(rate_hz=25.0, lost=1, taken=5)
    assert finding_on_timing(timing, 25.0).verdict is Verdict.FAIR
    assert finding_on_timing(timing, 30.0).verdict is Verdict.POOR
    assert timing_of(frames("a", [3])) is None


def test_skew_is_that_of_the_nearest_frames() -> None:
    taken = {
        "a": frames("a", [0, 33, 66, 99]),
        "b": frames("b", [38, 71, 104]),
        "c": frames("c", [31, 64, 97]),
    }
    assert skews_s(taken) == pytest.approx([0.007, 0.007, 0.007])
    assert skews_s(taken | {"c": frames("c", [31, None, 97])}) == pytest.approx([0.007, 0.007])
    assert skews_s({"a": taken["a"]}) == []


def test_a_set_goes_around_the_largest_gap() -> None:
    # b's frame after a's and c's frame before it are the nearest to a's, but 32 ms apart
    taken = {
        "a": frames("a", [0, 33.3, 66.6, 99.9]),
        "b": frames("b", [16, 49.3, 82.6, 115.9]),
        "c": frames("c", [17.3, 50.6, 83.9, 117.2]),
    }
    assert skews_s(taken) == pytest.approx([0.0173] * 4)


@given(st.lists(st.floats(0, 1, exclude_max=True), min_size=2, max_size=4))
def test_free_cameras_always_find_sets_within_the_worst_skew(phases) -> None:
    period_ms = 33.3
    taken = {
        str(number): frames(str(number), [(phase + count) * period_ms for count in range(8)])
        for number, phase in enumerate(phases)
    }
    worst_s = worst_skew_periods(len(phases)) * period_ms / 1e3
    skews = skews_s(taken)
    assert len(skews) >= 7
    # at the ends a camera's frame may be missing from the closest set
    assert max(skews[1:6]) <= worst_s + 1e-6
    pairing = FrameSetPairing(tuple(taken), worst_s + 1e-6)
    ordered = sorted(
        (frame for those in taken.values() for frame in those), key=lambda one: one.capture_monotonic_ns
    )
    assert sum(pairing.feed(frame) is not None for frame in ordered) >= 7


def test_too_much_skew_comes_with_the_value_that_is_enough() -> None:
    found = [finding_on_skew([0.007], allowed, 0.0167) for allowed in (0.02, 0.01, 0.005)]
    assert [finding.verdict for finding in found] == list(Verdict)
    assert "sensing.maximum_skew_s = 0.017," in found[-1].advice


@pytest.mark.parametrize(("share", "least", "most"), [(0.2, 0.019, 0.031), (3.0, 0.001, 0.006)])
def test_an_exposure_is_suggested_that_brings_the_backdrop_to_the_middle(
    share, least, most, scene, coded
) -> None:
    look = look_at("left", [coded(exposed(scene, share))])
    (suggestion,) = suggestions_for(look, held(exposure_s=0.008), 30.0)
    assert suggestion.key == "exposure_s"
    assert least <= suggestion.value <= most
    again = exposed(scene, share * suggestion.value / 0.008)
    assert verdicts(look_at("left", [coded(again)]))["exposure"] is Verdict.GOOD


def test_long_exposures_are_whole_half_periods_of_the_mains(scene, coded) -> None:
    look = look_at("left", [coded(exposed(scene, 0.2))])
    (suggestion,) = suggestions_for(look, held(exposure_s=0.0083, power_line_hz=60), 30.0)
    assert suggestion.value * 120 == pytest.approx(round(suggestion.value * 120), abs=0.02)
    assert suggestion.value < 1 / 30


@pytest.mark.parametrize("rate_hz", [60.0, 90.0, 120.0])
def test_no_exposure_is_longer_than_a_frame(rate_hz, scene, coded) -> None:
    look = look_at("left", [coded(exposed(scene, 0.2))])
    assert suggested(look, rate_hz, exposure_s=0.002, power_line_hz=50)["exposure_s"] <= 0.9 / rate_hz


def test_gain_goes_before_exposure_where_the_picture_is_too_bright(scene, coded) -> None:
    look = look_at("left", [coded(exposed(scene, 3.0))])
    assert suggested(look, exposure_s=0.01, gain=40) == {"gain": 0}
    assert suggested(look, exposure_s=0.01, gain=0).keys() == {"exposure_s"}


def test_gain_goes_where_there_is_noise_and_time_for_a_longer_exposure(scene, coded) -> None:
    look = look_at("left", [coded(scene, noise_levels=7.0, seed=seed) for seed in range(3)])
    assert suggested(look, exposure_s=0.01, gain=40) == {"gain": 0}
    assert suggested(look, exposure_s=0.03, gain=40) == {}


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"exposure_s": 0.01, "power_line_hz": 50}, {"power_line_hz": 60, "exposure_s": 1 / 120}),
        ({"exposure_s": 0.0083, "power_line_hz": 60}, {"power_line_hz": 50, "exposure_s": 0.01}),
        ({"exposure_s": 0.006, "power_line_hz": 60}, {"exposure_s": 1 / 120}),
        ({"exposure_s": 0.006, "power_line_hz": 0}, {"power_line_hz": 50, "exposure_s": 0.01}),
    ],
)
def test_lamps_that_flicker_have_exposures_of_whole_half_periods(values, expected, scene, coded) -> None:
    rows = np.arange(scene.shape[0])[:, None, None]
    bands = [exposed(scene, 1 + 0.04 * np.sin(rows / 60 + 2.1 * number)) for number in range(4)]
    found = suggested(look_at("left", [coded(picture) for picture in bands]), **values)
    assert found == pytest.approx(expected, abs=1e-4)


def test_sharpness_goes_down_to_the_default_and_never_up(scene, coded) -> None:
    look = look_at("left", [coded(scene)])
    assert suggested(look, sharpness=200) == {"sharpness": 128}
    assert suggested(look, sharpness=60) == {}


@given(st.integers(0, 255), st.sampled_from([1, 5, 17]), st.floats(0, 0.02))
def test_the_sharpest_focus_is_found_with_few_tries(best, step, noise_px) -> None:
    random = np.random.default_rng(best)
    tried = sweep(lambda focus: 1 + 0.1 * abs(focus - best) + random.uniform(0, noise_px), 0, 255, step)
    assert abs(sharpest(tried) - best) <= step
    assert len(tried) <= 40
    assert {focus % step for focus in tried} == {0}


def test_no_edges_at_any_focus_are_found_out_with_one_round() -> None:
    tried = sweep(lambda _: math.inf, 0, 250, 5)
    assert len(tried) == 11


def test_of_all_that_is_sharp_the_middle_is_taken() -> None:
    assert sharpest(sweep(lambda focus: max(1.0, abs(focus - 120) / 20), 0, 250, 5)) == pytest.approx(
        120, abs=5
    )


def test_what_was_measured_is_drawn(scene, coded) -> None:
    look = look_at("left", [coded(glaring(scene))])
    drawn = annotated(look, findings_on(look))
    height, width = scene.shape[:2]
    assert drawn.shape[1] == width
    assert drawn.shape[0] > height
    assert tuple(drawn[150, 200]) == (255, 0, 255)


def test_what_is_no_picture_is_refused_by_name(coded, scene) -> None:
    with pytest.raises(CommandError, match="camera left: there is no picture"):
        look_at("left", [])
    with pytest.raises(UnreadableImageError, match=r"camera left: .*cut off"):
        look_at("left", [coded(scene)[:5000]])
