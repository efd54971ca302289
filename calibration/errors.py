"""Errors of calibration.

NodalError
|-- BoardError     the settings describe no board that can be printed, or one that cannot be told from itself upside down
|-- BasePosesError   the robot's poses do not determine where it stands, or contradict what is known of it
|-- ViewsError     the views of the board do not determine the cameras; the reason says which views to add
`-- RobotPosesError  the robot was not seen in enough poses to be identified
"""

from messaging.errors import NodalError


class BoardError(NodalError):
    """The settings describe a board that does not exist, or that no camera can tell the right way up."""


class ViewsError(NodalError):
    """The views of the board do not determine the cameras; the reason says what to do about it."""


class RobotPosesError(NodalError):
    """The robot was not seen in enough poses to be identified, or they show another robot than the model's."""


class BasePosesError(NodalError):
    """The robot's poses do not determine where it stands, or contradict its bench file; the reason says what to do about it."""
