"""Makes `photographs.mcap` anew: `python tests/data/record_photographs.py FOLDER OUT.mcap`.

FOLDER holds photographs of one slow motion (sequence/NNN_CAMERA.jpg), the scene without the robot (background/) and
calibration.json, as benchmarks/photographs.py reads them. The first six pairs go into a log of pictures alone, which
`nodal replay OUT.mcap -o photographs.mcap` then estimates.
"""

import json
import sys
from pathlib import Path

import msgspec

from messaging.frames import Frame
from messaging.topics import CAMERA
from nodal.bench_file import BENCH_ATTACHMENT, CALIBRATION_ATTACHMENT, load_bench
from nodal.calibration_file import rig_from_matrices, rig_text
from nodal.toml_file import written
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

PAIRS = 6
BEGIN_NS, PERIOD_NS = 1_780_000_000_000_000_000, 33_333_333
BACKGROUND = "green_bgholder_0"


def main(folder: Path, out: Path) -> None:
    """Write the log of pictures."""
    known = json.loads((folder / "calibration.json").read_text())
    cameras = known["cameras"]
    rig = rig_from_matrices(
        tuple(known["image_size"]),
        *(
            {name: camera[key] for name, camera in cameras.items()}
            for key in ("K", "dist", "camera_from_robot")
        ),
    )
    table = msgspec.to_builtins(load_bench(Path(__file__).with_name("small.toml")).settings)
    table["name"], table["simulation"] = "photographs", None
    table["sensing"]["background"] = {name: f"{name}.jpg" for name in cameras}
    with RecordingWriter(out, RecorderSettings()) as recording:
        recording.attach(BENCH_ATTACHMENT, written(table).encode(), BEGIN_NS)
        recording.attach(CALIBRATION_ATTACHMENT, rig_text(rig).encode(), BEGIN_NS)
        for name in cameras:
            picture = (folder / "background" / f"{BACKGROUND}_{name}.jpg").read_bytes()
            recording.attach(f"background-{name}", picture, BEGIN_NS)
        for number in range(PAIRS):
            time_ns = BEGIN_NS + number * PERIOD_NS
            for name in cameras:
                jpeg = (folder / "sequence" / f"{number:03}_{name}.jpg").read_bytes()
                frame = Frame(camera=name, capture_time_ns=time_ns, jpeg=jpeg)
                recording.write(
                    CAMERA.named(name).key,
                    Frame.protobuf,
                    frame.to_bytes(),
                    sequence=number,
                    publish_time_ns=time_ns,
                    log_time_ns=time_ns,
                )


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
