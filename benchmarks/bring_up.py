"""From nothing to a running bench, as a user gets there: `python -m benchmarks.bring_up [--seeds N ...] [--keep DIR] [--json]`.

`nodal new --simulated` makes a bench whose cameras, servos and robot are not what its bench file believes; then each command
of the guide is run as it is printed there, and last the demo, recorded: homing, a circle, a hold. No command is told anything
true. The truth only judges, here: the calibrated cameras against those of `true-rig.json`, the nodal points against the
recorded truth, whose robot frame is the true one, so that errors of the calibrated base are part of the figure.

A command that fails ends its bench's row, with what it printed.
"""

import argparse
import dataclasses
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bring_up_truth import camera_errors, robot_figures, robot_frame_error
from messaging.errors import NodalError

LONGEST_S = 900.0
LAST_LINES = 25


@dataclasses.dataclass(frozen=True, kw_only=True)
class Step:
    """One command that was run."""

    name: str
    took_s: float
    status: int
    figures: dict[str, float]
    said: str = ""
    """Its last words, of one that failed."""


class FailedError(Exception):
    """A command did not do what it should."""


class BringUp:
    """One bench, from its box to the end of the demo."""

    def __init__(self, folder: Path, seed: int, demo_s: float) -> None:
        self._folder, self._seed, self._demo_s = folder, seed, demo_s
        self.steps: list[Step] = []

    def run(self) -> None:
        """Every command in turn, until one fails."""
        folder, bench = self._folder, self._folder / "bench.toml"
        config = ["--config", str(bench)]
        try:
            self._do("new", ["new", str(folder), "--simulated", "--seed", str(self._seed)])
            self._do("cameras look", ["cameras", "look", *config, "--out", str(folder / "look")])
            self._do("calibrate cameras", ["calibrate", "cameras", *config])
            self._judge(camera_errors(folder))
            self._do("calibrate base", ["calibrate", "base", *config])
            self._judge(robot_frame_error(folder))
            self._do("calibrate background", ["calibrate", "background", *config])
            self._do("calibrate robot", ["calibrate", "robot", *config])
            self._judge(robot_figures(folder))
            demo = ["demo", *config, "--duration", str(self._demo_s), "--out", str(folder / "demo"), "--json"]
            self._judge(_demo_figures(json.loads(self._do("demo", demo))))
        except FailedError:
            return
        except NodalError as error:
            # it said that it was done, and left nothing that can be read
            self.steps[-1] = dataclasses.replace(self.steps[-1], status=1, said=str(error))

    @property
    def succeeded(self) -> bool:
        """Whether every command did what it should."""
        return bool(self.steps) and all(step.status == 0 for step in self.steps)

    def _do(self, name: str, words: list[str]) -> str:
        """What it prints on stdout; raises FailedError."""
        print(f"  {name} ...", end="", file=sys.stderr, flush=True)
        began_s = time.monotonic()
        try:
            done = subprocess.run(
                [sys.executable, "-m", "nodal", *words],
                capture_output=True,
                text=True,
                stdin=subprocess.DEVNULL,
                timeout=LONGEST_S,
                check=False,
            )
            status, output, said = done.returncode, done.stdout, f"{done.stdout}{done.stderr}"
        except subprocess.TimeoutExpired:
            status, output, said = -1, "", f"not done within {LONGEST_S:g} s"
        took_s = time.monotonic() - began_s
        print(f" {took_s:.1f} s", file=sys.stderr, flush=True)
        last_words = "" if status == 0 else "\n".join(said.splitlines()[-LAST_LINES:])
        self.steps.append(Step(name=name, took_s=took_s, status=status, figures={}, said=last_words))
        if status != 0:
            raise FailedError
        return output

    def _judge(self, figures: dict[str, float]) -> None:
        """These are the last command's."""
        self.steps[-1] = dataclasses.replace(self.steps[-1], figures=figures)


def _demo_figures(summary: dict[str, Any]) -> dict[str, float]:
    figures = {
        "nodes mean mm": summary["node_error_mm"]["mean"],
        "nodes p95 mm": summary["node_error_mm"]["p95"],
        "tip mean mm": summary["tip_error_mm"]["mean"],
        "circle RMS mm": summary["tracking_error_mm"]["rms"],
        "hold RMS mm": summary["tracking_error_mm"]["steady"],
        "open loop RMS mm": summary["open_loop_error_mm"]["rms"],
        "flagged": summary["flagged"],
        "estimates": summary["estimates"],
    }
    return {name: value for name, value in figures.items() if value is not None}


@contextmanager
def _folder_for(keep: Path | None) -> Iterator[Path]:
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
        yield keep
        return
    with tempfile.TemporaryDirectory(prefix="bring-up-") as folder:
        yield Path(folder)


def _table(seed: int, bring_up: BringUp) -> Iterator[str]:
    yield f"bench {seed}"
    for step in bring_up.steps:
        figures = ", ".join(f"{name} {value:.3g}" for name, value in step.figures.items())
        failed = "" if step.status == 0 else f"FAILED with status {step.status}"
        yield f"  {step.name:<22} {step.took_s:6.1f} s  {failed}{figures}"
        if step.said:
            yield "    | " + step.said.replace("\n", "\n    | ")
    yield f"  {'all':<22} {sum(step.took_s for step in bring_up.steps):6.1f} s"


def main() -> int:
    """Bring benches up one after another; 1 when one of them did not come up."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--seeds", type=int, nargs="+", default=[1], metavar="N", help="which benches (default 1)"
    )
    parser.add_argument(
        "--keep", type=Path, metavar="DIR", help="leave everything there, in a folder for each bench"
    )
    parser.add_argument(
        "--demo", type=float, default=30.0, metavar="S", help="length of the demo (default 30)"
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object on stdout")
    arguments = parser.parse_args()
    benches = {}
    with _folder_for(arguments.keep) as folder:
        for seed in arguments.seeds:
            print(f"bench {seed}", file=sys.stderr)
            benches[seed] = BringUp(folder / f"bench-{seed}", seed, arguments.demo)
            benches[seed].run()
    if arguments.json:
        print(
            json.dumps({seed: [dataclasses.asdict(step) for step in b.steps] for seed, b in benches.items()})
        )
    else:
        print("\n".join(line for seed, bench in benches.items() for line in _table(seed, bench)))
        nodes = [b.steps[-1].figures["nodes mean mm"] for b in benches.values() if b.succeeded]
        if len(nodes) > 1:
            print(
                f"nodes mean mm over {len(nodes)} benches: median {np.median(nodes):.3g}, most {max(nodes):.3g}"
            )
    return 0 if all(bench.succeeded for bench in benches.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
