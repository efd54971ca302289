"""Latency of the loop: `python -m benchmarks.latency [--seconds 20] [--fifo] [--folder DIR]`.

The real processes (rendezvous, sensing, control, recorder) beside what stands in for cameras and servos (stand_in.py): two
cameras of 1080p at 30 Hz, five servos on a serial device, everything recorded, a target tracked. Printed are capture to
command, the control loop's lateness and rate, and what each process takes of a core. `--fifo` measures a second time with
`controller.real_time` switched on.
"""

import argparse
import dataclasses
import os
import sys
import tempfile
import threading
import time
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.latency.figures import Figures, figures_of
from benchmarks.latency.stand_in import standing_in
from benchmarks.recorder import cpu_time_s
from messaging.session import open_session
from messaging.shape import ShapeEstimate
from nodal import targets
from nodal.bench_file import Bench, load_bench
from nodal.demo.folder import make_demo_folder, processes_of
from nodal.demo.operator import Operator
from nodal.demo.telemetry import Telemetry
from nodal.processes.launcher import Launcher

PLACE_MM = (6.0, 0.0, 82.0)
SETTLE_S = 3.0
PROCESSES = ("control", "sense", "record", "rendezvous")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=20.0, help="how long is measured (default 20)")
    parser.add_argument("--fifo", action="store_true", help="measure with real-time scheduling too")
    parser.add_argument("--folder", type=Path, help="where to record (default: a temporary folder)")
    arguments = parser.parse_args()
    bench = load_bench("simulated")
    benches = {"as installed": bench, **({"real time": in_real_time(bench)} if arguments.fifo else {})}
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        for name, one in benches.items():
            print(
                f"-- {name}, {arguments.seconds:g} s, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} before"
            )
            measure(one, Path(folder) / name.replace(" ", "-"), arguments.seconds).show(sys.stdout)


def in_real_time(bench: Bench) -> Bench:
    """The same bench with the controller first in line."""
    real_time = msgspec.structs.replace(
        bench.settings.controller.real_time, fifo_priority=50, lock_memory=True
    )
    controller = msgspec.structs.replace(bench.settings.controller, real_time=real_time)
    return dataclasses.replace(bench, settings=msgspec.structs.replace(bench.settings, controller=controller))


def measure(bench: Bench, path: Path, seconds: float) -> Figures:
    """Run a bench with its tip at rest in one place, and look at what was recorded; raises NodalError."""
    folder, bench = make_demo_folder(bench, path)
    settings = bench.settings
    node = settings.sensing.nodal_points[-1].name
    with (
        standing_in(folder.bench_file) as (stand_in, playing),
        processes_of(folder, threading.Event(), PROCESSES) as launcher,
        open_session(settings.zenoh, settings.name, "benchmark") as session,
    ):
        telemetry = Telemetry(session)
        launcher.on_turn = telemetry.take
        launcher.start()
        operator = Operator(session, launcher, telemetry)
        operator.follow(targets.points({node: list(PLACE_MM)}, {}), SETTLE_S)
        playing.set()
        # pictures no longer answer to commands: to ask for the very place that they show keeps commands at rest
        place_mm = _place_mm(launcher, telemetry, node)
        operator.follow(targets.points({node: place_mm}, {}), SETTLE_S)
        pids = {name: child.pid for name, child in launcher.children.items()} | {"stand-in": stand_in.pid}
        running = {name: pid for name, pid in pids.items() if pid is not None}
        before = {name: cpu_time_s(pid) for name, pid in running.items()}
        begin_ns = time.time_ns()
        operator.follow(targets.points({node: place_mm}, {}), seconds)
        end_ns = time.time_ns()
        cores = {
            name: (cpu_time_s(running[name]) - before_s) / (end_ns - begin_ns) * 1e9
            for name, before_s in before.items()
        }
        operator.relax()
    return figures_of(folder.recording, begin_ns, end_ns, cores)


def _place_mm(launcher: Launcher, telemetry: Telemetry, node: str) -> list[float]:
    """Where the pictures show this nodal point, in the mean over a while."""
    seen: dict[int, np.ndarray] = {}
    end_s = time.monotonic() + SETTLE_S
    while time.monotonic() < end_s:
        launcher.turn()
        shape = telemetry.shape
        if isinstance(shape, ShapeEstimate) and node in shape.node_names:
            seen[shape.sequence] = shape.node_mm[shape.node_names.index(node)]
    place_mm: list[float] = np.mean(list(seen.values()), axis=0).tolist()
    return place_mm


if __name__ == "__main__":
    main()
