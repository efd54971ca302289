"""What a cycle tells the bench about itself. Pure."""

import numpy as np

from controller.cycle import LoopState, Outputs
from drivers.actuators import ActuatorState
from messaging.control import ControllerState, TendonCommand, TendonState

NO_SHAPE_YET = 0
"""As `shape_sequence`."""
REPEATED = -1
"""As `capture_to_command_ns` of commands that no new shape led to."""
_NO_NODES = np.zeros((0, 3))
_NEVER_S = 1e9
"""As `shape_age_s` before the first shape: messages carry finite numbers only."""


def tendon_command(
    state: LoopState, outputs: Outputs, *, time_ns: int, first_for_shape: bool, written_s: float
) -> TendonCommand | None:
    """The command that was written at `written_s`. Only the first one after a shape arrived tells how old its frames were."""
    if outputs.command_mm is None:
        return None
    age_ns = REPEATED
    if first_for_shape and state.seen is not None:
        age_ns = round((written_s - state.seen.capture_s) * 1e9)
    return TendonCommand(
        time_ns=time_ns,
        displacement_mm=outputs.command_mm[:-1],
        insertion_mm=float(outputs.command_mm[-1]),
        shape_sequence=NO_SHAPE_YET if state.seen is None else state.seen.shape.sequence,
        capture_to_command_ns=age_ns,
    )


def tendon_state(drive: ActuatorState | None, *, time_ns: int) -> TendonState | None:
    """What the servos reported in this cycle."""
    if drive is None:
        return None
    return TendonState(
        time_ns=time_ns,
        displacement_mm=drive.displacement_mm,
        insertion_mm=drive.insertion_mm,
        current_ma=drive.current_ma,
        temperature_c=drive.temperature_c,
        voltage_v=drive.voltage_v,
        hardware_error=np.array(drive.hardware_error, dtype=np.float64),
        torque=drive.torque,
    )


def controller_state(
    state: LoopState,
    outputs: Outputs,
    *,
    time_ns: int,
    now_s: float,
    lateness_s: float,
    busy_s: float,
    overruns: int,
) -> ControllerState:
    """The cycle. Desired and measured nodal points both belong to the capture of the shape that the cycle worked with."""
    task, seen = state.task, state.seen
    return ControllerState(
        time_ns=time_ns,
        state=state.mode.state,
        reason=outputs.reason,
        target_name="" if task is None else task.reference.target.name,
        node_names=() if task is None else task.reference.target.node_names,
        desired_mm=_NO_NODES if task is None else task.desired_mm,
        measured_mm=_NO_NODES if task is None else task.measured_mm,
        tracking_error_mm=0.0 if task is None else task.error_mm,
        shape_sequence=NO_SHAPE_YET if seen is None else seen.shape.sequence,
        shape_age_s=_NEVER_S if seen is None else now_s - seen.capture_s,
        lateness_s=lateness_s,
        busy_s=busy_s,
        overruns=overruns,
    )
