"""A shape, or the reason why there is none, as the message that goes out."""

import numpy as np

from messaging.checked import FloatArray
from messaging.shape import Flag, ShapeEstimate
from sensing.errors import SensingError
from sensing.method import Method
from sensing.set_inputs import SetInputs
from sensing.shape import Shape


def estimate_message(shape: Shape, inputs: SetInputs, method: Method, age_ns: int) -> ShapeEstimate:
    """The message of a resolved shape; raises NodalPointError when a nodal point that was asked for is not on it."""
    nodes, covariance = shape.nodes(inputs.points.arc_mm)
    evidence = shape.evidence
    unknown = () if inputs.base_known else (Flag.BASE_UNKNOWN,)
    return ShapeEstimate(
        sequence=inputs.sequence,
        capture_time_ns=inputs.capture_time_ns,
        capture_to_publish_ns=age_ns,
        refusal="",
        method=str(method.name),
        flags=tuple(str(flag) for flag in (*evidence.flags, *unknown)),
        arc_mm=shape.centreline.arc_mm,
        centreline_mm=shape.centreline.points_mm,
        epipolar_angle_rad=evidence.epipolar_angle_rad,
        node_names=inputs.points.names,
        node_arc_mm=inputs.points.arc_mm,
        node_mm=nodes,
        node_covariance_mm2=covariance,
        length_mm=shape.length_mm,
        known_length_mm=method.scene.length_mm or 0.0,
        insertion_mm=shape.insertion_mm,
        ray_gap_mm=evidence.ray_gap_mm,
        ray_bias_mm=evidence.ray_bias_mm,
        camera_names=tuple(evidence.residual_px),
        residual_px=shape.residual_px,
        camera_residual_px=np.array(list(evidence.residual_px.values())),
        visible_mm=np.array(list(evidence.visible_mm.values())),
        stage_names=tuple(shape.stage_s),
        stage_s=np.array(list(shape.stage_s.values())),
    )


def refusal_message(error: SensingError, inputs: SetInputs, method: Method, age_ns: int) -> ShapeEstimate:
    """The message that says why a frame set has no shape, and whether a frame was missing from it."""
    none: FloatArray = np.zeros(0)
    incomplete = any(camera.name not in inputs.jpegs for camera in method.scene.cameras)
    return ShapeEstimate(
        sequence=inputs.sequence,
        capture_time_ns=inputs.capture_time_ns,
        capture_to_publish_ns=age_ns,
        refusal=str(error),
        method=str(method.name),
        flags=(str(Flag.CAMERA_LOST),) if incomplete else (),
        arc_mm=none,
        centreline_mm=np.zeros((0, 3)),
        epipolar_angle_rad=none,
        node_names=(),
        node_arc_mm=none,
        node_mm=np.zeros((0, 3)),
        node_covariance_mm2=np.zeros((0, 3, 3)),
        length_mm=0.0,
        known_length_mm=0.0,
        insertion_mm=inputs.insertion_mm,
        ray_gap_mm=0.0,
        ray_bias_mm=0.0,
        camera_names=(),
        residual_px=0.0,
        camera_residual_px=none,
        visible_mm=none,
        stage_names=(),
        stage_s=none,
    )
