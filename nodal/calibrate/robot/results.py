"""What was identified, in the words of axes instead of matrices, and how well the moves are foreseen that nobody fitted."""

import dataclasses
import datetime as dt
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from calibration.robot_identification import Expected, Identification, Identified
from controller.identified import Drawing, IdentifiedSettings
from controller.kinematics import Kinematics
from controller.laws import HOMING
from controller.laws.resolved_rate import Tuning
from controller.settings import ControllerSettings
from messaging.settings import RobotSettings
from nodal.calibrate.robot.experiment import Seen, current_ma
from nodal.calibrate.robot.nominal import NominalModel
from nodal.calibrate.robot.walking import Run

Array = NDArray[np.float64]

_SMALLEST_SIGMA = 1e-4
_BELIEVABLE = 0.9
"""Gains and bends beyond this, either way, are of no robot: a tendon is slack, or the stage stands still."""
_CLEARLY = 0.8
"""Moves must be foreseen so many times as far off as by the drawing, or nearer: else there is nothing to be gained."""


class AxisFound(msgspec.Struct, frozen=True, kw_only=True):
    """One tendon or pair, against the drawing."""

    axis: int
    name: str
    section: int
    """Where it ends, counted from 1 at the base."""
    gain: float
    """Bend of its own section per mm, as a share of the drawing's, in the drawing's direction."""
    gain_sigma: float
    bends_others: tuple[float, ...]
    """For each section, as a share of the bend that the drawing gives the axis' own section, in the same direction."""
    bends_others_drawn: tuple[float, ...]
    lost_motion_mm: float
    lost_motion_sigma_mm: float
    current_at_rest_ma: float | None
    """Near zero."""
    current_between_ways_ma: float | None
    """By how much the current differs between coming to zero from either side; none where it came from one."""


class NodeForeseen(msgspec.Struct, frozen=True, kw_only=True):
    """One nodal point over the moves that are held out, RMS."""

    name: str
    arc_mm: float
    before_mm: float
    after_mm: float


class Foreseen(msgspec.Struct, frozen=True, kw_only=True):
    """The moves that are held out, by the drawing and by what stands in `IdentifiedSettings`: RMS over all nodal points."""

    poses: int
    before_mm: float
    after_mm: float
    nodes: tuple[NodeForeseen, ...]


class RobotFound(msgspec.Struct, frozen=True, kw_only=True):
    """The file robot.json in the folder of the calibration."""

    date: str
    seconds: float
    length_mm: float
    poses: int
    refused: int
    """Poses that the controller refused to go to."""
    refused_because: tuple[str, ...] = ()
    reversed: tuple[str, ...]
    axes: tuple[AxisFound, ...]
    fit_rms_mm: float
    held_out: Foreseen
    identified: IdentifiedSettings
    doubt: str = ""
    """Why the bench file was left as it is; empty when it was not."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What was identified, as the fit gives it and as the bench file takes it."""

    robot: Identified
    settings: IdentifiedSettings
    foreseen: Foreseen

    @property
    def doubt(self) -> str:
        """Why a law must not begin at this; empty when it may."""
        robot, (before_mm, after_mm) = self.robot, (self.foreseen.before_mm, self.foreseen.after_mm)
        beyond = [
            f"{name}{list(place)} is {value:+.2f}"
            for name in ("gain", "bias_rad", "stage_gain")
            for place, value in np.ndenumerate(getattr(robot, name).value)
            if abs(value) > _BELIEVABLE
        ]
        if beyond:
            return f"{', '.join(beyond)}, beyond {_BELIEVABLE:g} either way: is a tendon slack, or does the stage stand still?"
        if after_mm > _CLEARLY * before_mm:
            return (
                f"moves that nothing was fitted to are not foreseen clearly better: {after_mm:.2f} mm RMS as identified, "
                f"{before_mm:.2f} mm as drawn"
            )
        return ""


def identify(
    seen: Seen,
    settings: ControllerSettings,
    names: tuple[str, ...],
    robot: RobotSettings,
    mm_per_rad: tuple[float, ...],
) -> Outcome:
    """`names` of the nodal points; `mm_per_rad` of all servos. Raises RobotPosesError when too little was seen."""
    model = _model(settings, settings.kinematics(robot))
    date = dt.datetime.now().astimezone().isoformat(timespec="minutes")
    identification = Identification(model, Expected(), seen.runs[0].poses.arc_mm)
    found = identification.identified([run.fitted for run in seen.runs])
    return Outcome(
        robot=found,
        settings=_settings(found, date, settings.drawing(robot, mm_per_rad)),
        foreseen=_foreseen(identification, found, seen.runs, names),
    )


