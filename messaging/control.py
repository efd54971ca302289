"""What the operator and the controller say to one another, and what the tendons are told."""

import dataclasses
from enum import StrEnum
from typing import ClassVar

import numpy as np
from google.protobuf.message import Message as ProtobufMessage

from messaging.checked import FloatArray, array, items
from messaging.errors import InvalidMessageError
from messaging.generated import nodal_pb2
from messaging.message import Message


class State(StrEnum):
    """The controller's states."""

    IDLE = "idle"
    """Torque is off; nothing moves."""
    HOMING = "homing"
    """Slack is taken up and the straight pose is found with the cameras."""
    READY = "ready"
    """Homed, torque on, standing still."""
    TRACKING = "tracking"
    """Nodal points follow the target."""
    HOLD = "hold"
    """Tendons keep their place, because the operator asked or because sensing is not to be trusted for a moment."""
    UNHOMED = "unhomed"
    """Servos hold the tendons for jogging; where their zero is, is not known."""
    FAULT = "fault"
    """Something was wrong; tendons are safe, and only the operator leads out of it."""


class Action(StrEnum):
    """What the operator may ask of the controller."""

    HOME = "home"
    ARM = "arm"
    HOLD = "hold"
    PAUSE = "pause"
    RESUME = "resume"
    ABORT = "abort"
    JOG = "jog"
    RELAX = "relax"
    STOP = "stop"
    STATUS = "status"


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ActionRequest(Message):
    """One action asked of the controller. A jog moves one axis, `1` or `2` or ... or `stage`, by `distance_mm`."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.ActionRequest

    action: Action
    axis: str = ""
    distance_mm: float = 0.0


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class FaultMessage(Message):
    """What all messages that can tell of a fault say about it: its code, the numbers, and what to do.

    Value and limit are numbers of `fault_unit`; both are 0 and the unit is empty where nothing was measured.
    """

    fault: str = ""
    fault_value: float = 0.0
    fault_limit: float = 0.0
    fault_unit: str = ""
    advice: str = ""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Reply(FaultMessage):
    """Whether a request was accepted, the state that followed from it, and why not; and the fault that it is in."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.Reply

    accepted: bool
    state: str
    reason: str


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Target(Message):
    """Where named nodal points should go, in the robot frame: a pose to hold (one moment), or a path through time.

    `time_s` starts at 0 and increases; a path that repeats goes on from its moment `repeat_from_s` when the last is
    reached, so its positions at these two should agree. Between moments positions are interpolated.
    """

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.Target

    name: str
    node_names: tuple[str, ...] = items("node")
    weights: FloatArray = array("node")
    time_s: FloatArray = array("moment")
    position_mm: FloatArray = array("moment", "node", 3)
    repeat: bool
    repeat_from_s: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what nothing could follow; raises InvalidMessageError."""
        super().__post_init__()
        if not self.node_names or len(set(self.node_names)) != len(self.node_names):
            raise InvalidMessageError(
                f"target {self.name}: nodal points {list(self.node_names)} must be named once each"
            )
        if not len(self.time_s) or self.time_s[0] != 0 or (np.diff(self.time_s) <= 0).any():
            raise InvalidMessageError(f"target {self.name}: times must start at 0 s and increase")
        if self.repeat_from_s and self.repeat_from_s not in self.time_s[:-1]:
            raise InvalidMessageError(
                f"target {self.name}: repeats from {self.repeat_from_s:g} s; that must be a moment of the path before its last"
            )
        if (self.weights < 0).any() or not (self.weights > 0).any():
            raise InvalidMessageError(
                f"target {self.name}: weights {self.weights.tolist()} must be 0 or more, and one above 0"
            )


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class TendonCommand(Message):
    """What was asked of each tendon pair and of the stage, and how old the frames behind it were."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.TendonCommand

    time_ns: int
    displacement_mm: FloatArray = array("pair")
    insertion_mm: float
    shape_sequence: int
    capture_to_command_ns: int


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class TendonState(Message):
    """What the servos report: the tendon pairs in order, then the stage; `alarm` says in words what `hardware_error` means."""

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.TendonState

    time_ns: int
    displacement_mm: FloatArray = array("pair")
    displacement_mm_s: FloatArray = array("pair")
    insertion_mm: float
    insertion_mm_s: float
    current_ma: FloatArray = array("servo")
    temperature_c: FloatArray = array("servo")
    voltage_v: FloatArray = array("servo")
    hardware_error: FloatArray = array("servo")
    torque: bool
    alarm: str = ""

    @property
    def position_mm(self) -> FloatArray:
        """(servo,): the displacements, and the insertion of a robot that has a stage."""
        return np.append(self.displacement_mm, self.insertion_mm)[: len(self.current_ma)]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ControllerState(FaultMessage):
    """One cycle of the controller: its state and why, the target's tracking, what it saw and how it kept time.

    `now_s` is monotonic, and `dt_s` the time that the command could use. `sighted_capture_ns` names the estimate that
    arrived in this cycle, `sighted_age_s` old (both 0 when none did); `shape_sequence` the one that it worked with.
    `drive_absence` says why there was no reading of the servos, and `drive_fault` is the code of the fault that this would
    be; with a reading, a TendonState of the same `time_ns` holds it. `heartbeat` is true when an operator's was heard.
    `commanded` is true when a command was written. With what was `Asked`, that is all that a cycle sees.
    `progress` is the share of the target that is done, 0 to 1, and `paused` true while it waits to be resumed.
    """

    protobuf: ClassVar[type[ProtobufMessage]] = nodal_pb2.ControllerState

    time_ns: int
    state: State
    reason: str
    target_name: str
    node_names: tuple[str, ...] = items("node")
    desired_mm: FloatArray = array("node", 3)
    measured_mm: FloatArray = array("node", 3)
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
    progress: float = 0.0
    paused: bool = False
    heartbeat: bool = False
    drive_fault: str = ""
