"""The servo bus at 200 Hz: `python -m benchmarks.servo_bus`.

Five emulated servos at 1 Mbaud answer behind a pty in a process of their own. Each cycle reads everything of all five and
writes five goals, by the project's driver (fast sync read), and for comparison in the same run by ROBOTIS' dynamixel-sdk
(fast and plain sync read of the same 17 bytes, sync write of the same goals). Printed are the time of a reading beside what
the wire alone takes, cycles that were missed, and the client's share of a core. Then the same with every 101st
packet lost on the line.
"""

import argparse
import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.synchronize import Event
from pathlib import Path

import dynamixel_sdk as sdk
import numpy as np
from numpy.typing import NDArray

from benchmarks.yardstick import yardstick
from drivers.actuators import ActuatorError
from drivers.dynamixel import feedback, protocol
from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.control_table import GOAL_POSITION, INDIRECT_ADDRESS_1
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.settings import EmulatedServosSettings, Faults

IDS = (1, 2, 3, 4, 5)
RATE_HZ, BAUD_RATE = 200, 1_000_000
PERIOD_S = 1 / RATE_HZ
BITS_PER_BYTE = 10
INDIRECT_DATA_1 = 224
LOST_EVERY = 101


@dataclass(frozen=True, kw_only=True)
class Run:
    """What the cycles of one client took."""

    read_s: NDArray[np.float64]
    cycle_s: NDArray[np.float64]
    missed: int
    failed: int
    cpu_share: float

    def share_of_cycles(self, count: int) -> float:
        """`count` in percent of the deadlines."""
        return 100 * count / (len(self.read_s) + self.missed)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--seconds", type=float, default=8.0, help="length of each of the four runs (default 8)"
    )
    parser.add_argument(
        "--fifo",
        action="store_true",
        help="with real-time priority, for a computer that does other things too",
    )
    arguments = parser.parse_args()
    seconds = arguments.seconds
    if arguments.fifo:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))  # the servos' process inherits it
    print(
        f"{len(IDS)} servos, {RATE_HZ} Hz, {BAUD_RATE} baud, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} before"
    )
    read_wire_s, write_wire_s = wire_s(protocol.FastStatusPacket), wire_s(None)
    print(f"on the wire alone: {1e3 * read_wire_s:.2f} ms a reading, {1e3 * write_wire_s:.2f} ms the goals")
    with served(lose=False) as port:
        ours = cycles(*nodal_client(port), seconds)
        theirs = {
            name: cycles(*sdk_client(port, fast=fast), seconds)
            for name, fast in (("fast", True), ("plain", False))
        }
    with served(lose=True) as port:
        disturbed = cycles(*nodal_client(port), seconds)
    say("nodal", ours)
    for name, run in theirs.items():
        say(f"dynamixel-sdk, {name} sync read", run)
    say(f"nodal, every {LOST_EVERY}st packet lost", disturbed)
    print(
        yardstick(
            "cycles kept at 200 Hz", ">= 99 %", f"{100 - ours.share_of_cycles(ours.missed):.2f} %",
            met=ours.share_of_cycles(ours.missed) <= 1,
        )
    )  # fmt: skip
    p99_s = float(np.percentile(ours.read_s, 99))
    print(
        yardstick(
            "a reading, p99",
            "<= one period",
            f"{1e3 * p99_s:.2f} of {1e3 * PERIOD_S:g} ms",
            met=p99_s <= PERIOD_S,
        )
    )
    least = min(run.cpu_share for run in theirs.values())
    print(
        yardstick(
            "share of a core", "<= a fifth of dynamixel-sdk's",
            f"{100 * ours.cpu_share:.1f} of {100 * least:.1f} %", met=ours.cpu_share <= least / 5,
        )
    )  # fmt: skip
    print(
        yardstick(
            "readings that failed with every 101st packet lost",
            "0",
            str(disturbed.failed),
            met=disturbed.failed == 0,
        )
    )


def wire_s(answer: type | None) -> float:
    """How long the bytes of a reading, or of the goals, take at BAUD_RATE."""
    if answer is None:
        count = len(protocol.sync_write(GOAL_POSITION.address, dict.fromkeys(IDS, bytes(4))).to_bytes())
    else:
        question = protocol.fast_sync_read(IDS, INDIRECT_DATA_1, feedback.SIZE).to_bytes()
        count = len(question) + 8 + len(IDS) * (feedback.SIZE + 4)
    return count * BITS_PER_BYTE / BAUD_RATE


