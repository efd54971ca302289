"""The laws that `law = "..."` in the bench file may name. A law of your own: write it against `Law`, add its line here."""

from collections.abc import Callable
from typing import Any

from controller.errors import ControllerSetupError
from controller.kinematics import Kinematics
from controller.law import Law
from controller.resolved_rate import ResolvedRate
from controller.settings import ControllerSettings

LAWS: dict[str, Callable[[ControllerSettings, Kinematics], Law[Any]]] = {
    "resolved_rate": lambda settings, kinematics: ResolvedRate(
        settings.resolved_rate, kinematics, settings.maximum_node_speed_mm_s
    ),
}


def make_law(settings: ControllerSettings, kinematics: Kinematics) -> Law[Any]:
    """The law that the settings name; raises ControllerSetupError."""
    try:
        make = LAWS[settings.law]
    except KeyError:
        raise ControllerSetupError(
            f"law {settings.law!r} is not known; known are {', '.join(LAWS)}"
        ) from None
    return make(settings, kinematics)
