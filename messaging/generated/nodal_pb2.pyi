from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable
from typing import ClassVar as _ClassVar, Optional as _Optional

DESCRIPTOR: _descriptor.FileDescriptor

class ShapeEstimate(_message.Message):
    __slots__ = ("sequence", "capture_time_ns", "capture_to_publish_ns", "refusal", "flags", "arc_mm", "centreline_mm", "node_names", "node_arc_mm", "node_mm", "node_covariance_mm2", "length_mm", "insertion_mm", "ray_gap_mm", "residual_px", "stage_names", "stage_s", "method", "epipolar_angle_rad", "known_length_mm", "ray_bias_mm", "camera_names", "camera_residual_px", "visible_mm")
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_TO_PUBLISH_NS_FIELD_NUMBER: _ClassVar[int]
    REFUSAL_FIELD_NUMBER: _ClassVar[int]
    FLAGS_FIELD_NUMBER: _ClassVar[int]
    ARC_MM_FIELD_NUMBER: _ClassVar[int]
    CENTRELINE_MM_FIELD_NUMBER: _ClassVar[int]
    NODE_NAMES_FIELD_NUMBER: _ClassVar[int]
    NODE_ARC_MM_FIELD_NUMBER: _ClassVar[int]
    NODE_MM_FIELD_NUMBER: _ClassVar[int]
    NODE_COVARIANCE_MM2_FIELD_NUMBER: _ClassVar[int]
    LENGTH_MM_FIELD_NUMBER: _ClassVar[int]
    INSERTION_MM_FIELD_NUMBER: _ClassVar[int]
    RAY_GAP_MM_FIELD_NUMBER: _ClassVar[int]
    RESIDUAL_PX_FIELD_NUMBER: _ClassVar[int]
    STAGE_NAMES_FIELD_NUMBER: _ClassVar[int]
    STAGE_S_FIELD_NUMBER: _ClassVar[int]
    METHOD_FIELD_NUMBER: _ClassVar[int]
    EPIPOLAR_ANGLE_RAD_FIELD_NUMBER: _ClassVar[int]
    KNOWN_LENGTH_MM_FIELD_NUMBER: _ClassVar[int]
    RAY_BIAS_MM_FIELD_NUMBER: _ClassVar[int]
    CAMERA_NAMES_FIELD_NUMBER: _ClassVar[int]
    CAMERA_RESIDUAL_PX_FIELD_NUMBER: _ClassVar[int]
    VISIBLE_MM_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    capture_time_ns: int
    capture_to_publish_ns: int
    refusal: str
    flags: _containers.RepeatedScalarFieldContainer[str]
    arc_mm: _containers.RepeatedScalarFieldContainer[float]
    centreline_mm: _containers.RepeatedScalarFieldContainer[float]
    node_names: _containers.RepeatedScalarFieldContainer[str]
    node_arc_mm: _containers.RepeatedScalarFieldContainer[float]
    node_mm: _containers.RepeatedScalarFieldContainer[float]
    node_covariance_mm2: _containers.RepeatedScalarFieldContainer[float]
    length_mm: float
    insertion_mm: float
    ray_gap_mm: float
    residual_px: float
    stage_names: _containers.RepeatedScalarFieldContainer[str]
    stage_s: _containers.RepeatedScalarFieldContainer[float]
    method: str
    epipolar_angle_rad: _containers.RepeatedScalarFieldContainer[float]
    known_length_mm: float
    ray_bias_mm: float
    camera_names: _containers.RepeatedScalarFieldContainer[str]
    camera_residual_px: _containers.RepeatedScalarFieldContainer[float]
    visible_mm: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, sequence: _Optional[int] = ..., capture_time_ns: _Optional[int] = ..., capture_to_publish_ns: _Optional[int] = ..., refusal: _Optional[str] = ..., flags: _Optional[_Iterable[str]] = ..., arc_mm: _Optional[_Iterable[float]] = ..., centreline_mm: _Optional[_Iterable[float]] = ..., node_names: _Optional[_Iterable[str]] = ..., node_arc_mm: _Optional[_Iterable[float]] = ..., node_mm: _Optional[_Iterable[float]] = ..., node_covariance_mm2: _Optional[_Iterable[float]] = ..., length_mm: _Optional[float] = ..., insertion_mm: _Optional[float] = ..., ray_gap_mm: _Optional[float] = ..., residual_px: _Optional[float] = ..., stage_names: _Optional[_Iterable[str]] = ..., stage_s: _Optional[_Iterable[float]] = ..., method: _Optional[str] = ..., epipolar_angle_rad: _Optional[_Iterable[float]] = ..., known_length_mm: _Optional[float] = ..., ray_bias_mm: _Optional[float] = ..., camera_names: _Optional[_Iterable[str]] = ..., camera_residual_px: _Optional[_Iterable[float]] = ..., visible_mm: _Optional[_Iterable[float]] = ...) -> None: ...