def say(name: str, run: Run) -> None:
    """One client's line."""
    p50, p99, most = (1e3 * float(np.percentile(run.read_s, part)) for part in (50, 99, 100))
    print(
        f"{name:36} read p50 {p50:5.2f}  p99 {p99:5.2f}  max {most:6.2f} ms   cycle p99 "
        f"{1e3 * float(np.percentile(run.cycle_s, 99)):5.2f} ms   missed {run.missed:3}   failed {run.failed:3}   "
        f"CPU {100 * run.cpu_share:5.1f} %"
    )


def cycles(
    read: Callable[[], bool], write: Callable[[], None], close: Callable[[], None], seconds: float
) -> Run:
    """Read and write at RATE_HZ, on deadlines that are never shifted."""
    read_s, cycle_s, missed, failed = [], [], 0, 0
    try:
        for _ in range(20):
            read()
            write()
        cpu_s, start_s = time.process_time(), time.monotonic()
        deadline = 0
        while deadline < seconds * RATE_HZ:
            begin_s = time.monotonic()
            failed += not read()
            read_s.append(time.monotonic() - begin_s)
            write()
            now_s = time.monotonic()
            cycle_s.append(now_s - begin_s)
            late = int((now_s - start_s) / PERIOD_S) - deadline
            missed += max(0, late)
            deadline += 1 + max(0, late)
            time.sleep(max(0.0, start_s + deadline * PERIOD_S - time.monotonic()))
        cpu_share = (time.process_time() - cpu_s) / (time.monotonic() - start_s)
    finally:
        close()
    return Run(
        read_s=np.array(read_s), cycle_s=np.array(cycle_s), missed=missed, failed=failed, cpu_share=cpu_share
    )


Client = tuple[Callable[[], bool], Callable[[], None], Callable[[], None]]
"""Read everything, and whether that worked; write the goals; close."""


def nodal_client(port: str) -> Client:
    """The project's driver, holding the servos where they are."""
    axes = [
        AxisSettings(name=str(n), id=n, mm_per_rad=5.0, min_mm=-6.0, max_mm=6.0, max_current_ma=800.0)
        for n in IDS
    ]
    drive = TendonActuators(ServoSettings(port=port, tendons=tuple(axes[:-1]), stage=axes[-1]))
    drive.open()
    drive.enable()
    goals_mm = np.zeros(len(axes) - 1)

    def read() -> bool:
        try:
            drive.read()
        except ActuatorError:
            return False
        return True

    return read, lambda: drive.write(goals_mm, 0.0), drive.close


def sdk_client(port: str, *, fast: bool) -> Client:
    """ROBOTIS' own library, on the block that the project's driver has left in the servos."""
    handler, packets = sdk.PortHandler(port), sdk.PacketHandler(2.0)
    handler.openPort()
    handler.setBaudRate(BAUD_RATE)
    for servo in IDS:
        packets.writeTxRx(
            handler,
            servo,
            INDIRECT_ADDRESS_1,
            len(feedback.INDIRECT_ADDRESSES),
            list(feedback.INDIRECT_ADDRESSES),
        )
    reader = sdk.GroupSyncRead(handler, packets, INDIRECT_DATA_1, feedback.SIZE)
    writer = sdk.GroupSyncWrite(handler, packets, GOAL_POSITION.address, GOAL_POSITION.size)
    for servo in IDS:
        reader.addParam(servo)

    def read() -> bool:
        worked = (reader.fastSyncRead() if fast else reader.txRxPacket()) == sdk.COMM_SUCCESS
        return worked and all(reader.getData(servo, INDIRECT_DATA_1, 1) for servo in IDS)

    def write() -> None:
        writer.clearParam()
        for servo in IDS:
            writer.addParam(servo, [0, 8, 0, 0])
        writer.txPacket()

    return read, write, handler.closePort


@contextmanager
def served(*, lose: bool) -> Iterator[str]:
    """Emulated servos in a process of their own; the path of their device."""
    context = multiprocessing.get_context("spawn")
    ready, done = context.Event(), context.Event()
    with tempfile.TemporaryDirectory() as folder:
        link = str(Path(folder) / "servos")
        process = context.Process(target=serve, args=(link, lose, ready, done))
        process.start()
        try:
            if not ready.wait(30):
                raise TimeoutError("the emulated servos did not start within 30 s")
            yield link
        finally:
            done.set()
            process.join()


def serve(link: str, lose: bool, ready: Event, done: Event) -> None:
    """Be the servos until `done`; with `lose`, every LOST_EVERYth instruction reaches nobody."""
    with EmulatedServos(EmulatedServosSettings(link=link, ids=IDS)) as servos:
        if lose:
            servos.set_faults(Faults(unheard=frozenset(range(500, 1_000_000, LOST_EVERY))))
        ready.set()
        done.wait()


if __name__ == "__main__":
    main()
