"""What the controller asks of a tendon drive, whatever turns the pulleys.

Another actuator family becomes usable by offering `Actuators`. Its own errors derive from those below:

    NodalError
    `-- ActuatorError              every error of a tendon drive; after one, nothing is known until the next read()
        |-- CommandRefusedError    a command that is not finite, has the wrong shape or leaves the travel: nothing moved
        |-- WatchdogExpiredError   the drive stopped by itself because nobody spoke to it in time
        |-- ServoRestartedError    a servo restarted by itself, and its place is not known any more
        `-- ServoAlarmError        a servo reports trouble of its own and takes no torque
"""

import dataclasses
from types import TracebackType
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from messaging.errors import NodalError


class ActuatorError(NodalError):
    """The tendon drive cannot be reached, is not what the settings say, or reports trouble."""


class CommandRefusedError(ActuatorError):
    """A command is not finite, has the wrong shape or leaves the travel; nothing was sent."""


class WatchdogExpiredError(ActuatorError):
    """The drive heard nothing for longer than its watchdog allows and stopped; `disable()` makes it usable again."""


class ServoRestartedError(ActuatorError):
    """A servo restarted by itself: it is relaxed, and its place is not known any more."""


class ServoAlarmError(ActuatorError):
    """A servo reports trouble of its own, such as an overload, and takes no torque until that is dealt with."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class ActuatorState:
    """One reading of the drive. D tendons or pairs; arrays over servos hold them in order, then the stage if there is one.

    Positive displacement pulls the pair's first tendon in; positive insertion moves the robot forward; a positive current
    drives that way. `hardware_error` holds each servo's own error bits, 0 when it is well. What a drive cannot measure of
    currents, temperatures and voltages is 0, and no limit on it is watched.
    """

    displacement_mm: NDArray[np.float64]
    displacement_mm_s: NDArray[np.float64]
    insertion_mm: float
    insertion_mm_s: float
    current_ma: NDArray[np.float64]
    temperature_c: NDArray[np.float64]
    voltage_v: NDArray[np.float64]
    hardware_error: tuple[int, ...]
    torque: bool
    """True when every servo holds its position; False as soon as one does not."""
    alarm: str = ""
    """What `hardware_error` means, in the drive's own words; empty when all is well."""

    @property
    def position_mm(self) -> NDArray[np.float64]:
        """Of every servo: the displacements, and the insertion of a drive that has a stage."""
        return np.append(self.displacement_mm, self.insertion_mm)[: len(self.current_ma)]

    @property
    def velocity_mm_s(self) -> NDArray[np.float64]:
        """Of every servo."""
        return np.append(self.displacement_mm_s, self.insertion_mm_s)[: len(self.current_ma)]


class Actuators(Protocol):
    """A tendon drive. Every method ends within a bounded time and raises ActuatorError when it cannot do its work."""

    def open(self) -> None:
        """Reach every servo, check that it is the one the settings describe, leave it relaxed; zero is where it is."""
        ...

    def close(self) -> None:
        """Relax the servos and let the device go; it is let go even when the servos do not answer."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def read(self) -> ActuatorState:
        """One reading of all servos; raises WatchdogExpiredError when the drive has stopped by itself."""
        ...

    def write(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> None:
        """Send where the tendons or pairs (D,) and the stage should go; raises CommandRefusedError before sending.

        A drive without a stage is always at insertion 0 and refuses any other.
        """
        ...

    def set_zero(self, displacement_mm: NDArray[np.float64], insertion_mm: float) -> None:
        """From now on, the present position is called `displacement_mm` (D,) and `insertion_mm`; nothing moves."""
        ...

    def enable(self) -> None:
        """Hold the present position, and arm the watchdog that stops the drive when commands and readings cease."""
        ...

    def disable(self) -> None:
        """Let go: no servo holds its position any more. Also clears an expired watchdog."""
        ...
