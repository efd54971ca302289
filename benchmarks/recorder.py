"""The recorder under load: `python -m benchmarks.recorder --minutes 10`.

One process says everything that a bench says, at the table's rates: two cameras of 1080p at 30 Hz, the controller's topics
at 200 Hz, and all the rest. Another, `nodal record`, records it. Then the same again, and the recorder is killed (kill -9)
in the middle. Payloads are random bytes as long as those of a real run, which the recorder does not look into.
"""

import argparse
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

import msgspec
import numpy as np

from messaging.message import Message
from messaging.session import open_rendezvous, open_session
from messaging.settings import ZenohSettings
from messaging.topics import TOPICS, Topic
from nodal.bench_file import load_bench
from nodal.toml_file import written
from recordings import Log

CAMERAS = ("left", "right")
TICK_HZ = 200
SIZE_BYTES = {
    "truth": 2615,
    "tendon/state": 259,
    "tendon/command": 65,
    "controller/state": 280,
    "controller/memory": 13476,
    "camera/*/calibration": 316,
    "camera/*/pose": 81,
    "shape": 3158,
    "shape/centreline": 1045,
    "shape/nodal_points": 189,
    "sensing/memory": 2024,
    "controller/desired": 71,
}
"""What a message of each topic weighs in a run of the simulated bench; cameras are chosen on the command line."""


class Payload(Message):
    """Bytes that stand for a message."""

    def __init__(self, content: bytes) -> None:
        """Any bytes."""
        object.__setattr__(self, "content", content)

    def to_bytes(self) -> bytes:
        """As they are."""
        return self.content  # type: ignore[attr-defined,no-any-return]


