"""What a look at a camera's pictures means for sensing. docs/cameras.md gives the reason for each limit. Pure."""

import enum
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nodal.cameras.judging.measuring import Look
from nodal.cameras.judging.timing import Timing
from sensing.pictures.segmentation import CONTRAST_SHARE, NOISE_FACTOR


class Verdict(enum.StrEnum):
    """How good something is for sensing."""

    GOOD = "good"
    FAIR = "fair"
    """It works, and works better when something is done."""
    POOR = "poor"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """What was found, in words with figures, and what to do about it (empty where it is good)."""

    subject: str
    verdict: Verdict
    words: str
    advice: str = ""


SHARP_PX, BLURRED_PX = 3.0, 5.0
DARK, DIM, BRIGHT, TOO_BRIGHT = 45, 70, 185, 215
FEW_CLIPPED, MANY_CLIPPED = 0.0002, 0.01
CONTRAST_FACTOR = NOISE_FACTOR / CONTRAST_SHARE
EVEN, UNEVEN = 0.5, 0.3
MUCH_BESIDES = 0.3
NOISY, TOO_NOISY = 4.0, 8.0
STEADY, FLICKERING = 0.02, 0.05
RATE_SHARE, LOST_SHARE = 0.9, 0.02


def findings_on(look: Look) -> list[Finding]:
    """All that one camera's pictures tell."""
    return [
        finding_on_sharpness(look.edges.width_px),
        *_exposure(look),
        _contrast(look),
        *_backdrop(look),
        *_steadiness(look),
    ]


def finding_on_sharpness(width_px: float | None) -> Finding:
    """Whether edges of this typical width are sharp; None is for pictures without edges."""
    if width_px is None:
        return Finding(
            subject="sharpness",
            verdict=Verdict.POOR,
            words="no edge stands out anywhere",
            advice="put the robot or the board into view; if it is there, the picture is far out of focus, or far too dark",
        )
    verdict = _rising(width_px, SHARP_PX, BLURRED_PX)
    words = {Verdict.GOOD: "sharp", Verdict.FAIR: "a little soft", Verdict.POOR: "blurred"}[verdict]
    return Finding(
        subject="sharpness",
        verdict=verdict,
        words=f"{words}: edges are {width_px:.1f} px wide (10 to 90 %)",
        advice=""
        if verdict is Verdict.GOOD
        else "focus on the robot (a webcam's own motor: `nodal cameras look --focus`), wipe the lens, keep the robot still",
    )


def _exposure(look: Look) -> Iterator[Finding]:
    lighting = look.lighting
    level = lighting.level
    darker, brighter = _falling(level, DIM, DARK), _rising(level, BRIGHT, TOO_BRIGHT)
    verdict, words, advice = Verdict.GOOD, "well exposed", ""
    if darker is not Verdict.GOOD:
        verdict, words, advice = darker, "dark", "more light; failing that a longer exposure, then more gain"
    elif brighter is not Verdict.GOOD:
        verdict, words, advice = brighter, "too bright", "a shorter exposure"
    yield Finding(
        subject="exposure",
        verdict=verdict,
        words=f"{words}: the backdrop is at level {level:.0f} of 255",
        advice=advice,
    )
    clipped = _rising(lighting.clipped_share, FEW_CLIPPED, MANY_CLIPPED)
    yield Finding(
        subject="clipping",
        verdict=clipped,
        words=f"{100 * lighting.clipped_share:.2f} % of the picture is clipped",
        advice=""
        if clipped is Verdict.GOOD
        else "turn the lamp or the glossy thing that glares, or expose for less time",
    )


def _contrast(look: Look) -> Finding:
    lighting = look.lighting
    if lighting.contrast == 0:
        return Finding(
            subject="contrast",
            verdict=Verdict.POOR,
            words="nothing stands out from the backdrop",
            advice="put the robot into view; if it is there, choose a backdrop of another colour",
        )
    needed = CONTRAST_FACTOR * lighting.backdrop_noise
    verdict = _falling(lighting.contrast, needed, NOISE_FACTOR * lighting.backdrop_noise)
    return Finding(
        subject="contrast",
        verdict=verdict,
        words=f"what stands out differs by {lighting.contrast:.0f} levels, the backdrop itself by {lighting.backdrop_noise:.1f}",
        advice=""
        if verdict is Verdict.GOOD
        else f"a backdrop of another colour than the robot's, or more light, until they differ by {needed:.0f} levels",
    )


