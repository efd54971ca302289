"""The course of `nodal calibrate cameras`: views are taken, cameras calibrated, and all of it kept."""

import argparse
import dataclasses
import sys
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from calibration.board import Board
from calibration.camera_set import CameraSet
from calibration.errors import ViewsError
from calibration.solving import Calibration, calibrate
from drivers.cameras import FileCameraSettings, FolderCameraSettings
from drivers.cameras.frame_sets import frame_sets
from messaging.scene import Scene
from nodal.bench_file import BenchFile
from nodal.calibrate.cameras.kept_views import NewViews
from nodal.calibrate.cameras.outcome import Outcome
from nodal.calibrate.cameras.progress import TakingProgress
from nodal.calibrate.cameras.taking import Taking, newest
from nodal.calibrate.ending import report_anew
from nodal.calibrate.person import person_at
from nodal.calibration.folder import CAMERAS, calibration_folder, own_bench, save_cameras
from nodal.calibration_file import load_rig
from nodal.cameras.chosen import chosen_cameras, running_cameras
from nodal.errors import CalibrationError, CommandError

SILENCE_S = 20.0


def calibrate_cameras(arguments: argparse.Namespace) -> Outcome:
    """Take views and calibrate; raises ViewsError or CalibrationError when that cannot be done, and overwrites nothing then."""
    bench = own_bench(arguments.config)
    board = Board(bench.settings.board)
    folder = calibration_folder(bench)
    kept = NewViews(folder)
    taking = _taken(arguments, bench, board, kept)
    print(f"{len(taking.views)} views are taken; calibrating", file=sys.stderr, flush=True)
    try:
        found = _calibrated(taking, board)
    except (ViewsError, CalibrationError) as error:
        raise CalibrationError(
            f"{error}\nnothing was changed; the views of this attempt are in {kept.set_aside()}"
        ) from error
    before = _before(bench)
    save_cameras(folder / CAMERAS, found.cameras)
    kept.replace_old(found)
    return Outcome(
        bench=bench,
        cameras=found.cameras,
        file=folder / CAMERAS,
        report=report_anew(bench),
        refused=taking.refused,
        before=before,
    )


def _taken(arguments: argparse.Namespace, bench: BenchFile, board: Board, kept: NewViews) -> Taking:
    """Views until they are enough, or all that files hold, or so many as are wanted, or until Ctrl-C."""
    chosen = chosen_cameras(arguments, bench.settings)
    if absent := [name for name in bench.settings.cameras if name not in chosen]:
        raise CommandError(
            f"camera {', '.join(absent)}: no pictures are given; all cameras are calibrated together"
        )
    of_files = any(isinstance(camera, FileCameraSettings) for camera in chosen.values())
    one_by_one = any(isinstance(camera, FolderCameraSettings) for camera in chosen.values())
    taking = Taking(board, chosen, kept, one_by_one=one_by_one)
    with running_cameras(bench, chosen, "calibration") as (cameras, session):
        if not of_files:
            person_at(bench.settings, session).please(Scene.BOARD)
        sets = frame_sets(cameras, bench.settings.sensing.maximum_skew_s, SILENCE_S)
        with TakingProgress() as progress:
            try:
                for frame_set in sets if of_files else newest(sets):
                    if frame_set is None or not taking.look(frame_set):
                        continue
                    progress.show(taking)
                    if len(taking.views) == arguments.views or (not of_files and not taking.missing):
                        break
            except KeyboardInterrupt:
                print("interrupted: going on with the views that there are", file=sys.stderr, flush=True)
    return taking


def _calibrated(taking: Taking, board: Board) -> Calibration:
    if taking.coverage is None or not taking.views:
        reasons = "; ".join(f"{reason} ({count})" for reason, count in taking.refused.most_common(5))
        raise CalibrationError(
            f"no view of the board was taken. {reasons or 'There was no frame of all cameras'}"
        )
    found = calibrate(board, taking.views, taking.sizes)
    made_at = datetime.now(UTC).isoformat(timespec="seconds")
    return dataclasses.replace(found, cameras=msgspec.structs.replace(found.cameras, made_at=made_at))


def _before(bench: BenchFile) -> CameraSet | None:
    """The cameras of the calibration file, which were calibrated some other time; None where there is none."""
    file = Path(bench.settings.calibration)
    if not file.exists():
        return None
    known = {camera.camera: camera for camera in load_rig(file)}
    same = [known[name] for name in bench.settings.cameras if name in known]
    return CameraSet.of_rig(same) if len(same) == len(bench.settings.cameras) else None
