"""What stands below the pictures of a scene, in words. Pure."""

import dataclasses
import datetime as dt
from enum import Enum

from messaging.control import State
from nodal.exports.video.scenes import Scene


class Tone(Enum):
    """How grave a line is."""

    PLAIN = "plain"
    DOUBT = "doubt"
    TROUBLE = "trouble"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Caption:
    """Three lines: what goes on, how well, and what speaks against it; `time` stands across from the first."""

    doing: str
    doing_tone: Tone
    figures: str
    remark: str
    remark_tone: Tone
    time: str


def caption(scene: Scene, beginning_ns: int) -> Caption:
    """Of one scene of a recording that begins at this Unix time."""
    doing, doing_tone = _doing(scene)
    remark, remark_tone = _remark(scene)
    moment = dt.datetime.fromtimestamp(scene.time_ns // 10**9, dt.UTC)
    return Caption(
        doing=doing,
        doing_tone=doing_tone,
        figures=_figures(scene),
        remark=remark,
        remark_tone=remark_tone,
        time=f"{(scene.time_ns - beginning_ns) / 1e9:.2f} s    {moment:%Y-%m-%d %H:%M:%S} UTC",
    )


def _doing(scene: Scene) -> tuple[str, Tone]:
    state = scene.state
    if state is None:
        return "no controller", Tone.PLAIN
    if state.state is State.TRACKING:
        return f"tracking {state.target_name}", Tone.PLAIN
    tone = {State.HOLD: Tone.DOUBT, State.FAULT: Tone.TROUBLE}.get(state.state, Tone.PLAIN)
    return f"{state.state}: {state.reason}" if state.reason else str(state.state), tone


def _figures(scene: Scene) -> str:
    figures = []
    if scene.state and scene.acted_on and scene.state.target_name:
        figures.append(f"tracking error {scene.state.tracking_error_mm:.2f} mm")
    if scene.shape and not scene.shape.refusal:
        figures += [
            f"length {scene.shape.length_mm:.2f} mm",
            f"ray gap {scene.shape.ray_gap_mm:.3f} mm",
            f"residual {scene.shape.residual_px:.2f} px",
            f"estimated in {scene.shape.capture_to_publish_ns / 1e6:.0f} ms",
        ]
    return "    ".join(figures)


def _remark(scene: Scene) -> tuple[str, Tone]:
    if scene.shape is None:
        return "frame set not estimated", Tone.DOUBT
    if scene.shape.refusal:
        return f"no shape: {scene.shape.refusal}", Tone.TROUBLE
    if scene.shape.flags:
        flags = ", ".join(flag.replace("_", " ") for flag in scene.shape.flags)
        return f"not to be trusted: {flags}", Tone.DOUBT
    return "", Tone.PLAIN
