"""Shape estimates and a target in, tendon commands out: pure decisions, and the process that runs them 200 times a second.

What stands here is all that another program needs to run a controller by itself (docs/embedding.md): `Loop.step` decides,
and the program brings its own clock, measurements and motors. None of it touches a device, a clock or a network.
"""

from controller.cycle import Inputs, LoopState, Outputs, Request, Sighting
from controller.errors import ControllerError, ControllerSetupError
from controller.loop import Loop
from controller.settings import ControllerSettings
from controller.sightings import sighting_of
from drivers.actuators import Actuators, ActuatorState
from messaging.control import Action, ActionRequest, Reply, State, Target
from messaging.settings import RobotSettings
from messaging.shape import ShapeEstimate

__all__ = [
    "Action",
    "ActionRequest",
    "ActuatorState",
    "Actuators",
    "ControllerError",
    "ControllerSettings",
    "ControllerSetupError",
    "Inputs",
    "Loop",
    "LoopState",
    "Outputs",
    "Reply",
    "Request",
    "RobotSettings",
    "ShapeEstimate",
    "Sighting",
    "State",
    "Target",
    "sighting_of",
]
