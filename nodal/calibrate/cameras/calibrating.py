"""The course of `nodal calibrate cameras`: views are taken, cameras calibrated, and all of it kept."""

import argparse
import dataclasses
import sys
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from calibration.board import Board
from calibration.camera_set import CameraSet
from calibration.coverage import Coverage
from calibration.solving import Calibration, calibrate
from calibration.views import Size
from drivers.cameras import (
    CameraSettings,
    CameraSilentError,
    FileCameraSettings,
    FolderCameraSettings,
    V4l2CameraSettings,
)
from drivers.cameras.frame_sets import frame_sets
from messaging.scene import Scene
from nodal.bench_file import BenchFile
from nodal.bench_settings import BenchSettings
from nodal.calibrate.cameras.kept_views import NewViews
from nodal.calibrate.cameras.outcome import Outcome
from nodal.calibrate.cameras.progress import TakingProgress
from nodal.calibrate.cameras.taking import Taking, newest
from nodal.calibrate.cameras.verdict import Grade, judgements, overall
from nodal.calibrate.cameras.waiting import PATIENCE_S, HeardCamera, why_no_set
from nodal.calibrate.ending import report_anew
from nodal.calibrate.person import person_at
from nodal.calibration.folder import CAMERAS, calibration_folder, cameras_in, own_bench, save_json
from nodal.calibration_file import load_rig
from nodal.cameras.chosen import chosen_cameras, running_cameras
from nodal.errors import CalibrationError, CommandError

SILENCE_S = 20.0
TREMBLING = 1.05
"""By how much longer than a share of their period cameras' pictures may lie apart that keep their rate as well as they can."""
MOST_REASONS = 5


def calibrate_cameras(arguments: argparse.Namespace) -> Outcome:
    """Take views and calibrate; raises ViewsError or CalibrationError when that cannot be done, and overwrites nothing then."""
    bench = own_bench(arguments.config)
    board = Board(bench.checked().board)
    chosen, before, folder = _chosen(arguments, bench.settings), _before(bench), calibration_folder(bench)
    with NewViews(folder) as kept:
        one_by_one = any(isinstance(camera, FolderCameraSettings) for camera in chosen.values())
        taking = Taking(board, chosen, kept, one_by_one=one_by_one)
        _take(bench, chosen, taking, arguments.views)
        print(f"{len(taking.views)} views are taken; calibrating", file=sys.stderr, flush=True)
        found = _calibrated(taking, board)
        _refuse_worse(folder / CAMERAS, found.cameras)
        save_json(folder / CAMERAS, found.cameras)
        kept.replace_old(found)
    return Outcome(
        bench=bench,
        cameras=found.cameras,
        file=folder / CAMERAS,
        report=report_anew(bench),
        refused=taking.refused,
        before=before,
    )


def _refuse_worse(file: Path, found: CameraSet) -> None:
    """Cameras that nobody should rely on do not take the place of better ones; raises CalibrationError."""
    if not file.exists() or overall(judgements(found)) is not Grade.POOR:
        return
    if overall(judgements(cameras_in(file))) is not Grade.POOR:
        poor = "; ".join(f"{one.what}: {one.advice}" for one in judgements(found) if one.grade is Grade.POOR)
        raise CalibrationError(f"these cameras are poor, and those in {file} are better and stay. {poor}")


def _chosen(arguments: argparse.Namespace, settings: BenchSettings) -> Mapping[str, CameraSettings]:
    chosen = chosen_cameras(arguments, settings)
    if absent := [name for name in settings.cameras if name not in chosen]:
        raise CommandError(
            f"camera {', '.join(absent)}: no pictures are given; all cameras are calibrated together"
        )
    return chosen


