"""Tendon pairs and the stage on one servo bus, in mm: what `drivers.actuators.Actuators` asks for."""

import math
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivers.actuators import ActuatorError, ActuatorState, CommandRefusedError, WatchdogExpiredError
from drivers.dynamixel import control_table as table
from drivers.dynamixel import feedback
from drivers.dynamixel.axis import Axis
from drivers.dynamixel.bus import DynamixelBus
from drivers.dynamixel.commissioning import check_setup, configure, identify
from drivers.dynamixel.control_table import VOLTS_PER_COUNT, Register
from drivers.dynamixel.errors import (
    NoAnswerError,
    PortLostError,
    RestartedError,
    UnconfirmedError,
    hardware_words,
)
from drivers.dynamixel.feedback import Feedback
from drivers.dynamixel.port import Line, SerialPort
from drivers.dynamixel.settings import ServoSettings
from drivers.dynamixel.whereabouts import Whereabouts


class TendonActuators:
    """Dynamixel X servos in current-based position mode: each pulls to its goal with no more than its current limit.

    mm count from where the servos stood at `open`, until `set_zero` says otherwise.
    """

    def __init__(self, settings: ServoSettings, line: Line | None = None) -> None:
        """Remember the settings; `open` reaches for the bus, over the settings' serial port unless a `line` is given."""
        self._settings = settings
        self._ids = [axis.id for axis in settings.axes]
        self._bus = DynamixelBus(
            line or SerialPort(settings.port, settings.baud_rate),
            answer_timeout_s=settings.answer_timeout_ms / 1e3,
            retries=settings.retries,
        )
        self._axes: list[Axis] = []
        self._whereabouts = Whereabouts()

    def open(self) -> None:
        """Reach and check every servo, relax it, set what its RAM needs; its position, or its `zero_ticks`, becomes 0 mm.

        Raises PortError, NoAnswerError, WrongModelError, WrongSetupError, StatusError, and RestartedError when servos that
        were open before have restarted since, unless that was said already; the port is then closed again.
        """
        self._bus.open()
        try:
            self._relax_unheard()
            models = identify(self._bus, self._settings.axes)
            self.disable()
            if self._axes:
                self._check_memory(models[0].indirect_data_1)
            axes = [Axis(axis, model, 0.0) for axis, model in zip(self._settings.axes, models, strict=True)]
            for axis in axes:
                check_setup(self._bus, axis.settings, axis.model)
                configure(self._bus, axis, self._settings)
            self._axes = axes
            self._axes = [
                self._whereabouts.found(axis, block.position)
                for axis, block in zip(axes, self._feedback(), strict=True)
            ]
        except BaseException:
            self._bus.close()
            raise

    def close(self) -> None:
        """Relax the servos and let the port go, which happens even when `disable` raises."""
        try:
            if self._bus.is_open:
                self.disable()
        finally:
            self._bus.close()

    def __enter__(self) -> Self:
        """Open."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close; trouble on the way out does not hide the error that led there."""
        if error is None:
            self.close()
        else:
            _note_trouble(self.close, error)

    def read(self) -> ActuatorState:
        """One reading of all servos, in one exchange; raises WatchdogExpiredError, NoAnswerError, StatusError."""
        blocks = self._feedback()
        self._whereabouts.saw({servo: b.position for servo, b in zip(self._ids, blocks, strict=True)})
        expired = [
            a.settings.name
            for a, b in zip(self._axes, blocks, strict=True)
            if b.watchdog == table.WATCHDOG_EXPIRED
        ]
        if expired:
            raise WatchdogExpiredError(
                f"{self._bus.port}: axis {', '.join(expired)} heard nothing for more than {self._settings.watchdog_ms} ms "
                f"and stopped{self._hardware_words(blocks)}"
            )
        return self._state(blocks)

    def write(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> None:
        """Send the goals of all servos in one packet; raises CommandRefusedError, and then nothing was sent."""
        axes = self._opened()
        goals_mm = self._positions_mm(displacement_mm, insertion_mm)
        for axis, goal_mm in zip(axes, goals_mm, strict=True):
            low_mm, high_mm = axis.settings.min_mm, axis.settings.max_mm
            if not low_mm <= goal_mm <= high_mm:
                raise CommandRefusedError(
                    f"axis {axis.settings.name}: goal {goal_mm} mm must be a number from {low_mm} to {high_mm}"
                )
        goals = {a.settings.id: a.goal_ticks(mm) for a, mm in zip(axes, goals_mm, strict=True)}
        self._bus.sync_write(table.GOAL_POSITION, goals)

    def set_zero(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> None:
        """Call the present position `displacement_mm` (D,) and `insertion_mm`; raises CommandRefusedError."""
        positions_mm = self._positions_mm(displacement_mm, insertion_mm)
        for axis, position_mm in zip(self._opened(), positions_mm, strict=True):
            if not math.isfinite(position_mm):
                raise CommandRefusedError(f"axis {axis.settings.name}: {position_mm} mm is no position")
        self._axes = [
            axis.zeroed(block.position, position_mm)
            for axis, block, position_mm in zip(self._axes, self._feedback(), positions_mm, strict=True)
        ]

    def enable(self) -> None:
        """Hold the present position and arm the bus watchdog; torque comes on only once goal = present is confirmed.

        Raises HardwareError, UnconfirmedError, StatusError, NoAnswerError; torque is then off.
        """
        self._bus.check_hardware(self._ids)
        present = [block.position for block in self._feedback()]
        try:
            self._set(table.BUS_WATCHDOG, 0)
            self._set(table.GOAL_POSITION, *present)
            self._set(table.TORQUE_ENABLE, 1)
            self._set(table.BUS_WATCHDOG, math.ceil(self._settings.watchdog_ms / table.WATCHDOG_UNIT_MS))
        except BaseException as error:
            _note_trouble(self.disable, error)
            raise

    def disable(self) -> None:
        """Torque and watchdog off, and confirmed; raises NoAnswerError naming the servos that did not confirm."""
        self._set(table.TORQUE_ENABLE, 0)
        self._set(table.BUS_WATCHDOG, 0)

    def _set(self, register: Register, *values: int) -> None:
        """Write a register of all servos (one value for all, or one each) and see that it arrived.

        A sync write is not acknowledged, so what did not arrive is written again in a way that is; a silent servo keeps no
        other from that, and raises NoAnswerError in the end.
        """
        wanted = dict(zip(self._ids, values if len(values) > 1 else values * len(self._ids), strict=True))
        self._bus.sync_write(register, wanted)
        silence: NoAnswerError | None = None
        try:
            found = self._bus.sync_read(self._ids, register)
        except NoAnswerError as error:
            silence = error
            found = {servo: register.from_bytes(a.parameters) for servo, a in error.answers.items()}
            self._bus.sync_write(register, {servo: wanted[servo] for servo in error.silent})
        for servo, value in found.items():
            if value != wanted[servo]:
                self._bus.write(servo, register, wanted[servo])
                again = self._bus.read(servo, register)
                if again != wanted[servo]:
                    raise UnconfirmedError(
                        f"{self._bus.port}: servo {servo}: {register.name} reads {again} after {wanted[servo]} was written"
                    )
        if silence is not None:
            raise silence

    def _relax_unheard(self) -> None:
        """Torque off before anything is asked, so that one missing servo does not leave the others pulling."""
        self._bus.sync_write(table.TORQUE_ENABLE, dict.fromkeys(self._ids, 0))

    def _check_memory(self, indirect_data_1: int) -> None:
        """Whether servos that were set up before remember it."""
        answers = self._bus.sync_read_bytes(self._ids, indirect_data_1, feedback.SIZE)
        blocks = {servo: feedback.decode(block) for servo, block in answers.items()}
        restarted = self._restarted(blocks)
        if self._whereabouts.restarted(restarted):
            raise self._restart(restarted, blocks)

    def _feedback(self) -> list[Feedback]:
        address = self._opened()[0].model.indirect_data_1
        try:
            answers = self._bus.sync_read_bytes(self._ids, address, feedback.SIZE)
        except NoAnswerError as error:
            heard = {s: feedback.decode(a.parameters) for s, a in error.answers.items() if not a.error}
            error.add(hardware_words({servo: block.hardware_error for servo, block in heard.items()}))
            raise
        blocks = {servo: feedback.decode(block) for servo, block in answers.items()}
        if restarted := self._restarted(blocks):
            self._whereabouts.restarted(restarted)
            raise self._restart(restarted, blocks)
        return list(blocks.values())

    def _restarted(self, blocks: Mapping[int, Feedback]) -> list[int]:
        return [servo for servo, block in blocks.items() if not block.is_genuine]

    def _restart(self, restarted: Sequence[int], blocks: Mapping[int, Feedback]) -> RestartedError:
        return RestartedError(
            f"{self._bus.port}: servo {list(restarted)} restarted by itself (a dip of its supply?) and forgot its turns; "
            f"open the servos and home again{self._hardware_words(list(blocks.values()))}"
        )

    def _hardware_words(self, blocks: Sequence[Feedback]) -> str:
        bits = {servo: block.hardware_error for servo, block in zip(self._ids, blocks, strict=True)}
        return hardware_words(bits)

    def _opened(self) -> list[Axis]:
        if not self._axes:
            raise PortLostError(f"{self._bus.port}: the servos have not been opened")
        return self._axes

    def _state(self, blocks: Sequence[Feedback]) -> ActuatorState:
        pairs, tendons = list(zip(self._axes, blocks, strict=True)), len(self._settings.tendons)
        position_mm = [axis.position_mm(block.position) for axis, block in pairs]
        velocity_mm_s = [axis.velocity_mm_s(block.velocity) for axis, block in pairs]
        return ActuatorState(
            displacement_mm=np.array(position_mm[:tendons]),
            displacement_mm_s=np.array(velocity_mm_s[:tendons]),
            insertion_mm=sum(position_mm[tendons:]),
            insertion_mm_s=sum(velocity_mm_s[tendons:]),
            current_ma=np.array([axis.current_ma(block.current) for axis, block in pairs]),
            temperature_c=np.array([float(block.temperature) for block in blocks]),
            voltage_v=np.array([block.voltage * VOLTS_PER_COUNT for block in blocks]),
            hardware_error=tuple(block.hardware_error for block in blocks),
            torque=all(block.torque for block in blocks),
            alarm="; ".join(
                f"{axis.settings.name}: {table.hardware_error_names(block.hardware_error)}"
                for axis, block in pairs
                if block.hardware_error
            ),
        )

    def _positions_mm(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> list[float]:
        """What is asked of each axis, checked to be one number each."""
        tendons, stage = len(self._settings.tendons), self._settings.stage
        if np.shape(displacement_mm) != (tendons,):
            raise CommandRefusedError(
                f"displacements have shape {np.shape(displacement_mm)}; there are {tendons} tendon pairs"
            )
        if stage is None and insertion_mm != 0:
            raise CommandRefusedError(f"insertion {insertion_mm} mm must be 0: there is no stage")
        positions_mm: list[float] = np.asarray(displacement_mm, float).tolist()
        return positions_mm if stage is None else [*positions_mm, float(insertion_mm)]


def _note_trouble(action: Callable[[], None], error: BaseException) -> None:
    """Do what must be tried on the way out; its own trouble is added to `error` instead of hiding it."""
    try:
        action()
    except ActuatorError as trouble:
        error.add_note(f"while letting the servos go: {trouble}")
