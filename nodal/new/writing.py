"""A bench's folder: its bench file, and for a simulated bench the file that says where its cameras really are."""

import re
import secrets
import socket
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import msgspec

from nodal.bench_file import make_folder
from nodal.calibration_file import save_rig
from nodal.errors import BenchFileError, CommandError
from nodal.new.true_bench import true_cameras, true_simulation
from nodal.toml_file import written

BENCH, TRUE_RIG = "bench.toml", "true-rig.json"
MARK = "FILL IN"
TO_FILL_IN = {
    "sections": "the lengths of your sections, and below whether there is a stage",
    "cameras": "with `nodal cameras write`",
    "board": "what `nodal calibrate board` measured",
    "port": "the adapter's name",
    "pulleys": "ids, the pulleys' radii, and how far each servo may pull and how hard",
    "stage": "id, lead, travel and zero",
}
SKEW = """\
# Webcams run freely, so two at 30 Hz take their pictures up to half a period apart; three up to two thirds, 0.023.
maximum_skew_s = 0.017
"""
_PORTS = range(20_000, 32_000)  # below those that are given to outgoing connections
_DIGITS = 6


def write_real(folder: Path) -> Path:
    """The bench file of a bench like the reference bench, with everything to be filled in marked; raises CommandError,
    BenchFileError.
    """
    marks = {f"{what}_to_fill_in": f"\n# {MARK}: {words}." for what, words in TO_FILL_IN.items()}
    # without a fixture these lines must not stand there
    at_base = re.sub(r"^(?=[^#\n])", "# ", _text("board_at_base.toml"), flags=re.MULTILINE)
    return _write(
        folder,
        what="A bench with two webcams, a robot of two sections, and its servos.",
        cameras=_filled("real_cameras.toml", marks),
        skew=SKEW,
        board_at_base=f"# Only where there is a fixture for the board:\n{at_base}",
        port="/dev/serial/by-id/FILL-IN",
        servo_patience="",
        simulation="",
        **marks,
    )


def write_simulated(folder: Path, seed: int) -> Path:
    """The bench file of a simulated bench, and beside it where its cameras really are; raises CommandError, BenchFileError,
    CalibrationFileError.
    """
    file = _write(
        folder,
        what=f"A simulated bench as it comes out of its box, number {seed}.",
        cameras=_text("simulated_cameras.toml"),
        skew="",
        board_at_base=_text("board_at_base.toml"),
        port="servos",
        servo_patience=_text("servo_patience.toml"),
        simulation=_text("simulation.toml")
        + written({"simulation": {"rig": TRUE_RIG, **_told(true_simulation(seed))}}),
        **{f"{what}_to_fill_in": "" for what in TO_FILL_IN},
    )
    save_rig(folder / TRUE_RIG, true_cameras(seed))
    return file


def _write(folder: Path, **blanks: str) -> Path:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise CommandError(
            f"{folder}: it is there already; a new bench needs a folder of its own, new or empty"
        )
    make_folder(folder, "FOLDER")
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", folder.resolve().name)
    file = folder / BENCH
    try:
        file.write_text(
            _filled("bench.toml", {"name": name, "rendezvous": _rendezvous(), **blanks}), encoding="utf-8"
        )
    except OSError as error:
        raise BenchFileError(f"{file}: cannot be written: {error.strerror}") from error
    return file


def _text(name: str) -> str:
    return files("nodal.new").joinpath(name).read_text(encoding="utf-8")


def _filled(name: str, blanks: Mapping[str, str]) -> str:
    return Template(_text(name)).substitute(blanks)


def _rendezvous() -> str:
    """A port that nobody uses now, and that no other new bench is likely to be given."""
    while True:
        port = secrets.choice(_PORTS)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        return f"tcp/127.0.0.1:{port}"


def _told(settings: msgspec.Struct) -> dict[str, Any]:
    """What differs from the settings' defaults, rounded for the eye."""
    return {
        field.name: _rounded(value)
        for field in msgspec.structs.fields(settings)
        if (value := getattr(settings, field.name)) != field.default
    }


def _rounded(value: Any) -> Any:
    if isinstance(value, msgspec.Struct):
        return _told(value)
    if isinstance(value, tuple):
        return [_rounded(item) for item in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
