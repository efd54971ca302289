"""Which settings of a camera would make its pictures better. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass

from nodal.cameras.judging.measuring import Look
from nodal.cameras.judging.verdicts import BRIGHT, DIM, MANY_CLIPPED, NOISY, STEADY
from sensing.pictures.light import LINEAR

WANTED_LEVEL = 128
"""Half of full scale: a stop of room above, and two below."""
SHORTEST_S = 0.0003
FRAME_SHARE = 0.9
"""An exposure may take so much of a frame; the rest is for reading it out."""
LEAST_CHANGE = 1.1
CLIPPED_SHARE = 0.7
"""Half a stop less where it is a part of the picture that is clipped, and not the backdrop."""
MAINS_HZ = (50, 60)
WHOLE = 0.02
"""Exposures are whole half periods of the mains to so much of one: cameras count them in steps of 0.1 ms."""


@dataclass(frozen=True, kw_only=True)
class Held:
    """What a control holds, its least value and that of the factory, in the unit of its key in [cameras.NAME.controls]."""

    value: float
    least: float
    default: float


@dataclass(frozen=True, kw_only=True)
class Suggestion:
    """Another value for a key of [cameras.NAME.controls], and why."""

    key: str
    value: float
    reason: str


def suggestions_for(look: Look, controls: Mapping[str, Held], rate_hz: float) -> list[Suggestion]:
    """What to set in the bench file for a camera that holds these `controls`, by their keys; empty where they do.

    One look need not find everything: what less gain makes dark, the next one tells.
    """
    longest_s = FRAME_SHARE / rate_hz
    mains = _mains(look, controls)
    light = _gain(look, controls, longest_s) or _exposure(look, controls, longest_s, mains)
    return [found for found in (light, mains, _sharpness(controls)) if found is not None]


def _mains(look: Look, controls: Mapping[str, Held]) -> Suggestion | None:
    """The frequency that lamps flicker with, which is not the one that is held."""
    flicker = look.flicker or 0.0
    if flicker <= STEADY or "power_line_hz" not in controls:
        return None
    reason = f"light changes by {100 * flicker:.1f} % from picture to picture"
    held_hz = controls["power_line_hz"].value
    if held_hz not in MAINS_HZ:
        return Suggestion(
            key="power_line_hz", value=MAINS_HZ[0], reason=f"{reason}; 60 where the mains has it"
        )
    halves = 2 * held_hz * controls["exposure_s"].value if "exposure_s" in controls else 0.0
    if round(halves) < 1 or abs(halves - round(halves)) > WHOLE * halves:
        return None
    (other_hz,) = (hz for hz in MAINS_HZ if hz != held_hz)
    reason += f", though exposures are whole half periods of {held_hz:g} Hz"
    return Suggestion(key="power_line_hz", value=other_hz, reason=reason)


def _gain(look: Look, controls: Mapping[str, Held], longest_s: float) -> Suggestion | None:
    """As little as there is, where the picture is too bright anyway or a longer exposure can do gain's work with less noise."""
    gain, exposure = controls.get("gain"), controls.get("exposure_s")
    if gain is None or exposure is None or gain.value <= gain.least:
        return None
    if (bright := _too_bright(look)) is not None:
        return Suggestion(key="gain", value=gain.least, reason=bright)
    noise_levels = look.noise_levels or 0.0
    if noise_levels > NOISY and exposure.value * LEAST_CHANGE < longest_s:
        reason = f"noise of {noise_levels:.1f} levels; a longer exposure gives the same light with less"
        return Suggestion(key="gain", value=gain.least, reason=reason)
    return None


def _exposure(
    look: Look, controls: Mapping[str, Held], longest_s: float, mains: Suggestion | None
) -> Suggestion | None:
    """What would bring the backdrop to the middle, or tame the flicker."""
    present_s = controls["exposure_s"].value if "exposure_s" in controls else 0.0
    if not present_s or (wanted := _wanted(look, present_s)) is None:
        return None
    wanted_s, reason = wanted
    possible_s = min(max(wanted_s, SHORTEST_S), longest_s)
    mains_hz = (
        mains.value if mains else controls["power_line_hz"].value if "power_line_hz" in controls else 0.0
    )
    exposure_s = _without_flicker(look, possible_s, longest_s, mains_hz)
    if 1 / LEAST_CHANGE < exposure_s / present_s < LEAST_CHANGE:
        return None
    return Suggestion(key="exposure_s", value=round(exposure_s, 4), reason=reason)


def _wanted(look: Look, exposure_s: float) -> tuple[float, str] | None:
    """An exposure and why; None where nothing is to be changed."""
    level, flicker = look.lighting.level, look.flicker or 0.0
    if not DIM <= level <= BRIGHT:
        share = float(LINEAR[WANTED_LEVEL] / max(LINEAR[round(level)], LINEAR[1]))
        return share * exposure_s, f"the backdrop is at level {level:.0f}, good are {DIM} to {BRIGHT}"
    if (bright := _too_bright(look)) is not None:
        return CLIPPED_SHARE * exposure_s, bright
    if flicker > STEADY:
        return exposure_s, f"light changes by {100 * flicker:.1f} % from picture to picture"
    return None


def _too_bright(look: Look) -> str | None:
    """Why, or None where it is not."""
    level, clipped = look.lighting.level, look.lighting.clipped_share
    if level > BRIGHT:
        return f"the backdrop is at level {level:.0f}, good are {DIM} to {BRIGHT}"
    return f"{100 * clipped:.1f} % of the picture is clipped" if clipped > MANY_CLIPPED else None


def _without_flicker(look: Look, exposure_s: float, longest_s: float, mains_hz: float) -> float:
    """Whole half periods of the mains, unless that is much longer, longer than a frame, or the light is steady enough."""
    if mains_hz not in MAINS_HZ:
        return exposure_s
    half_period_s = 0.5 / mains_hz
    steady = (look.flicker or 0.0) <= STEADY
    if exposure_s < half_period_s / 2 or (exposure_s < half_period_s and steady):
        return exposure_s
    halves = min(max(round(exposure_s / half_period_s), 1), int(longest_s / half_period_s))
    return halves * half_period_s if halves else exposure_s


def _sharpness(controls: Mapping[str, Held]) -> Suggestion | None:
    sharpness = controls.get("sharpness")
    if sharpness is None or sharpness.value <= sharpness.default:
        return None
    reason = f"sharpening moves edges; {sharpness.default:g} is the camera's default"
    return Suggestion(key="sharpness", value=sharpness.default, reason=reason)


def section(suggestions: Mapping[str, list[Suggestion]]) -> dict[str, dict[str, dict[str, dict[str, float]]]]:
    """The tables of a bench file that put them into force."""
    return {
        "cameras": {
            name: {"controls": {suggestion.key: suggestion.value for suggestion in those}}
            for name, those in suggestions.items()
            if those
        }
    }
