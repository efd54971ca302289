"""Errors of recordings.

NodalError
`-- RecordingError                 every error below; all name the file
    |-- RecordingInUseError        another recorder is writing this file
    |-- RecordingExistsError       a finished recording stands there already; recordings are never overwritten
    |-- UnwritableError            the folder is missing or read-only, or the device fails
    |   |-- DiskFullError          no room is left, or less than is to be left; what was written stays readable
    |   `-- DeletedError           the file was deleted while it was being written
    |-- UnreadableError            there is no such file, or it may not be read
    |-- DamagedRecordingError      bytes that are not what an MCAP file holds at that place
    |-- UnknownTopicError          a recorded topic that this version has no message type for
    `-- FieldError                 a field that messages do not have, or not in one shape
"""

from pathlib import Path

from messaging.errors import NodalError


class RecordingError(NodalError):
    """Something is wrong with a recording; `path` is the file."""

    def __init__(self, path: Path, problem: str) -> None:
        """Name the file first."""
        super().__init__(f"recording {path}: {problem}")
        self.path = path


class RecordingInUseError(RecordingError):
    """Another recorder is writing this file."""


class RecordingExistsError(RecordingError):
    """The file exists and is finished."""


class UnwritableError(RecordingError):
    """The file cannot be created or written."""


class DiskFullError(UnwritableError):
    """No room is left on the disk, or less than is to be left, or the user's quota or file size limit is reached."""


class DeletedError(UnwritableError):
    """Somebody deleted the file, or its folder, while it was being written."""


class UnreadableError(RecordingError):
    """There is no such file, or it may not be read."""


class DamagedRecordingError(RecordingError):
    """The file is damaged `offset` bytes from its beginning, and `problem` says how."""

    def __init__(self, path: Path, offset: int, problem: str) -> None:
        """Name the place too."""
        super().__init__(path, f"damaged at byte {offset}: {problem}")
        self.offset = offset
        self.problem = problem


class UnknownTopicError(RecordingError):
    """The table of topics has no such topic, or the file holds another type of message under its name."""


class FieldError(RecordingError):
    """The topic's messages have no such field, or it has not the same shape in all of them."""
