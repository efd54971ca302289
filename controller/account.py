"""What a cycle tells the bench about itself. Pure."""

import dataclasses

import numpy as np

from controller.checked import checked
from controller.cycle import Inputs, LoopState, Outputs
from drivers.actuators import ActuatorState
from messaging.control import ControllerState, TendonCommand, TendonState

NO_SHAPE_YET = 0
"""As `shape_sequence`."""
REPEATED = -1
"""As `capture_to_command_ns` of commands that no new shape led to."""
_NO_NODES = np.zeros((0, 3))
_NEVER_S = 1e9
"""As `shape_age_s` before the first shape: messages carry finite numbers only."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Timing:
    """How a cycle kept time: when it wrote its command on the loop's clock, the Unix time then, and the pace's figures."""

    written_s: float
    time_ns: int
    lateness_s: float
    busy_s: float
    overruns: int


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Account:
    """What one cycle says; all messages carry the same `time_ns`."""

    command: TendonCommand | None
    tendons: TendonState | None
    controller: ControllerState
    fresh: bool
    """A shape that may be acted on arrived in this cycle."""


def account_of(
    before: LoopState, after: LoopState, inputs: Inputs, outputs: Outputs, *, commanded: bool, timing: Timing
) -> Account:
    """The messages of the cycle that led from one state to the other; they carry what it could use of its inputs."""
    inputs = checked(inputs, outputs.tendons, len(after.command_mm))
    fresh = after.seen is not before.seen
    return Account(
        command=_tendon_command(after, outputs, fresh=fresh, timing=timing) if commanded else None,
        tendons=_tendon_state(inputs.drive, time_ns=timing.time_ns),
        controller=_controller_state(after, inputs, outputs, commanded=commanded, timing=timing),
        fresh=fresh,
    )


def _tendon_command(
    state: LoopState, outputs: Outputs, *, fresh: bool, timing: Timing
) -> TendonCommand | None:
    """The command that was written. Only the first one after a shape arrived tells how old its frames were."""
    if outputs.command_mm is None:
        return None
    displacement_mm, insertion_mm = outputs.split(outputs.command_mm)
    age_ns = REPEATED
    if fresh and state.seen is not None:
        age_ns = round((timing.written_s - state.seen.capture_s) * 1e9)
    return TendonCommand(
        time_ns=timing.time_ns,
        displacement_mm=displacement_mm,
        insertion_mm=insertion_mm,
        shape_sequence=NO_SHAPE_YET if state.seen is None else state.seen.shape.sequence,
        capture_to_command_ns=age_ns,
    )


def _tendon_state(drive: ActuatorState | None, *, time_ns: int) -> TendonState | None:
    """What the servos reported in this cycle."""
    if drive is None:
        return None
    return TendonState(
        time_ns=time_ns,
        displacement_mm=drive.displacement_mm,
        displacement_mm_s=drive.displacement_mm_s,
        insertion_mm=drive.insertion_mm,
        insertion_mm_s=drive.insertion_mm_s,
        current_ma=drive.current_ma,
        temperature_c=drive.temperature_c,
        voltage_v=drive.voltage_v,
        hardware_error=np.array(drive.hardware_error, dtype=np.float64),
        torque=drive.torque,
        alarm=drive.alarm,
    )


def _controller_state(
    state: LoopState,
    inputs: Inputs,
    outputs: Outputs,
    *,
    commanded: bool,
    timing: Timing,
) -> ControllerState:
    """The cycle. Desired and measured nodal points both belong to the capture of the shape that the cycle worked with."""
    task, seen, sighting = state.task, state.seen, inputs.sighting
    return ControllerState(
        time_ns=timing.time_ns,
        state=state.mode.state,
        reason=outputs.reason,
        target_name="" if task is None else task.reference.target.name,
        node_names=() if task is None else task.reference.target.node_names,
        desired_mm=_NO_NODES if task is None else task.desired_mm,
        measured_mm=_NO_NODES if task is None else task.measured_mm,
        tracking_error_mm=0.0 if task is None else task.error_mm,
        shape_sequence=NO_SHAPE_YET if seen is None else seen.shape.sequence,
        shape_age_s=_NEVER_S if seen is None else inputs.now_s - seen.capture_s,
        lateness_s=timing.lateness_s,
        busy_s=timing.busy_s,
        overruns=timing.overruns,
        now_s=inputs.now_s,
        dt_s=inputs.dt_s,
        sighted_capture_ns=0 if sighting is None else sighting.shape.capture_time_ns,
        sighted_age_s=0.0 if sighting is None else sighting.age_s,
        drive_absence=inputs.absence,
        drive_fault=inputs.absence_fault,
        commanded=commanded,
        progress=state.progress,
        paused=state.paused,
        heartbeat=inputs.heartbeat,
        **state.supervision.told,
    )