class Truth(_message.Message):
    __slots__ = ("capture_time_ns", "arc_mm", "centreline_mm", "insertion_mm")
    CAPTURE_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    ARC_MM_FIELD_NUMBER: _ClassVar[int]
    CENTRELINE_MM_FIELD_NUMBER: _ClassVar[int]
    INSERTION_MM_FIELD_NUMBER: _ClassVar[int]
    capture_time_ns: int
    arc_mm: _containers.RepeatedScalarFieldContainer[float]
    centreline_mm: _containers.RepeatedScalarFieldContainer[float]
    insertion_mm: float
    def __init__(self, capture_time_ns: _Optional[int] = ..., arc_mm: _Optional[_Iterable[float]] = ..., centreline_mm: _Optional[_Iterable[float]] = ..., insertion_mm: _Optional[float] = ...) -> None: ...

class NodalPoints(_message.Message):
    __slots__ = ("names", "arc_mm")
    NAMES_FIELD_NUMBER: _ClassVar[int]
    ARC_MM_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    arc_mm: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, names: _Optional[_Iterable[str]] = ..., arc_mm: _Optional[_Iterable[float]] = ...) -> None: ...

class Target(_message.Message):
    __slots__ = ("name", "node_names", "weights", "time_s", "position_mm", "repeat", "repeat_from_s")
    NAME_FIELD_NUMBER: _ClassVar[int]
    NODE_NAMES_FIELD_NUMBER: _ClassVar[int]
    WEIGHTS_FIELD_NUMBER: _ClassVar[int]
    TIME_S_FIELD_NUMBER: _ClassVar[int]
    POSITION_MM_FIELD_NUMBER: _ClassVar[int]
    REPEAT_FIELD_NUMBER: _ClassVar[int]
    REPEAT_FROM_S_FIELD_NUMBER: _ClassVar[int]
    name: str
    node_names: _containers.RepeatedScalarFieldContainer[str]
    weights: _containers.RepeatedScalarFieldContainer[float]
    time_s: _containers.RepeatedScalarFieldContainer[float]
    position_mm: _containers.RepeatedScalarFieldContainer[float]
    repeat: bool
    repeat_from_s: float
    def __init__(self, name: _Optional[str] = ..., node_names: _Optional[_Iterable[str]] = ..., weights: _Optional[_Iterable[float]] = ..., time_s: _Optional[_Iterable[float]] = ..., position_mm: _Optional[_Iterable[float]] = ..., repeat: _Optional[bool] = ..., repeat_from_s: _Optional[float] = ...) -> None: ...

class ActionRequest(_message.Message):
    __slots__ = ("action", "axis", "distance_mm")
    ACTION_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_MM_FIELD_NUMBER: _ClassVar[int]
    action: str
    axis: str
    distance_mm: float
    def __init__(self, action: _Optional[str] = ..., axis: _Optional[str] = ..., distance_mm: _Optional[float] = ...) -> None: ...

class Reply(_message.Message):
    __slots__ = ("accepted", "state", "reason", "fault", "fault_value", "fault_limit", "fault_unit", "advice")
    ACCEPTED_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    FAULT_VALUE_FIELD_NUMBER: _ClassVar[int]
    FAULT_LIMIT_FIELD_NUMBER: _ClassVar[int]
    FAULT_UNIT_FIELD_NUMBER: _ClassVar[int]
    ADVICE_FIELD_NUMBER: _ClassVar[int]
    accepted: bool
    state: str
    reason: str
    fault: str
    fault_value: float
    fault_limit: float
    fault_unit: str
    advice: str
    def __init__(self, accepted: _Optional[bool] = ..., state: _Optional[str] = ..., reason: _Optional[str] = ..., fault: _Optional[str] = ..., fault_value: _Optional[float] = ..., fault_limit: _Optional[float] = ..., fault_unit: _Optional[str] = ..., advice: _Optional[str] = ...) -> None: ...

