"""Which settings of a camera would make its pictures better. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass

from nodal.cameras.judging.measuring import Look
from nodal.cameras.judging.verdicts import BRIGHT, DIM, MANY_CLIPPED, STEADY
from sensing.pictures.light import LINEAR

WANTED_LEVEL = 128
"""Half of full scale: a stop of room above, and two below."""
SHORTEST_S = 0.0003
FRAME_SHARE = 0.9
"""An exposure may take so much of a frame; the rest is for reading it out."""
LEAST_CHANGE = 1.1
CLIPPED_SHARE = 0.7
"""Half a stop less where it is a part of the picture that is clipped, and not the backdrop."""


@dataclass(frozen=True, kw_only=True)
class Suggestion:
    """Another value for a key of [cameras.NAME.controls], and why."""

    key: str
    value: float
    reason: str


def suggestions_for(look: Look, controls: Mapping[str, float], rate_hz: float) -> list[Suggestion]:
    """What to set in the bench file for a camera that holds these `controls`, by their keys; empty where they do."""
    present_s = controls.get("exposure_s")
    if not present_s or (wanted := _exposure(look, present_s)) is None:
        return []
    wanted_s, reason = wanted
    possible_s = min(max(wanted_s, SHORTEST_S), FRAME_SHARE / rate_hz)
    exposure_s = _without_flicker(look, possible_s, FRAME_SHARE / rate_hz, controls.get("power_line_hz"))
    if 1 / LEAST_CHANGE < exposure_s / present_s < LEAST_CHANGE:
        return []
    return [Suggestion(key="exposure_s", value=round(exposure_s, 4), reason=reason)]


def _exposure(look: Look, exposure_s: float) -> tuple[float, str] | None:
    """What would bring the backdrop to the middle, or tame the flicker, and why; None where nothing is to be changed."""
    level, clipped, flicker = look.lighting.level, look.lighting.clipped_share, look.flicker or 0.0
    if not DIM <= level <= BRIGHT:
        share = float(LINEAR[WANTED_LEVEL] / max(LINEAR[round(level)], LINEAR[1]))
        return share * exposure_s, f"the backdrop is at level {level:.0f}, good are {DIM} to {BRIGHT}"
    if clipped > MANY_CLIPPED:
        return CLIPPED_SHARE * exposure_s, f"{100 * clipped:.1f} % of the picture is clipped"
    if flicker > STEADY:
        return exposure_s, f"light changes by {100 * flicker:.1f} % from picture to picture"
    return None


def _without_flicker(look: Look, exposure_s: float, longest_s: float, power_line_hz: float | None) -> float:
    """Whole half periods of the mains, unless that is much longer or the light is steady enough for a shorter one."""
    if not power_line_hz:
        return exposure_s
    half_period_s = 0.5 / power_line_hz
    steady = (look.flicker or 0.0) <= STEADY
    if exposure_s < half_period_s / 2 or (exposure_s < half_period_s and steady):
        return exposure_s
    return max(min(round(exposure_s / half_period_s), int(longest_s / half_period_s)), 1) * half_period_s


def section(suggestions: Mapping[str, list[Suggestion]]) -> dict[str, dict[str, dict[str, dict[str, float]]]]:
    """The tables of a bench file that put them into force."""
    return {
        "cameras": {
            name: {"controls": {suggestion.key: suggestion.value for suggestion in those}}
            for name, those in suggestions.items()
            if those
        }
    }
