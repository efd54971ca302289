"""Errors of the simulated cameras.

NodalError
`-- SimulatedCameraError      a simulated camera's process ended or did not begin
"""

from messaging.errors import NodalError


class SimulatedCameraError(NodalError):
    """The process that renders a simulated camera's pictures ended, or did not begin in time."""
