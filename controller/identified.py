"""What was identified of a robot, as it stands in the bench file: where belief begins, instead of at the nominal model."""

from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from controller.errors import ControllerSetupError
from controller.kinematics import Kinematics

Array = NDArray[np.float64]
Share = Annotated[float, msgspec.Meta(ge=-1, le=1)]
ShareSigma = Annotated[float, msgspec.Meta(gt=0, le=1)]
Bend = Annotated[float, msgspec.Meta(ge=-1, le=1)]
BendSigma = Annotated[float, msgspec.Meta(gt=0, le=1)]
Length = Annotated[float, msgspec.Meta(ge=0, le=20)]
LengthSigma = Annotated[float, msgspec.Meta(gt=0, le=20)]


class Drawing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What of a bench file an identification is a correction of: beside another drawing its numbers mean nothing."""

    section_length_mm: tuple[float, ...]
    angle_deg: tuple[tuple[float, ...], ...]
    """Of each section's pairs or single tendons."""
    pitch_radius_mm: tuple[float, ...]
    coupling: float
    mm_per_rad: tuple[float, ...]
    """Of every servo, the stage's last."""

    def differences(self, now: "Drawing") -> tuple[str, ...]:
        """In words, what is otherwise now."""
        return tuple(
            f"{name} was {_told(was)} and is {_told(getattr(now, name))}"
            for name, was in msgspec.structs.asdict(self).items()
            if was != getattr(now, name)
        )


class IdentifiedSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What `nodal calibrate robot` found, each value with its standard deviation: how well the mean over all places is known.
    Two bends a section, towards +X and +Y, in the order of the sections; tendons or pairs in the order of the servos.
    """

    date: str
    """When, for people."""
    drawing: Drawing
    gain: tuple[tuple[Share, ...], ...]
    """For each bend a row: its share of each bend that the drawing foresees, beyond 1 for itself and 0 for the others."""
    gain_sigma: tuple[tuple[ShareSigma, ...], ...]
    bias_rad: tuple[Bend, ...]
    """Bends at the homed zero."""
    bias_sigma_rad: tuple[BendSigma, ...]
    lost_motion_mm: tuple[Length, ...]
    """Of each tendon or pair, where homing does not look for it."""
    lost_motion_sigma_mm: tuple[LengthSigma, ...]
    stage_gain: tuple[Share, ...] = ()
    """How much further than it is told the stage moves, as a share; empty without a stage."""
    stage_gain_sigma: tuple[ShareSigma, ...] = ()

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        bends = len(self.bias_rad)
        for what, rows in (("gain", self.gain), ("gain_sigma", self.gain_sigma)):
            if [len(row) for row in rows] != [bends] * bends:
                raise ValueError(f"{what} must have {bends} rows of {bends} numbers, as bias_rad has {bends}")

    def stacked(self, kinematics: Kinematics) -> tuple[Array, Array]:
        """Values (n,) and their standard deviations (n,), in the order of controller/belief.py; raises ControllerSetupError
        when they are another robot's.
        """
        bends, stage = 2 * len(kinematics.length_mm), int(kinematics.stage)
        counts = (bends, bends, stage, kinematics.tendons)
        values = (self.gain, self.bias_rad, self.stage_gain, self.lost_motion_mm)
        sigmas = (self.gain_sigma, self.bias_sigma_rad, self.stage_gain_sigma, self.lost_motion_sigma_mm)
        if not counts == tuple(map(len, values)) == tuple(map(len, sigmas)):
            raise ControllerSetupError(
                f"controller.identified is of another robot: this one has {bends} bends, {kinematics.tendons} tendons or pairs "
                f"and {'a' if stage else 'no'} stage; take the table out, then run `nodal calibrate robot`"
            )
        return _joined(values), _joined(sigmas)


def _told(value: object) -> str:
    return msgspec.json.encode(value).decode()


def _joined(numbers: tuple[tuple[object, ...], ...]) -> Array:
    return np.concatenate([np.ravel(np.asarray(part, dtype=np.float64)) for part in numbers])
