"""The pictures that later ones are held against: a bench's backgrounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from nodal.bench_file import Bench, recorded_bench
from nodal.calibrate.background.keeping import stage_of
from nodal.errors import CalibrationError
from recordings.log import Log
from sensing.pictures.light import Image
from sensing.pictures.picture import Picture


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """Pictures (h, w, 3) without the robot by camera, and where the stage stood for them."""

    pictures: Mapping[str, Image]
    insertion_mm: float


def reference(recording: str | None, bench: Bench) -> Reference:
    """The bench's own backgrounds, failing that those attached to the recording; raises CalibrationError without either."""
    backgrounds = bench.backgrounds
    if not backgrounds and recording:
        log = Log(recording)
        if log.attachments:
            backgrounds = recorded_bench(Path(recording), log.attachments, {}).backgrounds
    names = [camera.camera for camera in bench.rig]
    if missing := [name for name in names if name not in backgrounds]:
        raise CalibrationError(
            f"{bench.path}: no background picture of camera {', '.join(missing)} to compare with; `nodal calibrate background` takes them"
        )
    sizes = {camera.camera: (camera.width_px, camera.height_px) for camera in bench.rig}
    return Reference(
        pictures={name: Picture(name, backgrounds[name], sizes[name]).colour for name in names},
        insertion_mm=stage_of(bench),
    )
