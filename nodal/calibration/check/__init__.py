"""`nodal calibration check`: whether a camera has been bumped."""

import argparse
from typing import TYPE_CHECKING

from nodal.arguments import add_config_argument
from nodal.exit_status import REFUSED

if TYPE_CHECKING:
    from collections.abc import Iterator

    from nodal.bench_file import Bench
    from nodal.calibration.check.looks import Look

SUMMARY = "see whether a camera has moved since the background picture, in a recording or now"
LOOKS, LIVE_LOOKS = 40, 8


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The bench, and where to look."""
    add_config_argument(parser)
    parser.add_argument(
        "--recording", metavar="LOG", help="look into this recording (MCAP) instead of through the cameras"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object, with every look")


def run(arguments: argparse.Namespace) -> int:
    """0 when nothing has moved, 3 when something has, or the cameras contradict one another.

    Raises BenchFileError, CalibrationFileError, CalibrationError, CameraError.
    """
    import msgspec  # noqa: PLC0415
    import numpy as np  # noqa: PLC0415

    from nodal.bench_file import load_bench  # noqa: PLC0415
    from nodal.calibration.check.reference import reference  # noqa: PLC0415
    from nodal.calibration.check.tracks import tracks  # noqa: PLC0415
    from nodal.calibration.check.verdict import judged  # noqa: PLC0415
    from nodal.calibration.check.words import words  # noqa: PLC0415
    from sensing.scene import Scene  # noqa: PLC0415

    bench = load_bench(arguments.config)
    looks = list(_looks(arguments, bench))
    known = reference(arguments.recording, bench)
    scene = Scene.on_bench(bench.settings.sensing, bench.settings.robot, bench.rig, bench.backgrounds)
    found = judged(
        tracks(scene, known.pictures, known.insertion_mm, looks),
        [look.estimate for look in looks],
        np.array([0.0, 0.0, bench.settings.robot.length_mm / 2]),
        looks[0].time_ns,
    )
    print(msgspec.json.encode(found).decode() if arguments.json else "\n".join(words(found)))
    return 0 if found.fine else REFUSED


def _looks(arguments: argparse.Namespace, bench: "Bench") -> "Iterator[Look]":
    from nodal.calibration.check.looks import live_looks, recorded_looks  # noqa: PLC0415

    if arguments.recording:
        from recordings.log import Log  # noqa: PLC0415

        yield from recorded_looks(Log(arguments.recording), bench, LOOKS)
        return
    from nodal.bench_file import read_bench  # noqa: PLC0415
    from nodal.cameras.chosen import running_cameras  # noqa: PLC0415

    file = read_bench(arguments.config)
    with running_cameras(file, file.settings.cameras, "calibration") as (cameras, session):
        yield from live_looks(cameras, session, bench, LIVE_LOOKS)
