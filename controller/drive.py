"""The edge to the tendon drive: errors become words for the loop, and a lost drive is sought again every second."""

import logging

from controller import faults
from controller.cycle import Outputs
from controller.errors import FaultError
from drivers import actuators as drivers
from drivers.actuators import ActuatorError, Actuators, ActuatorState

logger = logging.getLogger(__name__)

_RETRY_S = 1.0


class Drive:
    """Actuators that may come and go. After any error they are closed, which relaxes them; opening leaves them relaxed."""

    def __init__(self, actuators: Actuators) -> None:
        """Nothing is opened yet."""
        self._actuators = actuators
        self._open = False
        self._retry_at_s = 0.0
        self.absence = "the tendon drive was not opened yet"
        """Why there is no reading; empty when there is one."""
        self.absence_fault = faults.DriveLostError.code
        """Code of the fault that this is while torque should be on."""

    def read(self, now_s: float) -> ActuatorState | None:
        """The drive's state, or None and `absence` says why."""
        try:
            if not self._open:
                if now_s < self._retry_at_s:
                    return None
                self._retry_at_s = now_s + _RETRY_S
                self._actuators.open()
                self._open = True
                logger.info("tendon drive found")
            state = self._actuators.read()
        except ActuatorError as error:
            self._lose(error, now_s)
            return None
        self.absence = self.absence_fault = ""
        return state

    def act(self, outputs: Outputs, now_s: float) -> bool:
        """Do what the loop decided; True when a command was written."""
        if not self._open:
            return False
        try:
            if outputs.release:
                self._actuators.disable()
            if outputs.engage:
                self._actuators.enable()
            if outputs.zero_mm is not None:
                self._actuators.set_zero(*outputs.split(outputs.zero_mm))
            if outputs.command_mm is None:
                return False
            self._actuators.write(*outputs.split(outputs.command_mm))
        except ActuatorError as error:
            self._lose(error, now_s)
            return False
        return True

    def close(self) -> None:
        """Let the tendons and the device go."""
        self._open = False
        try:
            self._actuators.close()
        except ActuatorError as error:
            logger.warning("tendon drive did not confirm that it let go: %s", error)

    def _lose(self, error: ActuatorError, now_s: float) -> None:
        if str(error) != self.absence:
            logger.warning("tendon drive lost: %s", error)
        self.absence = str(error)
        self.absence_fault = _fault_of(error).code
        self._retry_at_s = now_s + _RETRY_S
        if self._open:
            self.close()


def _fault_of(error: ActuatorError) -> type[FaultError]:
    return next((fault for kind, fault in _FAULTS.items() if isinstance(error, kind)), faults.DriveLostError)


_FAULTS: dict[type[ActuatorError], type[FaultError]] = {
    drivers.WatchdogExpiredError: faults.WatchdogExpiredError,
    drivers.ServoRestartedError: faults.ServoRestartedError,
    drivers.ServoAlarmError: faults.ServoAlarmError,
}
