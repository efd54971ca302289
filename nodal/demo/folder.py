"""The folder of one demo: its own bench file, with a port, a serial link and recordings that no other bench uses."""

import dataclasses
import socket
import threading
import time
from collections.abc import Collection
from pathlib import Path

import msgspec

from nodal.bench_file import Bench, load_bench, make_folder
from nodal.calibration_file import save_rig
from nodal.errors import DemoError
from nodal.processes.launcher import STOP_ORDER, Launcher
from nodal.toml_file import written


@dataclasses.dataclass(frozen=True, kw_only=True)
class DemoFolder:
    """Where everything of one demo goes."""

    path: Path

    @property
    def bench_file(self) -> Path:
        """The bench file that the demo's processes read."""
        return self.path / "bench.toml"

    @property
    def logs(self) -> Path:
        """What each process prints."""
        return self.path / "logs"

    @property
    def recording(self) -> Path:
        """The recording; a recorder that was killed goes on in parts beside it."""
        return self.path / "demo.mcap"

    @property
    def summary(self) -> Path:
        """The figures."""
        return self.path / "summary.json"


def processes_of(folder: DemoFolder, stop: threading.Event, names: Collection[str] = STOP_ORDER) -> Launcher:
    """The demo's processes, not started yet; `names` are those that are wanted."""
    # a recorder that was killed must find the recording that it goes on with
    more = {"record": ("--file", str(folder.recording))}
    return Launcher(folder.bench_file, folder.logs, stop, names, more)


def make_demo_folder(bench: Bench, path: Path | None) -> tuple[DemoFolder, Bench]:
    """The folder (`runs/<time>-demo` by default) and the bench in it; raises DemoError for a bench that is not simulated."""
    if bench.settings.simulation is None:
        raise DemoError(
            f"{bench.path}: it has no [simulation]; the demo moves the robot by itself, and only a simulated one"
        )
    folder = DemoFolder(path=(path or Path("runs") / time.strftime("%Y-%m-%dT%H-%M-%S-demo")).resolve())
    make_folder(folder.path, "--out")
    if folder.recording.exists():
        raise DemoError(f"{folder.path}: a demo was recorded here already; recordings are never overwritten")
    make_folder(folder.logs, "--out")
    save_rig(folder.path / "calibration.json", bench.rig)
    for name, picture in bench.backgrounds.items():
        (folder.path / f"background-{name}.jpg").write_bytes(picture)
    folder.bench_file.write_text(_own_bench(bench), encoding="utf-8")
    return folder, load_bench(folder.bench_file)


def _own_bench(bench: Bench) -> str:
    table = msgspec.to_builtins(bench.settings)
    table["calibration"] = "calibration.json"
    table["sensing"]["background"] = {name: f"background-{name}.jpg" for name in bench.backgrounds}
    table["servos"]["port"] = table["simulation"]["servos"]["link"] = "servos"
    table["recorder"]["folder"] = "."
    table["zenoh"]["rendezvous"] = f"tcp/127.0.0.1:{_free_port()}"
    return written(table)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