class TendonCommand(_message.Message):
    __slots__ = ("time_ns", "displacement_mm", "insertion_mm", "shape_sequence", "capture_to_command_ns")
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    DISPLACEMENT_MM_FIELD_NUMBER: _ClassVar[int]
    INSERTION_MM_FIELD_NUMBER: _ClassVar[int]
    SHAPE_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_TO_COMMAND_NS_FIELD_NUMBER: _ClassVar[int]
    time_ns: int
    displacement_mm: _containers.RepeatedScalarFieldContainer[float]
    insertion_mm: float
    shape_sequence: int
    capture_to_command_ns: int
    def __init__(self, time_ns: _Optional[int] = ..., displacement_mm: _Optional[_Iterable[float]] = ..., insertion_mm: _Optional[float] = ..., shape_sequence: _Optional[int] = ..., capture_to_command_ns: _Optional[int] = ...) -> None: ...

class TendonState(_message.Message):
    __slots__ = ("time_ns", "displacement_mm", "insertion_mm", "current_ma", "temperature_c", "voltage_v", "hardware_error", "torque", "displacement_mm_s", "insertion_mm_s", "alarm")
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    DISPLACEMENT_MM_FIELD_NUMBER: _ClassVar[int]
    INSERTION_MM_FIELD_NUMBER: _ClassVar[int]
    CURRENT_MA_FIELD_NUMBER: _ClassVar[int]
    TEMPERATURE_C_FIELD_NUMBER: _ClassVar[int]
    VOLTAGE_V_FIELD_NUMBER: _ClassVar[int]
    HARDWARE_ERROR_FIELD_NUMBER: _ClassVar[int]
    TORQUE_FIELD_NUMBER: _ClassVar[int]
    DISPLACEMENT_MM_S_FIELD_NUMBER: _ClassVar[int]
    INSERTION_MM_S_FIELD_NUMBER: _ClassVar[int]
    ALARM_FIELD_NUMBER: _ClassVar[int]
    time_ns: int
    displacement_mm: _containers.RepeatedScalarFieldContainer[float]
    insertion_mm: float
    current_ma: _containers.RepeatedScalarFieldContainer[float]
    temperature_c: _containers.RepeatedScalarFieldContainer[float]
    voltage_v: _containers.RepeatedScalarFieldContainer[float]
    hardware_error: _containers.RepeatedScalarFieldContainer[float]
    torque: bool
    displacement_mm_s: _containers.RepeatedScalarFieldContainer[float]
    insertion_mm_s: float
    alarm: str
    def __init__(self, time_ns: _Optional[int] = ..., displacement_mm: _Optional[_Iterable[float]] = ..., insertion_mm: _Optional[float] = ..., current_ma: _Optional[_Iterable[float]] = ..., temperature_c: _Optional[_Iterable[float]] = ..., voltage_v: _Optional[_Iterable[float]] = ..., hardware_error: _Optional[_Iterable[float]] = ..., torque: _Optional[bool] = ..., displacement_mm_s: _Optional[_Iterable[float]] = ..., insertion_mm_s: _Optional[float] = ..., alarm: _Optional[str] = ...) -> None: ...

