"""Recordings: the MCAP writer, the reader, and the process that logs a bench's topics.

from recordings import Log

log = Log("circle.mcap")
tip_mm = log.arrays(topics.SHAPE, "node_mm")["node_mm"][:, -1]
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from recordings.log import Log

__all__ = ["Log"]


def __getattr__(name: str) -> Any:
    # the recorder process shall not wait for what only readers need
    if name != "Log":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from recordings.log import Log  # noqa: PLC0415

    return Log
