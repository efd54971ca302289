"""Every law over seeded random benches in virtual time, open loop beside it: `python -m benchmarks.control`."""

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault(
    "OPENBLAS_NUM_THREADS", "1"
)  # before numpy comes: small matrices, and a process for each core

from benchmarks.control.running import OPEN_LOOP, Job, Result, law_name, run_all
from benchmarks.control.scenarios import SCENARIOS
from benchmarks.control.table import HEAD, LEGEND, hardness, row, yardsticks
from controller.laws import law_names
from nodal.errors import CommandError
from nodal.replay.request import changes_in

BENCHES, QUICK_BENCHES = 4, 2
QUICK_SCENARIOS = ("circle", "step 10 mm", "steady state", "push", "gains +30 %", "delay 100 ms")


def main(words: Sequence[str] | None = None) -> int:
    """Measure and print; `words` are those of the command line unless given."""
    arguments = _arguments(words)
    laws = (*arguments.laws, OPEN_LOOP)
    seeds = range(arguments.seed, arguments.seed + arguments.benches)
    print(f"{arguments.benches} benches from seed {arguments.seed}", HEAD, sep="\n", flush=True)
    start_s = time.perf_counter()
    results: list[Result] = []
    rows = [
        (scenario, law)
        for scenario in SCENARIOS
        for law in laws
        if scenario.name in arguments.scenarios and not (law == OPEN_LOOP and scenario.sensing_only)
    ]
    tuning = {law: arguments.tuning if law in arguments.laws else {} for law in laws}
    jobs = [
        Job(seed=seed, law=law, scenario=scenario.name, tuning=tuning[law])
        for scenario, law in rows
        for seed in seeds
    ]
    for result in run_all(jobs, arguments.jobs):
        results.append(result)
        if result.seed == seeds[-1]:
            print(row(result.scenario, result.law, results[-len(seeds) :]), flush=True)
    names = [law_name(law) for law in laws]
    print(LEGEND, "", *hardness(results, names[-1]), sep="\n")
    for law in names[:-1]:
        print(*yardsticks(results, law, names[-1]), sep="\n")
    for result in results:
        if result.figures.fault:
            print(f"fault: {result.scenario}, {result.law}, bench {result.seed}: {result.figures.fault}")
    simulated_s, cpu_s = sum(r.simulated_s for r in results), sum(r.cpu_s for r in results)
    print(
        f"{simulated_s:.0f} s on benches took {cpu_s:.0f} s of processors, {simulated_s / max(cpu_s, 1e-9):.1f} x faster than "
        f"real time; "
        f"{time.perf_counter() - start_s:.0f} s by the clock with {arguments.jobs} processes"
    )
    return 0


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.control", description=__doc__)
    names = tuple(scenario.name for scenario in SCENARIOS)
    few = f"{QUICK_BENCHES} benches, and of the scenarios only {', '.join(QUICK_SCENARIOS)}"
    which = f"of {', '.join(names)} (default: all)"
    processes = os.cpu_count() or 1
    parser.add_argument("--benches", type=_positive, metavar="N", help=f"how many (default {BENCHES})")
    parser.add_argument(
        "--seed", type=_positive, default=1, metavar="N", help="of the first bench (default 1)"
    )
    parser.add_argument(
        "--laws",
        type=_list,
        default=law_names(),
        metavar="NAME,FILE",
        help=f"of {', '.join(law_names())}, or law files (default: those that come with the controller)",
    )
    parser.add_argument(
        "--tuning",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a setting of the one law in --laws; its defaults otherwise",
    )
    parser.add_argument("--scenarios", type=_list, metavar="NAME,NAME", help=which.replace("%", "%%"))
    parser.add_argument(
        "--jobs", type=_positive, default=processes, metavar="N", help=f"processes (default {processes})"
    )
    parser.add_argument("--quick", action="store_true", help=few.replace("%", "%%"))
    arguments = parser.parse_args(words)
    arguments.benches = arguments.benches or (QUICK_BENCHES if arguments.quick else BENCHES)
    arguments.scenarios = arguments.scenarios or (QUICK_SCENARIOS if arguments.quick else names)
    if unknown := [name for name in arguments.scenarios if name not in names]:
        parser.error(f"no scenario {', '.join(unknown)}; there are {', '.join(names)}")
    if unknown := [law for law in arguments.laws if law not in law_names() and not Path(law).is_file()]:
        parser.error(f"no law or file {', '.join(unknown)}; laws are {', '.join(law_names())}")
    if arguments.tuning and len(arguments.laws) != 1:
        parser.error(f"--tuning is of one law; --laws has {', '.join(arguments.laws)}")
    try:
        arguments.tuning = changes_in([f"controller.tuning.{word}" for word in arguments.tuning])
    except CommandError as error:
        parser.error(str(error))
    arguments.tuning = arguments.tuning.get("controller", {}).get("tuning", {})
    return arguments


def _list(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number from 1")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
