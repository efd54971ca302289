"""What came out of still images: one JSON object, or a table for people."""

import json
from collections.abc import Iterator

import numpy as np

from nodal.still import Answer, Refusal
from sensing.shape import Shape


def as_json(found: Answer | Refusal) -> str:
    """One JSON object; lengths in mm, robot frame."""
    if isinstance(found, Refusal):
        return json.dumps({"refused": found.reason})
    shape, evidence = found.shape, found.shape.evidence
    angle_deg, arc_mm = _least_angle(shape)
    return json.dumps(
        {
            "method": str(found.method.name),
            "nodes": [
                {"name": name, "arc_mm": float(arc), "position_mm": place.tolist(), "sigma_mm": float(sigma)}
                for name, arc, place, sigma in zip(
                    found.points.names, found.points.arc_mm, found.node_mm, found.sigma_mm, strict=True
                )
            ],
            "centreline_mm": shape.centreline.points_mm.tolist(),
            "length_mm": shape.length_mm,
            "known_length_mm": found.method.scene.length_mm,
            "cameras": [
                {"name": name, "residual_px": residual, "visible_mm": evidence.visible_mm[name]}
                for name, residual in evidence.residual_px.items()
            ],
            "ray_gap_mm": evidence.ray_gap_mm,
            "ray_bias_mm": evidence.ray_bias_mm,
            "least_epipolar_angle": {"angle_deg": angle_deg, "arc_mm": arc_mm},
            "flags": [str(flag) for flag in shape.flags],
            "stage_ms": {name: 1e3 * seconds for name, seconds in shape.stage_s.items()},
        }
    )


def as_text(found: Answer | Refusal) -> str:
    """A table for people."""
    return f"refused: {found.reason}" if isinstance(found, Refusal) else "\n".join(_lines(found))


def _lines(found: Answer) -> Iterator[str]:
    shape, evidence, known_mm = found.shape, found.shape.evidence, found.method.scene.length_mm
    yield f"method {found.method.name}"
    yield "node      arc mm        x mm        y mm        z mm    sigma mm"
    for name, arc, place, sigma in zip(
        found.points.names, found.points.arc_mm, found.node_mm, found.sigma_mm, strict=True
    ):
        yield f"{name:<8}{arc:8.2f}" + "".join(f"{value:12.3f}" for value in (*place, sigma))
    compared = (
        ""
        if known_mm is None
        else f", {shape.length_mm - known_mm:+.2f} mm against the known {known_mm:g} mm"
    )
    yield f"length {shape.length_mm:.2f} mm{compared}"
    for name, residual_px in evidence.residual_px.items():
        yield f"camera {name}: residual {residual_px:.2f} px, sees {evidence.visible_mm[name]:.1f} mm"
    yield f"mean ray gap {evidence.ray_gap_mm:.3f} mm, bias {evidence.ray_bias_mm:+.3f} mm"
    angle_deg, arc_mm = _least_angle(shape)
    yield f"least angle to the epipolar direction {angle_deg:.0f} degrees, {arc_mm:.0f} mm from the base"
    yield f"flags: {', '.join(shape.flags) or 'none'}"
    yield "stages, ms: " + ", ".join(f"{name} {1e3 * seconds:.0f}" for name, seconds in shape.stage_s.items())


def _least_angle(shape: Shape) -> tuple[float, float]:
    """The smallest angle to the epipolar direction in degrees, and how far from the base: depth is known least there."""
    angles = shape.evidence.epipolar_angle_rad
    least = int(angles.argmin())
    return float(np.degrees(angles[least])), float(shape.centreline.arc_mm[least])
