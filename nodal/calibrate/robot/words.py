"""What `nodal calibrate robot` found, in words and as one JSON object."""

from collections.abc import Iterator

import msgspec

from nodal.calibrate.robot.results import AxisFound, RobotFound

_WEAK = 0.3
"""Gain below which an axis is worth a warning."""


def as_json(found: RobotFound) -> str:
    """For programs: what stands in robot.json."""
    return msgspec.json.encode(found).decode()


def as_text(found: RobotFound) -> str:
    """For people."""
    return "\n".join(_lines(found))


def _lines(found: RobotFound) -> Iterator[str]:
    if found.reversed:
        yield f"signs corrected: {', '.join(found.reversed)}"
    for axis in found.axes:
        yield _axis(axis)
    stage = zip(found.identified.stage_gain, found.identified.stage_gain_sigma, strict=True)
    for gain, sigma in stage:
        yield f"stage: moves {1 + gain:.3f} ± {sigma:.3f} mm per mm"
    bias = ", ".join(
        f"{value:.3f} ± {sigma:.3f}"
        for value, sigma in zip(found.identified.bias_rad, found.identified.bias_sigma_rad, strict=True)
    )
    yield f"bends at the homed zero, towards +X and +Y of each section: {bias} rad"
    held = found.held_out
    yield (
        f"{found.poses} poses fitted to {found.fit_rms_mm:.2f} mm RMS; {held.poses} others foreseen without feedback:"
    )
    for node in held.nodes:
        yield f"  {node.name} at {node.arc_mm:g} mm: {node.before_mm:.2f} mm as drawn, {node.after_mm:.2f} mm as identified"
    before, after = (100 * value / found.length_mm for value in (held.before_mm, held.after_mm))
    yield (
        f"  all: {held.before_mm:.2f} mm ({before:.1f} % of length) as drawn, {held.after_mm:.2f} mm ({after:.1f} %) as identified"
    )
    if found.refused:
        yield f"{found.refused} poses were not reached: {'; '.join(found.refused_because)}"
    if found.doubt:
        yield f"not written: {found.doubt}"
        return
    yield f"written: [controller.identified], {found.date}, in {found.seconds:.0f} s; a controller reads it when it starts"


def _axis(axis: AxisFound) -> str:
    others = ", ".join(
        f"section {section} by {share:+.2f} (drawn {drawn:+.2f})"
        for section, (share, drawn) in enumerate(
            zip(axis.bends_others, axis.bends_others_drawn, strict=True), start=1
        )
        if section != axis.section
    )
    words = (
        f"{axis.name}: bends its section {axis.gain:.2f} ± {axis.gain_sigma:.2f} times as drawn"
        + (f", {others}" if others else "")
        + f"; lost motion {axis.lost_motion_mm:.2f} ± {axis.lost_motion_sigma_mm:.2f} mm"
    )
    if axis.current_at_rest_ma is not None:
        words += f"; {axis.current_at_rest_ma:.0f} mA at rest"
    if axis.current_between_ways_ma is not None:
        words += f", {axis.current_between_ways_ma:.0f} mA between coming from either side"
    return words + (": hardly bends at all: is the tendon slack?" if axis.gain < _WEAK else "")
