"""Errors of the virtual bench.

NodalError
`-- VirtualBenchError      the bench did not get where it had to be before a run can begin
"""

from messaging.errors import NodalError


class VirtualBenchError(NodalError):
    """The virtual bench is not where it had to be."""
