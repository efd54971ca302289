"""Errors of the simulated cameras.

NodalError
|-- SimulatedCameraError      a simulated camera's process ended or did not begin
`-- SimulatedBoardError       a board that cannot be drawn
"""

from messaging.errors import NodalError


class SimulatedCameraError(NodalError):
    """The process that renders a simulated camera's pictures ended, or did not begin in time."""


class SimulatedBoardError(NodalError):
    """The bench file's board cannot be drawn, so no camera can be shown it."""
