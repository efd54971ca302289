"""The robot led through many poses: where it stood in each, and what was refused."""

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from calibration.robot_model import Poses
from nodal.calibrate.robot.leading import THERE_MM, Leader
from nodal.calibrate.robot.standing import Stand
from nodal.errors import JogRefusedError, RobotStoppedError

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Where the robot stood since one homing; the last `held_out` poses are not to be fitted."""

    poses: Poses
    held_out: int

    @property
    def fitted(self) -> Poses:
        """The poses without those."""
        return self.poses.first(len(self.poses) - self.held_out)


class Walk:
    """Leads a robot, and begins a run with every homing: also when its servos were silent for a moment."""

    def __init__(self, leader: Leader, tell: Callable[[str], None]) -> None:
        """`tell` is told what is done."""
        self._leader, self._tell = leader, tell
        self._stands: list[list[Stand]] = []
        self._held_out: list[int] = []
        self.refused: list[str] = []
        """Why poses were not reached, each with the controller's reason."""

    @property
    def runs(self) -> tuple[Run, ...]:
        """Those in which the robot stood anywhere."""
        return tuple(
            Run(poses=_poses(stands), held_out=held_out)
            for stands, held_out in zip(self._stands, self._held_out, strict=True)
            if stands
        )

    def home(self) -> None:
        """Begin a run; raises RobotStoppedError."""
        self._leader.patiently(self._home, anew=lambda: None)

    def back(self, pose_mm: Array) -> None:
        """To this pose (A,), where nothing is looked at; raises RobotStoppedError."""
        self._leader.patiently(lambda: self._leader.go(pose_mm), anew=self._home)

    def through(self, poses_mm: Array, what: str, *, held_out: bool = False) -> list[Stand]:
        """Where the robot stood in these poses (n, A): also half-way to one that was refused, because axes went that far.

        Raises RobotStoppedError, also when all of them are refused.
        """
        stands: list[Stand] = []
        refused = len(self.refused)
        for number, pose_mm in enumerate(poses_mm, start=1):
            self._tell(f"{what}: {number} of {len(poses_mm)}")
            stand = self._leader.patiently(partial(self._stand_at, pose_mm), anew=self._home)
            if stand is not None:
                stands.append(stand)
                self._stands[-1].append(stand)
                self._held_out[-1] += held_out
        if len(self.refused) - refused == len(poses_mm):
            raise RobotStoppedError(
                f"{what}: not one move is possible: {self.refused[-1]}", "move less far: --share"
            )
        return stands

    def _stand_at(self, pose_mm: Array) -> Stand | None:
        """None where the robot was refused to move at all."""
        begin_mm = self._leader.command_mm()
        try:
            self._leader.go(pose_mm)
        except JogRefusedError as refusal:
            self.refused.append(str(refusal))
            if np.abs(self._leader.command_mm() - begin_mm).max() < THERE_MM:
                return None
        return self._leader.stand()

    def _home(self) -> None:
        self._leader.home()
        self._stands.append([])
        self._held_out.append(0)


def _poses(stands: Sequence[Stand]) -> Poses:
    return Poses(
        position_mm=np.array([stand.position_mm for stand in stands]),
        node_mm=np.array([stand.node_mm for stand in stands]),
        sigma_mm=np.array([stand.sigma_mm for stand in stands]),
        arc_mm=stands[0].arc_mm,
    )