def _take(bench: BenchFile, chosen: Mapping[str, CameraSettings], taking: Taking, wanted: int | None) -> None:
    """Views until they are enough, or all that files hold, or so many as are wanted, or until Ctrl-C or a camera that is gone."""
    of_files = any(isinstance(camera, FileCameraSettings) for camera in chosen.values())
    skew_s = still_skew_s(bench.settings)
    with running_cameras(bench, chosen, "calibration") as (running, session):
        if not of_files:
            person_at(bench.settings, session).please(Scene.BOARD)
        cameras = [HeardCamera(camera) for camera in running]
        sets = frame_sets(cameras, skew_s, SILENCE_S)
        came_s = time.monotonic()
        with TakingProgress() as progress:
            try:
                for frame_set in sets if of_files else newest(sets):
                    now_s = time.monotonic()
                    if frame_set is None:
                        if now_s - came_s > PATIENCE_S:
                            progress.show(taking, why_no_set(cameras, skew_s, now_s))
                        continue
                    came_s = now_s
                    if not taking.look(frame_set):
                        continue
                    _check_sizes(bench.settings, taking.sizes)
                    progress.show(taking)
                    if len(taking.views) == wanted or (not of_files and not taking.missing):
                        break
            except (KeyboardInterrupt, CameraSilentError) as end:
                if not taking.views and isinstance(end, CameraSilentError):
                    raise
                why = str(end) or "interrupted"
                print(f"{why}: going on with the views that there are", file=sys.stderr, flush=True)
        if taking.coverage is None or not taking.views:
            reasons = "; ".join(
                f"{reason} ({count})" for reason, count in taking.refused.most_common(MOST_REASONS)
            )
            raise CalibrationError(
                f"no view of the board was taken. {reasons or why_no_set(cameras, skew_s, time.monotonic())}"
            )


def still_skew_s(settings: BenchSettings) -> float:
    """How far apart the cameras may see a board that stands still: cameras that run freely, each in its own step, always
    have pictures within this share of their period, whatever the bench allows for a robot that moves.
    """
    rates_hz = [
        camera.rate_hz for camera in settings.cameras.values() if isinstance(camera, V4l2CameraSettings)
    ]
    count = len(settings.cameras)
    period_s = 1 / min(rates_hz) if rates_hz else 0.0
    return max(settings.sensing.maximum_skew_s, TREMBLING * period_s * (count - 1) / count)


def _check_sizes(settings: BenchSettings, sizes: Mapping[str, Size]) -> None:
    """A calibration holds for one size of pictures; raises CalibrationError."""
    for name, size in sizes.items():
        asked = settings.cameras[name]
        if isinstance(asked, V4l2CameraSettings) and size != (asked.width_px, asked.height_px):
            raise CalibrationError(
                f"camera {name}: its pictures are {size[0]} x {size[1]} px, but the bench asks it for {asked.width_px} x "
                f"{asked.height_px} px: take them at that size, or change width_px and height_px in the bench file"
            )


def _calibrated(taking: Taking, board: Board) -> Calibration:
    found = calibrate(board, taking.views, taking.sizes)
    shown = Coverage(board, taking.sizes)
    for view in taking.views:
        if view.name in found.rig_from_board:
            shown.offer(view)
    cameras = msgspec.structs.replace(
        found.cameras,
        cameras=tuple(
            msgspec.structs.replace(camera, empty_ninths=shown.empty_ninths(camera.name))
            for camera in found.cameras.cameras
        ),
        made_at=datetime.now(UTC).isoformat(timespec="seconds"),
        missing=shown.missing(),
    )
    return dataclasses.replace(found, cameras=cameras)


def _before(bench: BenchFile) -> CameraSet | None:
    """The cameras of the calibration file, which were calibrated some other time; None where there is none."""
    file = Path(bench.settings.calibration)
    if not file.exists():
        return None
    known = {camera.camera: camera for camera in load_rig(file)}
    same = [known[name] for name in bench.settings.cameras if name in known]
    return CameraSet.of_rig(same) if len(same) == len(bench.settings.cameras) else None
