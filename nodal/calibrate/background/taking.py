"""`nodal calibrate background`, from the empty scene to the files."""

import argparse
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.cameras import Camera as CameraDriver
from messaging import topics
from messaging.control import TendonState
from messaging.frames import CameraCalibration
from messaging.scene import Scene as SceneToSet
from messaging.session import Newest, Session
from nodal.bench_file import BenchFile
from nodal.bench_settings import BenchSettings
from nodal.calibrate.background.area import Reach
from nodal.calibrate.background.drawing import drawn
from nodal.calibrate.background.judging import CameraBackground, judged, refusals
from nodal.calibrate.background.keeping import BackgroundFound, coded, keep, now, write_picture
from nodal.calibrate.background.robot import RobotSeen, robot_seen
from nodal.calibrate.background.statistics import Pictures
from nodal.calibrate.looking import taken
from nodal.calibrate.person import person_at
from nodal.calibration.folder import calibration_folder, own_bench
from nodal.calibration_file import load_rig
from nodal.cameras.chosen import chosen_cameras, running_cameras
from nodal.errors import CalibrationError
from sensing.geometry.camera import Camera
from sensing.method import METHODS
from sensing.pictures.coding import coding_of
from sensing.pictures.light import Image
from sensing.pictures.picture import Picture
from sensing.scene import Scene
from sensing.sensor import Sensor

Jpegs = Mapping[str, bytes]


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What came of it: the figures, and the files that were written."""

    found: BackgroundFound
    files: tuple[Path, ...]
    bench: BenchFile


class _Stage:
    """Where the stage stands, as far as somebody says so."""

    def __init__(self, states: Newest) -> None:
        self._states = states
        self.newest: TendonState | None = None

    def hear(self) -> None:
        received = self._states.take()
        if received is not None and isinstance(received[0], TendonState):
            self.newest = received[0]

    @property
    def insertion_mm(self) -> float:
        return 0.0 if self.newest is None else self.newest.insertion_mm


def calibrate_background(arguments: argparse.Namespace) -> Outcome:
    """Take, judge, look at the robot, write. Raises CalibrationError with what is wrong, and nothing is written then; BenchFileError,
    CommandError, CameraError, PictureError.
    """
    bench = own_bench(arguments.config)
    chosen = chosen_cameras(arguments, bench.settings)
    rig = _rig(bench, tuple(chosen))
    live = chosen == bench.settings.cameras
    with running_cameras(bench, chosen, "calibration") as (cameras, session):
        stage = _Stage(session.newest(topics.TENDON_STATE))
        if live:
            person_at(bench.settings, session).please(SceneToSet.EMPTY)
        sets = taken(
            cameras,
            bench.settings.sensing.maximum_skew_s,
            arguments.pictures,
            time.monotonic_ns() if live else 0,
            stage.hear,
        )
        pictures, judgements = _judged(bench.settings, rig, sets, stage)
        robot = (
            _robot(bench.settings, rig, cameras, session, stage, pictures, judgements)
            if live and rig
            else None
        )
    found = BackgroundFound(
        made_at=now(),
        insertion_mm=stage.insertion_mm,
        insertion_known=stage.newest is not None,
        cameras=judgements,
        robot=robot,
    )
    files = keep(bench, found, pictures)
    for one in judgements:
        seen = calibration_folder(bench) / f"background-{one.camera}-judged.jpg"
        write_picture(seen, drawn(pictures[one.camera], one))
        files.append(seen)
    return Outcome(found=found, files=tuple(files), bench=bench)


def _rig(bench: BenchFile, names: Sequence[str]) -> tuple[CameraCalibration, ...]:
    """The chosen cameras in the robot frame; none before `nodal calibrate base`. Raises CalibrationFileError."""
    file = Path(bench.settings.calibration)
    if not file.exists():
        print(
            f"{file} is not there yet, so there will be no work area: run this again after `nodal calibrate base`",
            file=sys.stderr,
        )
        return ()
    known = {camera.camera: camera for camera in load_rig(file)}
    if missing := [name for name in names if name not in known]:
        raise CalibrationError(f"{file}: it has no camera {', '.join(missing)}, only {', '.join(known)}")
    return tuple(known[name] for name in names)


def _judged(
    settings: BenchSettings, rig: tuple[CameraCalibration, ...], sets: Sequence[Jpegs], stage: _Stage
) -> tuple[dict[str, Image], tuple[CameraBackground, ...]]:
    """The background pictures by camera and what they tell; raises CalibrationError when they are not of an empty scene."""
    calibrated = {camera.camera: camera for camera in rig}
    travel_mm = settings.controller.limits.insertion_mm if settings.robot.stage else (0.0, 0.0)
    reach = Reach(
        length_mm=settings.robot.length_mm,
        travel_mm=travel_mm,
        holder_radius_mm=settings.sensing.holder_radius_mm,
    )
    heard = stage.newest is not None or not settings.robot.stage
    pictures: dict[str, Image] = {}
    judgements, against = [], []
    for name in sets[0]:
        taken_by = Pictures()
        known = calibrated.get(name)
        size = (known.width_px, known.height_px) if known else coding_of(name, sets[0][name]).size_px
        for jpegs in sets:
            taken_by.add(Picture(name, jpegs[name], size).colour)
        statistics, camera = taken_by.statistics(), Camera(known) if known else None
        pictures[name] = statistics.mean
        judgements.append(judged(name, statistics, camera, reach, stage.insertion_mm))
        against += [
            f"camera {name}: {reason}"
            for reason in refusals(statistics, camera, reach, stage.insertion_mm, stage_heard=heard)
        ]
    if against:
        raise CalibrationError("; ".join(against))
    return pictures, tuple(judgements)


def _robot(
    settings: BenchSettings,
    rig: tuple[CameraCalibration, ...],
    cameras: Sequence[CameraDriver],
    session: Session,
    stage: _Stage,
    pictures: Mapping[str, Image],
    judgements: Sequence[CameraBackground],
) -> RobotSeen:
    """The robot before the new background."""
    person_at(settings, session).please(SceneToSet.ROBOT)
    sensing = settings.sensing
    (jpegs,) = taken(cameras, sensing.maximum_skew_s, 1, time.monotonic_ns(), stage.hear)
    scene = Scene.of(
        rig,
        backgrounds={name: coded(picture) for name, picture in pictures.items()},
        length_mm=settings.robot.length_mm,
        holder_radius_mm=sensing.holder_radius_mm,
        work_areas={one.camera: np.array(one.work_area) for one in judgements if one.work_area is not None},
        threshold=sensing.threshold,
    )
    sensor = Sensor(
        METHODS[sensing.method](scene), sensing.points, settings.robot.length_mm, sensing.stage_age_limit_s
    )
    if stage.newest is not None:
        sensor.heard(stage.newest)
    estimate = sensor.estimate(jpegs, 0, time.time_ns(), lambda: 0)
    return robot_seen(scene, jpegs, estimate)
