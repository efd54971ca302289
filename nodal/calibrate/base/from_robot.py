"""Where the robot stands, from the robot itself: tendons pulled, the stage moved, midlines measured."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.base import Base
from calibration.base_robot import Pose, Pull, base_from_robot
from calibration.camera_set import CameraSet
from drivers.cameras import Camera
from nodal.bench_settings import BenchSettings
from nodal.calibrate.base.midlines import MidlineFinder, Midlines
from nodal.calibrate.base.moving import Mover, moving_robot
from nodal.calibrate.hand import Hand
from nodal.calibrate.looking import Jpegs, taken
from nodal.errors import BenchFileError, CalibrationError
from sensing.errors import RefusedError
from sensing.pictures.picture import Picture
from sensing.refined.tube import Tip
from sensing.scene import Scene

SETS = 3
"""So many sets of pictures show each pose."""
STEP_MM = 5.0
"""From one place of the stage to the next."""
PLACES = 5
LEAST_PLACES = 3
TENTH_MM = 0.1


@dataclass(frozen=True)
class Look:
    """The robot at rest: sets of pictures, and where the stage stood by its servo."""

    sets: list[Jpegs]
    insertion_mm: float


@dataclass(frozen=True)
class PullSeen:
    """One tendon or pair pulled to both ends of its way."""

    name: str
    angle_rad: float
    least: Look
    most: Look


class RobotWay:
    """Leads the robot and looks at it; then finds its frame among the cameras."""

    def __init__(
        self,
        settings: BenchSettings,
        cameras: CameraSet,
        running: Sequence[Camera],
        pull_mm: float,
        turned: Callable[[], None],
    ) -> None:
        """`running` are all cameras of the set; `pull_mm` is how far each tendon or pair is pulled. `turned` is called again
        and again, and may raise to end it.
        """
        self._settings, self._running, self._pull_mm, self._turned = settings, running, pull_mm, turned
        self._tendons = settings.controller.kinematics(settings.robot).tendons
        self._scene = rig_scene(settings, cameras)
        self._finder: MidlineFinder | None = None

    def found(self, hand: Hand) -> tuple[Base, Look]:
        """The robot frame, and the robot as it stood first; the tendons are let go at the end, whatever happens.

        Raises CalibrationError, RobotStoppedError, BasePosesError, CameraError.
        """
        with moving_robot(hand, self._settings.controller.jog, self._tendons, self._turned) as mover:
            pulls = [seen for axis in range(self._tendons) for seen in self._pulled(mover, axis)]
            bent = [self._pictures(end.sets[0]) for pull in pulls for end in (pull.least, pull.most)]
            length_mm = self._settings.robot.length_mm
            self._finder = MidlineFinder(self._scene, length_mm, bent)
            travel = self._travelled(mover) if self._settings.robot.stage else []
        return self._base(pulls, travel), (travel or [pulls[0].least])[0]

    def _pulled(self, mover: Mover, axis: int) -> list[PullSeen]:
        """Both ways for a pair; a tendon of its own is let out again, because it cannot push."""
        section, angle_deg, pair = self._tendon(axis)
        name = self._settings.servos.tendons[axis].name
        _tell(f"pulling {name}, of section {section + 1}, by {self._pull_mm:g} mm")
        mover.jog(axis, self._pull_mm)
        most = self._look(mover)
        mover.jog(axis, -2 * self._pull_mm if pair else -self._pull_mm)
        least = self._look(mover)
        if pair:
            mover.jog(axis, self._pull_mm)
        return [PullSeen(name, float(np.radians(angle_deg)), least, most)]

    def _tendon(self, axis: int) -> tuple[int, float, bool]:
        """The section of an axis, the angle to which it bends the robot, and whether it is a pair."""
        every = [
            (section, angle_deg, bool(tendons.pair_angle_deg))
            for section, tendons in enumerate(self._settings.controller.sections)
            for angle_deg in tendons.angle_deg
        ]
        return every[axis]

    def _travelled(self, mover: Mover) -> list[Look]:
        """The unbent robot at one place of the stage after another, as far as it is seen, and the stage back again."""
        low_mm, high_mm = self._settings.controller.limits.insertion_mm
        looks = [self._look(mover)]
        begin_mm = min(max(looks[0].insertion_mm, low_mm), high_mm)
        way = 1.0 if high_mm - begin_mm >= begin_mm - low_mm else -1.0
        room_mm = (high_mm - begin_mm if way > 0 else begin_mm - low_mm) - TENTH_MM
        step_mm = min(STEP_MM, room_mm / (LEAST_PLACES - 1))
        if step_mm < 1.0:
            raise CalibrationError(
                f"the stage stands at {begin_mm:.1f} mm and may go from {low_mm:g} to {high_mm:g} mm "
                "(controller.limits.insertion_mm): too little travel to see its direction"
            )
        _tell(f"moving the stage in steps of {step_mm:g} mm")
        gone_mm = 0.0
        while len(looks) < PLACES and abs(gone_mm) + step_mm <= room_mm:
            mover.jog(self._tendons, way * step_mm)
            gone_mm += way * step_mm
            look = self._look(mover)
            try:
                self._midline(look.sets[0])
            except RefusedError as reason:
                _tell(f"no further than this: {reason}")
                break
            looks.append(look)
        mover.jog(self._tendons, -gone_mm)
        if len(looks) < LEAST_PLACES:
            raise CalibrationError(
                f"the whole robot was seen at {len(looks)} places of the stage only, {step_mm:g} mm apart; {LEAST_PLACES} are "
                "needed: turn the cameras so that they see it further up and down"
            )
        return looks

    def _look(self, mover: Mover) -> Look:
        since_ns = mover.settled_ns()
        insertion_mm = mover.stage_mm
        skew_s = self._settings.sensing.maximum_skew_s
        return Look(taken(self._running, skew_s, SETS, since_ns, mover.attend), insertion_mm)

    def _pictures(self, jpegs: Jpegs) -> dict[str, Picture]:
        return {name: self._scene.picture(name, data) for name, data in jpegs.items()}

    def _midline(self, jpegs: Jpegs) -> Midlines:
        if self._finder is None:
            raise TypeError("midlines are found after tendons were pulled")
        return self._finder.find(self._pictures(jpegs))

    def _base(self, pulls: Sequence[PullSeen], travel: Sequence[Look]) -> Base:
        pulled = [(pull, self._midlines(pull.least), self._midlines(pull.most)) for pull in pulls]
        travelled = [(look, self._midlines(look)) for look in travel]
        lines = [
            *(line for _, least, most in pulled for line in (*least, *most)),
            *(line for _, found in travelled for line in found),
        ]
        tip = min(Tip, key=lambda kind: sum(line[kind].misfit for line in lines))

        def poses(look: Look, found: Sequence[Midlines]) -> tuple[Pose, ...]:
            return tuple(Pose(line[tip].points_mm, look.insertion_mm) for line in found)

        return base_from_robot(
            [
                Pull(pull.name, pull.angle_rad, poses(pull.least, least), poses(pull.most, most))
                for pull, least, most in pulled
            ],
            [pose for look, found in travelled for pose in poses(look, found)],
            {
                camera.name: float(np.mean([line[tip].residual_px[camera.name] for line in lines]))
                for camera in self._scene.cameras
            },
        )

    def _midlines(self, look: Look) -> list[Midlines]:
        """Those of a look's sets in which the robot is seen well; raises CalibrationError when it is in none."""
        found, reason = [], ""
        for jpegs in look.sets:
            self._turned()
            try:
                found.append(self._midline(jpegs))
            except RefusedError as error:
                reason = str(error)
        if not found:
            raise CalibrationError(f"the robot was not measured where it stood still: {reason}")
        return found


def rig_scene(settings: BenchSettings, cameras: CameraSet) -> Scene:
    """The bench's scene in the rig frame; raises BenchFileError for a background that is not there."""
    scene = Scene.of(
        cameras.in_robot_frame(np.eye(4)),
        backgrounds=backgrounds(settings),
        colour_rgb=settings.sensing.backdrop_colour,
        length_mm=settings.robot.length_mm,
        threshold=settings.sensing.threshold,
    )
    # a work area must contain the base, of which nothing is known yet
    areas = {
        name: np.array(corners, dtype=np.float64) for name, corners in settings.sensing.work_area.items()
    }
    return replace(scene, work_areas=areas)


def backgrounds(settings: BenchSettings) -> dict[str, bytes]:
    """The coded pictures without the robot that the bench file names, by camera; raises BenchFileError."""
    files = settings.sensing.background
    try:
        return {name: Path(file).read_bytes() for name, file in files.items()}
    except OSError as error:
        raise BenchFileError(
            f"sensing.background: {error.filename} cannot be read: {error.strerror}"
        ) from error


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
