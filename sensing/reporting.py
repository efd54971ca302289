"""A shape, or the reason why there is none, as the message that goes out."""

import numpy as np

from messaging.checked import FloatArray
from messaging.shape import Flag, NodalPoints, ShapeEstimate
from sensing.errors import SensingError
from sensing.pipeline import Shape


def estimate_message(
    shape: Shape,
    points: NodalPoints,
    sequence: int,
    capture_time_ns: int,
    age_ns: int,
    extra_flags: tuple[Flag, ...],
) -> ShapeEstimate:
    """The message of a resolved shape; `extra_flags` are those that the pictures cannot know of."""
    nodes, covariance = shape.nodes(points.arc_mm)
    return ShapeEstimate(
        sequence=sequence,
        capture_time_ns=capture_time_ns,
        capture_to_publish_ns=age_ns,
        refusal="",
        flags=tuple(str(flag) for flag in (*shape.flags, *extra_flags)),
        arc_mm=shape.arc_mm,
        centreline_mm=shape.centreline_mm,
        node_names=points.names,
        node_arc_mm=points.arc_mm,
        node_mm=nodes,
        node_covariance_mm2=covariance,
        length_mm=shape.length_mm,
        insertion_mm=shape.insertion_mm,
        ray_gap_mm=shape.ray_gap_mm,
        residual_px=shape.residual_px,
        stage_names=tuple(shape.stage_s),
        stage_s=np.array(list(shape.stage_s.values())),
    )


def refusal_message(
    error: SensingError, sequence: int, capture_time_ns: int, age_ns: int, insertion_mm: float
) -> ShapeEstimate:
    """The message that says why a frame set has no shape."""
    none: FloatArray = np.zeros(0)
    return ShapeEstimate(
        sequence=sequence,
        capture_time_ns=capture_time_ns,
        capture_to_publish_ns=age_ns,
        refusal=str(error),
        flags=(),
        arc_mm=none,
        centreline_mm=np.zeros((0, 3)),
        node_names=(),
        node_arc_mm=none,
        node_mm=np.zeros((0, 3)),
        node_covariance_mm2=np.zeros((0, 3, 3)),
        length_mm=0.0,
        insertion_mm=insertion_mm,
        ray_gap_mm=0.0,
        residual_px=0.0,
        stage_names=(),
        stage_s=none,
    )