def axes_found(
    outcome: Outcome, seen: Seen, kinematics: Kinematics, names: tuple[str, ...]
) -> tuple[AxisFound, ...]:
    """Each axis in its own words."""
    robot, (rest_ma, between_ma) = outcome.robot, current_ma(seen, kinematics)
    found, sections = [], len(kinematics.length_mm)
    own = np.abs(kinematics.command_of_coordinates[: kinematics.tendons, : 2 * sections]).argmax(axis=1) // 2
    for axis, section in enumerate(own.tolist()):
        pulled = kinematics.coordinates_of_command[: 2 * sections, axis]
        drawn = kinematics.bend_of_coordinates @ pulled
        part = slice(2 * section, 2 * section + 2)
        size = float(np.linalg.norm(drawn[part]))
        direction = drawn[part] / size
        true = kinematics.bend_of_coordinates @ (pulled + robot.gain.value @ pulled)
        # how each G that there is adds to the gain of this axis
        towards = direction @ kinematics.bend_of_coordinates[part] / size
        share = np.outer(towards, pulled)
        found.append(
            AxisFound(
                axis=axis + 1,
                name=names[axis],
                section=section + 1,
                gain=float(direction @ true[part] / size),
                gain_sigma=float(np.sqrt((share**2 * robot.gain.sigma**2).sum())),
                bends_others=tuple((true.reshape(sections, 2) @ direction / size).tolist()),
                bends_others_drawn=tuple((drawn.reshape(sections, 2) @ direction / size).tolist()),
                lost_motion_mm=float(robot.lost_motion_mm.value[axis]),
                lost_motion_sigma_mm=float(robot.lost_motion_mm.sigma[axis]),
                current_at_rest_ma=_known(rest_ma[axis]),
                current_between_ways_ma=_known(between_ma[axis]),
            )
        )
    return tuple(found)


def _known(value: np.float64) -> float | None:
    return round(float(value), 1) if np.isfinite(value) else None


def _model(settings: ControllerSettings, kinematics: Kinematics) -> NominalModel:
    """With the friction of the law that will use what is identified."""
    own = settings.law == HOMING and not settings.law_file
    tuning = msgspec.convert(settings.tuning if own else {}, Tuning)
    return NominalModel(kinematics, tuning.engaging_mm)


def _settings(robot: Identified, date: str, drawing: Drawing) -> IdentifiedSettings:
    def rows(values: Array) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(row) for row in np.clip(values, -1, 1).round(4).tolist())

    def row(values: Array) -> tuple[float, ...]:
        return tuple(values.round(4).tolist())

    def sigma(values: Array) -> Array:
        return np.maximum(values, _SMALLEST_SIGMA)

    return IdentifiedSettings(
        date=date,
        drawing=drawing,
        gain=rows(robot.gain.value),
        gain_sigma=rows(sigma(robot.gain.sigma)),
        bias_rad=row(np.clip(robot.bias_rad.value, -1, 1)),
        bias_sigma_rad=row(sigma(robot.bias_rad.sigma)),
        lost_motion_mm=row(robot.lost_motion_mm.value),
        lost_motion_sigma_mm=row(sigma(robot.lost_motion_mm.sigma)),
        stage_gain=row(np.clip(robot.stage_gain.value, -1, 1)),
        stage_gain_sigma=row(sigma(robot.stage_gain.sigma)),
    )


def _foreseen(
    identification: Identification, robot: Identified, runs: Sequence[Run], names: tuple[str, ...]
) -> Foreseen:
    """Open loop: from the servos' positions alone, along all of the way since homing."""
    held_out = sum(run.held_out for run in runs)

    def missed_mm(foreseen: Callable[[Array], Array]) -> Array:
        missed = [np.linalg.norm(foreseen(run.poses.position_mm) - run.poses.node_mm, axis=2) for run in runs]
        return np.concatenate([one[len(one) - run.held_out :] for one, run in zip(missed, runs, strict=True)])

    before_mm = missed_mm(identification.drawn_mm)
    after_mm = missed_mm(lambda position_mm: identification.foreseen_mm(robot, position_mm))
    of_nodes = (np.sqrt((missed**2).mean(axis=0)).tolist() for missed in (before_mm, after_mm))
    arc_mm = runs[0].poses.arc_mm.tolist()
    return Foreseen(
        poses=held_out,
        before_mm=float(np.sqrt((before_mm**2).mean())),
        after_mm=float(np.sqrt((after_mm**2).mean())),
        nodes=tuple(
            NodeForeseen(name=name, arc_mm=at_mm, before_mm=before, after_mm=after)
            for name, at_mm, before, after in zip(names, arc_mm, *of_nodes, strict=True)
        ),
    )
