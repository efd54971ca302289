"""Errors of the virtual bench.

NodalError
`-- VirtualBenchError      settings that describe no bench, or a bench that is not where a run can begin
"""

from messaging.errors import NodalError


class VirtualBenchError(NodalError):
    """The virtual bench cannot be built, or is not where it had to be."""
