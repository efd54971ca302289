"""What `nodal calibrate base` found, in words and as one JSON object."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from calibration.base import Base, Difference
from nodal.calibrate.base.finding import Check, Outcome
from nodal.calibrate.base.keeping import before

LEAN_TOLERANCE_DEG = 1.0
"""Sensing takes it that the robot leaves its holder along the axis, within half of this."""
SCALE_NOTICED = 0.01
GOOD_PX, POOR_PX = 0.15, 0.5


def as_text(outcome: Outcome) -> str:
    """For people."""
    return "\n".join(_lines(outcome))


def warnings(outcome: Outcome) -> Iterator[str]:
    """What should be looked into."""
    for way in outcome.found:
        yield from _doubts(outcome.bases[way])
    if outcome.difference is not None and outcome.difference.too_large:
        yield (
            f"board and robot disagree about the {' and the '.join(outcome.difference.too_large)} by more than their "
            f"uncertainties allow; the rig is written by the {outcome.used}. Look whether the board sits in its fixture as "
            "[board.at_base] says, and whether robot.section_length_mm and the tendons' angles are right"
        )
    if outcome.check is not None and not outcome.check.good:
        rig = Path(outcome.bench.settings.calibration)
        kept = f"; the one before it is kept as {before(rig)}" if before(rig).exists() else ""
        yield f"sensing is not content with the new rig: {_verdict(outcome.check)}{kept}"


def as_builtins(outcome: Outcome) -> dict[str, Any]:
    """For programs: lengths in mm, angles in degrees."""
    apart = outcome.difference
    return {
        "bench": str(outcome.bench.path),
        "used": outcome.used,
        "found": {way: _figures(outcome.bases[way]) for way in outcome.found},
        "difference": None if apart is None else _apart(apart),
        "check": None if outcome.check is None else _check(outcome.check),
        "warnings": list(warnings(outcome)),
    }


def _lines(outcome: Outcome) -> Iterator[str]:
    for way in outcome.found:
        yield from _found(outcome.bases[way])
    if outcome.difference is not None:
        yield _difference(outcome.difference)
    if outcome.check is not None and outcome.check.good:
        yield f"check: {_verdict(outcome.check)}"
    yield f"written: {outcome.bench.settings.calibration}, with the robot frame by the {outcome.used}"


def _found(base: Base) -> Iterator[str]:
    x, y, z = base.matrix[:3, 3]
    axis_deg, roll_deg = np.degrees([base.axis_sigma_rad, base.roll_sigma_rad])
    yield f"robot frame by the {base.way}, from {base.frame_sets} set{'s'[: base.frame_sets - 1]} of pictures"
    yield f"  origin at ({x:.2f}, {y:.2f}, {z:.2f}) mm from the first camera"
    yield (
        f"  standard deviations: origin {base.origin_sigma_mm:.3f} mm, axis {axis_deg:.3f} degrees, roll {roll_deg:.3f} degrees"
    )
    residual = ", ".join(f"{px:.3f} px in {name}" for name, px in base.residual_px.items())
    meant = "the board's corners fit to" if base.way == "board" else "the robot's beginnings agree to"
    yield f"  residual: {residual}; {meant} {base.residual_mm:.3f} mm: {_judged(base)}"
    if base.robot is None:
        return
    if base.robot.travel_mm:
        yield (
            f"  stage: {base.robot.travel_mm:.2f} mm of travel, of which the cameras saw "
            f"{100 * base.robot.stage_scale:.2f} %; the robot leaves its holder {base.robot.lean_deg:.1f} degrees off it"
        )
    for pull in base.robot.pulls:
        yield (
            f"  {pull.name}: moved the tip by {pull.bend_mm:.1f} mm, {pull.off_deg:+.2f} degrees off "
            f"{'the opposite of ' * pull.reversed}{pull.angle_deg:g} degrees"
        )


def _judged(base: Base) -> str:
    worst = max(base.residual_px.values())
    return "good" if worst < GOOD_PX else "usable" if worst < POOR_PX else "poor"


def _doubts(base: Base) -> Iterator[str]:
    if max(base.residual_px.values()) >= POOR_PX:
        yield f"the residual by the {base.way} is poor: calibrate the cameras anew, or look whether one was moved since"
    if base.robot is None:
        return
    if opposed := ", ".join(pull.name for pull in base.robot.pulls if pull.reversed):
        others = ", ".join(pull.name for pull in base.robot.pulls if not pull.reversed)
        yield (
            f"by {others}, the sign of mm_per_rad is wrong for {opposed}: `nodal calibrate robot` will correct it. If X in the "
            f"pictures points away from where it should, it is the other way about: turn the signs of {others}, and find the base anew"
        )
    if not base.robot.travel_mm:
        yield "without a stage, Z is the direction in which the robot leaves its holder, known to a degree or so"
    if base.robot.lean_deg > LEAN_TOLERANCE_DEG:
        yield (
            f"the robot leaves its holder {base.robot.lean_deg:.1f} degrees off the stage's direction: sensing takes it for "
            "less than half a degree; straighten it in its holder"
        )
    if abs(base.robot.stage_scale - 1.0) > SCALE_NOTICED:
        yield (
            f"the cameras saw {100 * base.robot.stage_scale:.1f} % of the stage's travel: servos.stage.mm_per_rad or the "
            "board's square_mm is wrong"
        )


def _difference(apart: Difference) -> str:
    verdict = "more than their uncertainties allow" if apart.too_large else "within their uncertainties"
    return (
        f"board and robot differ by {apart.origin_mm:.3f} mm in the origin (allowed {apart.allowed_origin_mm:.3f}), "
        f"{np.degrees(apart.axis_rad):.3f} degrees in the axis ({np.degrees(apart.allowed_axis_rad):.3f}), "
        f"{np.degrees(apart.roll_rad):+.3f} degrees in the roll ({np.degrees(apart.allowed_roll_rad):.3f}): {verdict}"
    )


def _verdict(check: Check) -> str:
    if check.shape is None:
        return f"it refuses the robot at rest: {check.refusal}"
    flags = f"flags {', '.join(check.shape.flags)}" if check.shape.flags else "no flags"
    return (
        f"sensing measures the robot at rest with a residual of {check.shape.residual_px:.2f} px and a length of "
        f"{check.shape.length_mm:.2f} mm (known {check.known_length_mm:g} mm), {flags}"
    )


def _figures(base: Base) -> dict[str, Any]:
    known: dict[str, Any] = msgspec.to_builtins(base)
    return known | {
        "origin_sigma_mm": base.origin_sigma_mm,
        "axis_sigma_deg": float(np.degrees(base.axis_sigma_rad)),
        "roll_sigma_deg": float(np.degrees(base.roll_sigma_rad)),
    }


def _apart(apart: Difference) -> dict[str, Any]:
    return {
        "origin_mm": apart.origin_mm,
        "axis_deg": float(np.degrees(apart.axis_rad)),
        "roll_deg": float(np.degrees(apart.roll_rad)),
        "too_large": list(apart.too_large),
    }


def _check(check: Check) -> dict[str, Any]:
    shape = check.shape
    return {
        "good": check.good,
        "refusal": check.refusal,
        "residual_px": None if shape is None else shape.residual_px,
        "length_mm": None if shape is None else shape.length_mm,
        "flags": [] if shape is None else [str(flag) for flag in shape.flags],
    }
