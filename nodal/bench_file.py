"""The bench file: one TOML file that composes the settings of every room. docs/bench-file.md says what each key means."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import msgspec

from messaging.frames import CameraCalibration
from nodal.bench_checks import check
from nodal.bench_settings import BenchSettings
from nodal.calibration_file import load_rig, rig_in, rig_text
from nodal.errors import BenchFileError
from nodal.toml_file import Table, merged, read_table, settings_from, table_in, written

PATHS_TO_READ: tuple[tuple[str, ...], ...] = (
    ("calibration",),
    ("sensing", "background", "*"),
    ("controller", "law_file"),
    ("cameras", "*", "file"),
    ("cameras", "*", "folder"),
    ("simulation", "rig"),
)
PATHS_TO_MAKE: tuple[tuple[str, ...], ...] = (
    ("servos", "port"),
    ("simulation", "servos", "link"),
    ("recorder", "folder"),
)
"""Keys whose values are paths, relative to the bench file's folder; `*` stands for every key. What is made by a bench that
comes with nodal goes below `runs/` where the command was started, not into the installed package."""

SHIPPED = Path(str(files("nodal").joinpath("benches")))
BENCH_ATTACHMENT, CALIBRATION_ATTACHMENT, LAW_ATTACHMENT = "bench.toml", "calibration.json", "law.py"


@dataclasses.dataclass(frozen=True, kw_only=True)
class BenchFile:
    """A bench file that was read; the files that it names may not exist yet, and its rooms may not agree yet."""

    path: Path
    settings: BenchSettings

    def checked(self) -> BenchSettings:
        """The settings, all rooms of which agree; raises BenchFileError. The calibration is not looked at."""
        check(self.path, self.settings)
        return self.settings

    def loaded(self) -> "Bench":
        """With the files that it names; raises BenchFileError, CalibrationFileError."""
        background = self.settings.sensing.background
        return _checked(
            self.path,
            self.settings,
            load_rig(Path(self.settings.calibration)),
            lambda camera: _read(self.path, camera, Path(background[camera])),
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bench:
    """A bench file that was read and found consistent, with the files that it names.

    `rig` holds the bench's cameras in the bench file's order; `backgrounds` pictures of their views without the robot;
    `calibration` is the calibration file.
    """

    path: Path
    settings: BenchSettings
    rig: tuple[CameraCalibration, ...]
    backgrounds: Mapping[str, bytes]
    calibration: bytes

    def text(self) -> str:
        """The effective bench file: every setting with the value in force, paths absolute."""
        return written(msgspec.to_builtins(self.settings))

    def attachments(self) -> dict[str, bytes]:
        """What belongs into every recording, so that it can be replayed: effective bench file, calibration, backgrounds, and
        the text of a law that is a file of its own.
        """
        law_file = Path(self.settings.controller.law_file)
        return {
            BENCH_ATTACHMENT: self.text().encode(),
            CALIBRATION_ATTACHMENT: self.calibration,
            **{_background_attachment(name): picture for name, picture in self.backgrounds.items()},
            **({LAW_ATTACHMENT: law_file.read_bytes()} if law_file.is_file() else {}),
        }


def read_bench(config: str | Path) -> BenchFile:
    """Read a bench file, or one that comes with nodal by its name, and nothing that it names; raises BenchFileError."""
    path = bench_path(config)
    table = read_table(path)
    work = work_folder(path)
    for key in PATHS_TO_READ:
        _resolve(table, key, path.parent)
    for key in PATHS_TO_MAKE:
        _resolve(table, key, work)
    return BenchFile(path=path, settings=settings_from(table, BenchSettings, str(path)))


def load_bench(config: str | Path) -> Bench:
    """Read a bench file and the files that it names, all of which agree; raises BenchFileError, CalibrationFileError."""
    return read_bench(config).loaded()


def recorded_bench(source: Path, attachments: Mapping[str, bytes], changes: Table) -> Bench:
    """The bench that made a recording, from the files attached to it; `changes` are tables that replace what they name.

    Raises BenchFileError or CalibrationFileError, which begin with `source`.
    """

    def attached(name: str) -> bytes:
        if name not in attachments:
            raise BenchFileError(f"{source}: no {name} is attached")
        return attachments[name]

    inside = f"{source}, attachment"
    table = table_in(attached(BENCH_ATTACHMENT), f"{inside} {BENCH_ATTACHMENT}")
    settings = settings_from(merged(table, changes), BenchSettings, f"{inside} {BENCH_ATTACHMENT}")
    rig = rig_in(attached(CALIBRATION_ATTACHMENT), f"{inside} {CALIBRATION_ATTACHMENT}")
    return _checked(source, settings, rig, lambda camera: attached(_background_attachment(camera)))


def _checked(
    path: Path,
    settings: BenchSettings,
    calibrated: tuple[CameraCalibration, ...],
    background_of: Callable[[str], bytes],
) -> Bench:
    rig = {camera.camera: camera for camera in calibrated}
    check(path, settings, rig)
    return Bench(
        path=path,
        settings=settings,
        rig=tuple(rig[name] for name in settings.cameras),
        backgrounds={camera: background_of(camera) for camera in settings.sensing.background},
        calibration=rig_text(calibrated).encode(),
    )


def bench_path(config: str | Path) -> Path:
    """The bench file that `--config` means: a path, a folder with a bench.toml in it, or the name of a bench that comes with
    nodal.
    """
    path = Path(config)
    if (path / BENCH_ATTACHMENT).is_file():
        return (path / BENCH_ATTACHMENT).resolve()
    if path.suffix or len(path.parts) > 1 or path.exists():
        return path.resolve()
    shipped = {file.stem: file for file in sorted(SHIPPED.glob("*.toml"))}
    if str(config) not in shipped:
        raise BenchFileError(
            f"{config}: neither a bench file nor a bench that comes with nodal ({', '.join(shipped)})"
        )
    return shipped[str(config)]


def work_folder(path: Path) -> Path:
    """Where a bench makes what it makes: beside its file, or for one that comes with nodal in `runs/NAME` of this folder."""
    return path.parent if path.parent != SHIPPED else Path.cwd() / "runs" / path.stem


def make_folder(folder: Path, what: str) -> Path:
    """This folder, made if it is missing; raises BenchFileError naming `what` asks for it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchFileError(f"{what} = {folder}: cannot be made: {error.strerror}") from error
    return folder


def _background_attachment(camera: str) -> str:
    return f"background-{camera}"


def _resolve(table: Table, key: tuple[str, ...], folder: Path) -> None:
    first, *rest = key
    for name in list(_matching(table, first)):
        value = table[name]
        if rest:
            _resolve(value, tuple(rest), folder)
        elif isinstance(value, str) and value:
            table[name] = str(folder / value)


def _matching(table: Any, name: str) -> Iterator[str]:
    # what is not a table here is refused with a better message when the settings are made
    if isinstance(table, dict):
        yield from table if name == "*" else {name} & set(table)


def _read(bench: Path, camera: str, file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise BenchFileError(
            f"{bench}: sensing.background.{camera} = {file}: cannot be read: {error.strerror}"
        ) from error
