"""Errors of the simulated robot.

NodalError
`-- SimulatedRobotError        every error of this package
    |-- RobotBuildError        settings that describe no robot that could be built
    |-- RobotInputError        a displacement, tension, insertion or time step that is not usable
    `-- NoEquilibriumError     a static shape that the solver could not reach
"""

from messaging.errors import NodalError


class SimulatedRobotError(NodalError):
    """The simulated robot cannot do what was asked."""


class RobotBuildError(SimulatedRobotError):
    """The settings describe no robot that could be built."""


class RobotInputError(SimulatedRobotError):
    """A displacement, tension, insertion or time step has the wrong shape, is not finite, or is out of range."""


class NoEquilibriumError(SimulatedRobotError):
    """The solver did not settle on a static shape."""
