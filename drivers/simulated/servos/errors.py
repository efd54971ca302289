"""Errors of the emulated servos.

NodalError
`-- EmulatedServosError       every error of this package
    |-- LinkError             the path that should lead to the serial device is taken or cannot be made
    |-- NoSuchServoError      no servo has this id
    `-- ServoStepError        loads or a time step that no servo can be stepped with
"""

from messaging.errors import NodalError


class EmulatedServosError(NodalError):
    """The emulated servos cannot do what was asked."""


class LinkError(EmulatedServosError):
    """The link to the serial device cannot be placed where the settings say."""


class NoSuchServoError(EmulatedServosError):
    """No servo of the emulated bus has the id that was named."""


class ServoStepError(EmulatedServosError):
    """Loads of the wrong number or not finite, or a time step that is not positive."""
