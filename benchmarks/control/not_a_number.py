"""A law's file: what a broken law looks like from outside. For the table of faults."""

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.law import Beginning, LawInputs
from controller.plant import Plant


class Tuning(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Nothing to set."""


class NotANumber:
    """Answers nan, whatever it is asked."""

    lead_s = 0.0

    def start(self, beginning: Beginning) -> None:
        """Remembers nothing."""

    def step(self, state: Any, inputs: LawInputs) -> tuple[Any, NDArray[np.float64]]:
        """Nothing that could be sent."""
        return state, np.full_like(inputs.command_mm, np.nan)


def make(tuning: Tuning, plant: Plant) -> NotANumber:
    """The law for any plant."""
    del tuning, plant
    return NotANumber()