@dataclass(frozen=True, kw_only=True)
class Load:
    """What is said, and for how long."""

    zenoh: ZenohSettings
    bench: str
    seconds: float
    jpeg_bytes: int


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=0.5, help="length of the first run (default 0.5)")
    parser.add_argument(
        "--kill-after", type=float, default=5.0, help="seconds until kill -9 in the second run"
    )
    parser.add_argument("--jpeg-bytes", type=int, default=289_000, help="size of a frame (default 289000)")
    parser.add_argument("--folder", type=Path, help="where to record (default: a temporary folder)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        record_all(Path(folder), 60 * arguments.minutes, arguments.jpeg_bytes)
        kill_one(Path(folder), arguments.kill_after, arguments.jpeg_bytes)


def record_all(folder: Path, seconds: float, jpeg_bytes: int) -> None:
    """Record a whole run, and print what was said, recorded, lost, and what it cost."""
    path = folder / "load.mcap"
    with bench(folder) as (config, zenoh, name):
        load = Load(zenoh=zenoh, bench=name, seconds=seconds, jpeg_bytes=jpeg_bytes)
        with recorder(config, path) as process:
            cpu_s = cpu_time_s(process.pid)
            said = spoken(load)
            # what it spends while the other process starts and ends counts against it
            share = (cpu_time_s(process.pid) - cpu_s) / seconds
            time.sleep(1)
            process.send_signal(signal.SIGTERM)
            process.wait(60)
    recorded = Counter(one.topic for one in Log(path).messages())
    print(f"{'topic':28}{'said':>10}{'recorded':>10}{'lost':>8}")
    for key, count in said.items():
        print(f"{key:28}{count:10}{recorded[key]:10}{count - recorded[key]:8}")
    print(f"{'all':28}{said.total():10}{sum(recorded[key] for key in said):10}", end="")
    print(f"{sum(said[key] - recorded[key] for key in said):8}")
    sizes = [part.stat().st_size for part in Log(path).parts]
    print(
        f"files: {', '.join(f'{size / 1e6:.1f} MB' for size in sizes)}; {sum(sizes) / 1e6 / seconds:.1f} MB/s"
    )
    print(f"recorder: {100 * share:.1f} % of one core over {seconds:.0f} s")


def kill_one(folder: Path, kill_after_s: float, jpeg_bytes: int) -> None:
    """Kill a recorder at work, and print what it had heard and not kept."""
    path = folder / "killed.mcap"
    with bench(folder) as (config, zenoh, name):
        load = Load(zenoh=zenoh, bench=name, seconds=kill_after_s + 2, jpeg_bytes=jpeg_bytes)
        with recorder(config, path) as process, speaking(load) as (speaker, _):
            time.sleep(kill_after_s)
            killed_ns = time.time_ns()
            process.kill()
            process.wait()
            speaker.join()
    kept = list(Log(path).messages())
    newest_ns = max(one.publish_time_ns for one in kept)
    per_ns = len(kept) / (newest_ns - kept[0].publish_time_ns)
    lost_ns = killed_ns - newest_ns
    print(
        f"kill -9: the last {lost_ns / 1e6:.0f} ms were lost, about {lost_ns * per_ns:.0f} publications of {len(kept)}"
    )


@contextmanager
def bench(folder: Path) -> Iterator[tuple[Path, ZenohSettings, str]]:
    """A bench file on a port of its own, with its rendezvous."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        zenoh = ZenohSettings(rendezvous=f"tcp/127.0.0.1:{probe.getsockname()[1]}")
    settings = msgspec.structs.replace(load_bench("simulated").settings, zenoh=zenoh)
    config = folder / "bench.toml"
    config.write_text(written(msgspec.to_builtins(settings)))
    with open_rendezvous(zenoh, settings.name):
        yield config, zenoh, settings.name


@contextmanager
def recorder(config: Path, path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """`nodal record`, once its file is there."""
    command = [sys.executable, "-m", "nodal", "record", "--config", str(config), "--file", str(path)]
    with subprocess.Popen(command) as process:
        try:
            while not path.exists():
                if process.poll() is not None:
                    sys.exit("nodal record ended too early")
                time.sleep(0.05)
            time.sleep(2)  # for its subscriptions to be known everywhere
            yield process
        finally:
            process.kill()


@contextmanager
def speaking(
    load: Load,
) -> Iterator[tuple[multiprocessing.process.BaseProcess, "dict[str, Synchronized[int]]"]]:
    """A process that says the load; what it said by topic stands in shared memory once it ends."""
    context = multiprocessing.get_context("spawn")
    said: dict[str, Synchronized[int]] = {topic.key: context.Value("q", 0) for topic, _ in voices(load)}
    speaker = context.Process(target=speak, args=(load, said))
    speaker.start()
    try:
        yield speaker, said
    finally:
        speaker.join()


def spoken(load: Load) -> Counter[str]:
    """Say the whole load; how often each topic was said."""
    with speaking(load) as (speaker, said):
        speaker.join()
    return Counter({key: count.value for key, count in said.items()})


def speak(load: Load, said: "dict[str, Synchronized[int]]") -> None:
    """Say everything at its rate, on a fixed schedule."""
    rng = np.random.default_rng(1)
    with open_session(load.zenoh, load.bench, "load") as session:
        speakers = [
            (session.publisher(topic), TICK_HZ / (topic.rate_hz or 1), Payload(rng.bytes(size)), topic.key)
            for topic, size in voices(load)
        ]
        time.sleep(2)  # for the recorder's subscriptions to be known here
        start_s = time.monotonic()
        for tick in range(int(load.seconds * TICK_HZ)):
            for publisher, ticks, payload, key in speakers:
                if tick % ticks < 1:
                    publisher.put(payload)
                    said[key].value += 1
            time.sleep(max(0.0, start_s + (tick + 1) / TICK_HZ - time.monotonic()))
        time.sleep(1)  # what waits in Zenoh's queue would be lost with the session


def voices(load: Load) -> list[tuple[Topic, int]]:
    """Every topic that is said steadily and logged, one for each camera, and how many bytes it carries."""
    sizes = {**SIZE_BYTES, "camera/*": load.jpeg_bytes}
    return [
        (topic.named(name), sizes[topic.key])
        for topic in TOPICS
        if topic.logged and topic.rate_hz
        for name in (CAMERAS if "*" in topic.key else ("",))
    ]


def cpu_time_s(pid: int) -> float:
    """What a process has spent so far, in all its threads (proc(5), stat, fields 14 and 15)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
