"""Another family of actuators: steppers behind a motion controller that takes a line of text and answers with one.

A whole drive for `drivers.actuators.Actuators`, for tendons without a stage. The motion controller is made up, its lines are:
`position` answers four numbers in mm, `go A B C D` moves, `hold WATCHDOG_MS` powers the motors and stops them when no line
comes for so long, `free` lets them go, `motors` answers 0 when they are free, 1 when they hold and 2 when they were stopped,
`alarms` a number of bits for each motor. Every answer begins with `ok`.
"""

from collections.abc import Callable
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drivers.actuators import ActuatorError, ActuatorState, CommandRefusedError, WatchdogExpiredError

Ask = Callable[[str], str]
"""Sends a line and returns the answer; raises OSError, and so TimeoutError, within a bounded time. The edge to the device."""
_HOLDING, _STOPPED = 1, 2


class StepperActuators:
    """Four tendon pairs, each on a stepper; 0 mm is where they stand when opened, until `set_zero` says otherwise."""

    pairs, travel_mm, watchdog_ms, attempts = 4, 6.0, 200, 2

    def __init__(self, connect: Callable[[], tuple[Ask, Callable[[], None]]]) -> None:
        """`connect` reaches for the device: a function to ask it, and one to let it go."""
        self._connect = connect
        self._device: tuple[Ask, Callable[[], None]] | None = None
        self._zero_mm = np.zeros(self.pairs)
        self._before_mm = np.zeros(self.pairs)

    def open(self) -> None:
        """Reach the device and relax it: nothing is ever found pulling."""
        try:
            self._device = self._connect()
        except OSError as error:
            raise ActuatorError(f"the motion controller cannot be reached: {error}") from error
        try:
            self.disable()
            self.set_zero(np.zeros(self.pairs), 0.0)
        except BaseException:
            self._let_go()
            raise

    def close(self) -> None:
        """Relax, and let the device go even when it does not answer."""
        try:
            if self._device is not None:
                self.disable()
        finally:
            self._let_go()

    def __enter__(self) -> Self:
        """Open."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def read(self) -> ActuatorState:
        """Where the motors are. What a device does not measure is 0, and no limit on it is watched then."""
        (motors,) = self._ask("motors", 1)
        if motors == _STOPPED:
            raise WatchdogExpiredError(f"the motors heard nothing for {self.watchdog_ms} ms and were stopped")
        position_mm = self._position_mm() - self._zero_mm
        moved_mm, self._before_mm = position_mm - self._before_mm, position_mm
        return ActuatorState(
            displacement_mm=position_mm,
            displacement_mm_s=moved_mm * 200.0,  # read 200 times a second
            insertion_mm=0.0,
            insertion_mm_s=0.0,
            current_ma=np.zeros(self.pairs),
            temperature_c=np.zeros(self.pairs),
            voltage_v=np.zeros(self.pairs),
            hardware_error=tuple(int(bits) for bits in self._ask("alarms", self.pairs)),
            torque=motors == _HOLDING,
        )

    def write(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> None:
        """Refuse what must not be before anything is sent."""
        goals_mm = self._checked(displacement_mm, insertion_mm)
        if (np.abs(goals_mm) > self.travel_mm).any():
            raise CommandRefusedError(
                f"goals {goals_mm.tolist()} mm reach beyond {-self.travel_mm} to {self.travel_mm} mm"
            )
        self._ask("go " + " ".join(f"{goal:.4f}" for goal in goals_mm + self._zero_mm))

    def set_zero(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> None:
        """Only names change; nothing moves."""
        self._before_mm = self._checked(displacement_mm, insertion_mm)
        self._zero_mm = self._position_mm() - self._before_mm

    def enable(self) -> None:
        """Go to where it is already, then power: enabling never moves anything."""
        self._ask("go " + " ".join(f"{place:.4f}" for place in self._position_mm()))
        self._ask(f"hold {self.watchdog_ms}")

    def disable(self) -> None:
        """Let go, also of motors that were stopped."""
        self._ask("free")

    def _position_mm(self) -> NDArray[np.float64]:
        return np.array(self._ask("position", self.pairs))

    def _checked(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> NDArray[np.float64]:
        goals_mm = np.asarray(displacement_mm, float)
        if goals_mm.shape != (self.pairs,) or not np.isfinite(goals_mm).all() or insertion_mm != 0:
            raise CommandRefusedError(
                f"displacement {goals_mm.tolist()} mm, insertion {insertion_mm} mm: needed are {self.pairs} finite "
                "numbers and 0, for there is no stage"
            )
        return goals_mm

    def _ask(self, line: str, count: int = 0) -> list[float]:
        """The numbers of the answer, so many; asks again a bounded number of times, and never takes rubbish for an answer."""
        if self._device is None:
            raise ActuatorError("the motion controller has not been opened")
        ask, trouble = self._device[0], "nothing was asked"
        for _ in range(self.attempts):
            try:
                ok, *words = ask(line).split() or [""]
                numbers = [float(word) for word in words]
                if ok == "ok" and len(numbers) == count and np.isfinite(numbers).all():
                    return numbers
                trouble = f"it answered {ok!r} {' '.join(words)}"
            except (OSError, ValueError) as error:
                trouble = str(error)
        raise ActuatorError(f"no answer to {line!r} after {self.attempts} attempts: {trouble}")

    def _let_go(self) -> None:
        device, self._device = self._device, None
        if device is not None:
            device[1]()