def _backdrop(look: Look) -> Iterator[Finding]:
    lighting = look.lighting
    even = _falling(lighting.falloff, EVEN, UNEVEN)
    yield Finding(
        subject="backdrop",
        verdict=even,
        words=f"its darkest part gets {100 * lighting.falloff:.0f} % of the light of its brightest",
        advice="" if even is Verdict.GOOD else "lamps farther away, on both sides, or a diffuser before them",
    )
    if lighting.standing_out_share > MUCH_BESIDES:
        yield Finding(
            subject="backdrop",
            verdict=Verdict.FAIR,
            words=f"{100 * lighting.standing_out_share:.0f} % of the picture is no smooth backdrop",
            advice="a backdrop that fills the picture, without folds; or background pictures and a work area",
        )


def _steadiness(look: Look) -> Iterator[Finding]:
    if look.noise_levels is not None:
        verdict = _rising(look.noise_levels, NOISY, TOO_NOISY)
        yield Finding(
            subject="noise",
            verdict=verdict,
            words=f"{look.noise_levels:.1f} levels from picture to picture",
            advice="" if verdict is Verdict.GOOD else "more light and less gain",
        )
    if look.flicker is not None:
        verdict = _rising(look.flicker, STEADY, FLICKERING)
        yield Finding(
            subject="flicker",
            verdict=verdict,
            words=f"light changes by {100 * look.flicker:.1f} % from picture to picture",
            advice=""
            if verdict is Verdict.GOOD
            else "exposures of whole half periods of the mains (10 ms at 50 Hz, 8.3 ms at 60 Hz), or lamps that do not flicker",
        )


def finding_on_timing(timing: Timing, asked_hz: float | None) -> Finding:
    """Whether the frames come as often as asked, all of them."""
    words = f"{timing.rate_hz:.1f} Hz, {timing.lost} of {timing.taken} frames lost"
    if asked_hz is not None and timing.rate_hz < RATE_SHARE * asked_hz:
        return Finding(
            subject="rate",
            verdict=Verdict.POOR,
            words=f"{words}; asked were {asked_hz:g} Hz",
            advice="an exposure shorter than a frame; the camera at a USB controller of its own; a smaller picture",
        )
    if timing.lost > LOST_SHARE * timing.taken:
        advice = "the camera at a USB controller of its own; fewer programs beside this one"
        return Finding(subject="rate", verdict=Verdict.FAIR, words=words, advice=advice)
    return Finding(subject="rate", verdict=Verdict.GOOD, words=words)


def finding_on_skew(skews_s: Sequence[float], maximum_skew_s: float, free_s: float) -> Finding:
    """Whether pictures of several cameras are taken together closely enough; `free_s` is the worst of cameras that drift."""
    worst_s = max(skews_s)
    words = f"pictures that belong together are up to {1e3 * worst_s:.1f} ms apart"
    if worst_s <= maximum_skew_s / 2:
        return Finding(subject="skew", verdict=Verdict.GOOD, words=words)
    allowed = f"sensing.maximum_skew_s allows {1e3 * maximum_skew_s:g} ms"
    if worst_s <= maximum_skew_s:
        advice = "move the robot slowly, or take a higher rate; cameras drift against each other"
        return Finding(subject="skew", verdict=Verdict.FAIR, words=f"{words}; {allowed}", advice=advice)
    enough_ms = np.ceil(1e3 * free_s)
    advice = f"sensing.maximum_skew_s = {enough_ms / 1e3:g}, which is the worst that comes about; a higher rate makes it less"
    return Finding(subject="skew", verdict=Verdict.POOR, words=f"{words}; {allowed}", advice=advice)


def finding_on_size(size_px: tuple[int, int], expected_px: tuple[int, int], whose: str) -> Finding:
    """Whether the pictures have the size that somebody (`whose`) says."""
    words, expected = "{}x{} px".format(*size_px), "{}x{} px".format(*expected_px)
    if size_px == expected_px:
        return Finding(subject="size", verdict=Verdict.GOOD, words=f"{words}, as {whose} says")
    advice = "set the camera to the size it was calibrated at, or calibrate anew"
    return Finding(
        subject="size", verdict=Verdict.POOR, words=f"{words}; {whose} says {expected}", advice=advice
    )


def _rising(value: float, fair: float, poor: float) -> Verdict:
    """Good up to `fair`, poor beyond `poor`."""
    return Verdict.GOOD if value <= fair else Verdict.FAIR if value <= poor else Verdict.POOR


def _falling(value: float, fair: float, poor: float) -> Verdict:
    """Good down to `fair`, poor below `poor`."""
    return _rising(-value, -fair, -poor)
