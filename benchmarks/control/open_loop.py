"""A law's file: no feedback at all. The nominal model is solved for the commands of the path, and they are simply sent.

The yardstick beside every law: it homes with the cameras like the others, and never looks again.
"""

import dataclasses

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.kinematics import Kinematics
from controller.law import Beginning, LawInputs, Points
from controller.plant import Plant
from nodal.report.open_loop import solved

Array = NDArray[np.float64]


class Tuning(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Nothing to set."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class OpenLoopState:
    """Which points, and the last solution."""

    points: Points
    command_mm: Array


class OpenLoop:
    """The inverse of the constant-curvature model."""

    lead_s = 0.0

    def __init__(self, kinematics: Kinematics) -> None:
        """Of this model."""
        self._kinematics = kinematics

    def start(self, beginning: Beginning) -> OpenLoopState:
        """From wherever the actuators are."""
        return OpenLoopState(points=beginning.points, command_mm=beginning.command_mm)

    def step(self, state: OpenLoopState, inputs: LawInputs) -> tuple[OpenLoopState, Array]:
        """What the model asks for, at once."""
        driven = state.points.weights > 0
        command = solved(
            self._kinematics, state.points.arc_mm[driven], inputs.desired.node_mm[driven], state.command_mm
        )
        return dataclasses.replace(state, command_mm=command), command


def make(tuning: Tuning, plant: Plant) -> OpenLoop:
    """The law for this plant."""
    del tuning
    return OpenLoop(plant.kinematics)
