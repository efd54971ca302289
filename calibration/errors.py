"""Errors of calibration.

NodalError
|-- BoardError     the settings describe no board that can be printed, or one that cannot be told from itself upside down
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
