"""Which settings of a camera would make its pictures better. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass

from nodal.cameras.judging.measuring import Look
from nodal.cameras.judging.verdicts import BRIGHT, DIM, FLICKERING, MANY_CLIPPED, STEADY
from sensing.pictures.light import LINEAR

WANTED_LEVEL = 128
"""Half of full scale: a stop of room above, and two below."""
SHORTEST_S = 0.0003
FRAME_SHARE = 0.9
"""An exposure may take so much of a frame; the rest is for reading it out."""
LEAST_CHANGE = 1.1
CLIPPED_GAIN = 0.7


@dataclass(frozen=True, kw_only=True)
class Suggestion:
    """Another value for a key of [cameras.NAME.controls], and why."""

    key: str
    value: float
    reason: str


def suggestions_for(look: Look, controls: Mapping[str, float], rate_hz: float) -> list[Suggestion]:
    """What to set in the bench file for a camera that holds these `controls`, by their keys; empty where they do."""
    present_s = controls.get("exposure_s")
    if not present_s:
        return []
    longest_s = FRAME_SHARE / rate_hz
    wanted_s, reason = _exposure(look, present_s)
    exposure_s = _without_flicker(
        look, min(max(wanted_s, SHORTEST_S), longest_s), controls.get("power_line_hz")
    )
    found = []
    if not 1 / LEAST_CHANGE < exposure_s / present_s < LEAST_CHANGE:
        found.append(Suggestion(key="exposure_s", value=round(exposure_s, 4), reason=reason))
    return found


def _exposure(look: Look, exposure_s: float) -> tuple[float, str]:
    """What would bring the backdrop to the middle, if it is not well exposed."""
    level, clipped = look.lighting.level, look.lighting.clipped_share
    if clipped > MANY_CLIPPED and level <= BRIGHT:
        return CLIPPED_GAIN * exposure_s, f"{100 * clipped:.0f} % of the picture is clipped"
    if DIM <= level <= BRIGHT:
        return exposure_s, f"light changes by {100 * (look.flicker or 0):.0f} % from picture to picture"
    share = LINEAR[WANTED_LEVEL] / max(LINEAR[round(level)], LINEAR[1])
    return (
        float(share) * exposure_s,
        f"the backdrop is at level {level:.0f}, {DIM} to {BRIGHT} leave room on both sides",
    )


def _without_flicker(look: Look, exposure_s: float, power_line_hz: float | None) -> float:
    """The nearest exposure that lasts whole half periods of the mains, where lamps flicker and it is long enough."""
    if not power_line_hz or (look.flicker or 0.0) <= STEADY:
        return exposure_s
    half_period_s = 0.5 / power_line_hz
    if exposure_s < half_period_s / 2 and (look.flicker or 0.0) <= FLICKERING:
        return exposure_s
    return max(round(exposure_s / half_period_s), 1) * half_period_s


def section(suggestions: Mapping[str, list[Suggestion]]) -> dict[str, dict[str, dict[str, dict[str, float]]]]:
    """The tables of a bench file that put them into force."""
    return {
        "cameras": {
            name: {"controls": {suggestion.key: suggestion.value for suggestion in those}}
            for name, those in suggestions.items()
            if those
        }
    }