class ControllerState(_message.Message):
    __slots__ = ("time_ns", "state", "reason", "target_name", "node_names", "desired_mm", "measured_mm", "tracking_error_mm", "shape_sequence", "shape_age_s", "lateness_s", "busy_s", "overruns", "now_s", "dt_s", "sighted_capture_ns", "sighted_age_s", "drive_absence", "commanded", "fault", "fault_value", "fault_limit", "fault_unit", "advice", "progress", "paused", "heartbeat", "drive_fault")
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    TARGET_NAME_FIELD_NUMBER: _ClassVar[int]
    NODE_NAMES_FIELD_NUMBER: _ClassVar[int]
    DESIRED_MM_FIELD_NUMBER: _ClassVar[int]
    MEASURED_MM_FIELD_NUMBER: _ClassVar[int]
    TRACKING_ERROR_MM_FIELD_NUMBER: _ClassVar[int]
    SHAPE_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    SHAPE_AGE_S_FIELD_NUMBER: _ClassVar[int]
    LATENESS_S_FIELD_NUMBER: _ClassVar[int]
    BUSY_S_FIELD_NUMBER: _ClassVar[int]
    OVERRUNS_FIELD_NUMBER: _ClassVar[int]
    NOW_S_FIELD_NUMBER: _ClassVar[int]
    DT_S_FIELD_NUMBER: _ClassVar[int]
    SIGHTED_CAPTURE_NS_FIELD_NUMBER: _ClassVar[int]
    SIGHTED_AGE_S_FIELD_NUMBER: _ClassVar[int]
    DRIVE_ABSENCE_FIELD_NUMBER: _ClassVar[int]
    COMMANDED_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    FAULT_VALUE_FIELD_NUMBER: _ClassVar[int]
    FAULT_LIMIT_FIELD_NUMBER: _ClassVar[int]
    FAULT_UNIT_FIELD_NUMBER: _ClassVar[int]
    ADVICE_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    PAUSED_FIELD_NUMBER: _ClassVar[int]
    HEARTBEAT_FIELD_NUMBER: _ClassVar[int]
    DRIVE_FAULT_FIELD_NUMBER: _ClassVar[int]
    time_ns: int
    state: str
    reason: str
    target_name: str
    node_names: _containers.RepeatedScalarFieldContainer[str]
    desired_mm: _containers.RepeatedScalarFieldContainer[float]
    measured_mm: _containers.RepeatedScalarFieldContainer[float]
    tracking_error_mm: float
    shape_sequence: int
    shape_age_s: float
    lateness_s: float
    busy_s: float
    overruns: int
    now_s: float
    dt_s: float
    sighted_capture_ns: int
    sighted_age_s: float
    drive_absence: str
    commanded: bool
    fault: str
    fault_value: float
    fault_limit: float
    fault_unit: str
    advice: str
    progress: float
    paused: bool
    heartbeat: bool
    drive_fault: str
    def __init__(self, time_ns: _Optional[int] = ..., state: _Optional[str] = ..., reason: _Optional[str] = ..., target_name: _Optional[str] = ..., node_names: _Optional[_Iterable[str]] = ..., desired_mm: _Optional[_Iterable[float]] = ..., measured_mm: _Optional[_Iterable[float]] = ..., tracking_error_mm: _Optional[float] = ..., shape_sequence: _Optional[int] = ..., shape_age_s: _Optional[float] = ..., lateness_s: _Optional[float] = ..., busy_s: _Optional[float] = ..., overruns: _Optional[int] = ..., now_s: _Optional[float] = ..., dt_s: _Optional[float] = ..., sighted_capture_ns: _Optional[int] = ..., sighted_age_s: _Optional[float] = ..., drive_absence: _Optional[str] = ..., commanded: _Optional[bool] = ..., fault: _Optional[str] = ..., fault_value: _Optional[float] = ..., fault_limit: _Optional[float] = ..., fault_unit: _Optional[str] = ..., advice: _Optional[str] = ..., progress: _Optional[float] = ..., paused: _Optional[bool] = ..., heartbeat: _Optional[bool] = ..., drive_fault: _Optional[str] = ...) -> None: ...

class Asked(_message.Message):
    __slots__ = ("time_ns", "service", "request", "accepted", "state", "reason", "fault", "fault_value", "fault_limit", "fault_unit", "advice")
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    SERVICE_FIELD_NUMBER: _ClassVar[int]
    REQUEST_FIELD_NUMBER: _ClassVar[int]
    ACCEPTED_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    FAULT_VALUE_FIELD_NUMBER: _ClassVar[int]
    FAULT_LIMIT_FIELD_NUMBER: _ClassVar[int]
    FAULT_UNIT_FIELD_NUMBER: _ClassVar[int]
    ADVICE_FIELD_NUMBER: _ClassVar[int]
    time_ns: int
    service: str
    request: bytes
    accepted: bool
    state: str
    reason: str
    fault: str
    fault_value: float
    fault_limit: float
    fault_unit: str
    advice: str
    def __init__(self, time_ns: _Optional[int] = ..., service: _Optional[str] = ..., request: _Optional[bytes] = ..., accepted: _Optional[bool] = ..., state: _Optional[str] = ..., reason: _Optional[str] = ..., fault: _Optional[str] = ..., fault_value: _Optional[float] = ..., fault_limit: _Optional[float] = ..., fault_unit: _Optional[str] = ..., advice: _Optional[str] = ...) -> None: ...

class Memory(_message.Message):
    __slots__ = ("time_ns", "content", "publication")
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    CONTENT_FIELD_NUMBER: _ClassVar[int]
    PUBLICATION_FIELD_NUMBER: _ClassVar[int]
    time_ns: int
    content: bytes
    publication: int
    def __init__(self, time_ns: _Optional[int] = ..., content: _Optional[bytes] = ..., publication: _Optional[int] = ...) -> None: ...

class RecorderRequest(_message.Message):
    __slots__ = ("action", "file")
    ACTION_FIELD_NUMBER: _ClassVar[int]
    FILE_FIELD_NUMBER: _ClassVar[int]
    action: str
    file: str
    def __init__(self, action: _Optional[str] = ..., file: _Optional[str] = ...) -> None: ...

class SceneRequest(_message.Message):
    __slots__ = ("scene",)
    SCENE_FIELD_NUMBER: _ClassVar[int]
    scene: str
    def __init__(self, scene: _Optional[str] = ...) -> None: ...
