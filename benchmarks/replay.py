"""How fast a log replays, and that it does so to the same bits: `python benchmarks/replay.py [LOG] [--runs N]`.

Without LOG, the short recording of the tests, whose pictures are small; the yardstick asks for 1080p, as `nodal demo` records.
"""

import argparse
import time
from concurrent.futures import Executor
from itertools import repeat
from pathlib import Path
from statistics import median

from nodal import arithmetic

arithmetic.pin()

from nodal.bench_file import recorded_bench  # noqa: E402
from nodal.replay.script import sensing_stretches, whole  # noqa: E402
from nodal.replay.verification import Verdict, verified, verify_stretch  # noqa: E402
from nodal.replay.workers import cores, workers  # noqa: E402
from recordings import Log  # noqa: E402

GOLDEN = Path(__file__).parents[1] / "tests" / "data" / "run.mcap"


def _estimates_alone_s(path: Path, executor: Executor) -> float:
    began_s = time.monotonic()
    log = Log(path)
    bench = recorded_bench(path, log.attachments, {})
    sensed, _ = whole(log)
    list(executor.map(verify_stretch, sensing_stretches(sensed), repeat(bench)))
    return time.monotonic() - began_s


def main() -> None:
    """Replay with one worker and with one for each core, so many times each, and compare the outcomes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", nargs="?", type=Path, default=GOLDEN)
    parser.add_argument(
        "--runs", type=int, default=2, help="how often with each number of workers (default 2)"
    )
    arguments = parser.parse_args()
    verdicts: list[Verdict] = []
    for jobs in (1, cores()):
        with workers(jobs, None) as executor:
            # the first brings the workers up
            timed = list(verified([arguments.log] * (arguments.runs + 1), executor, logs_ahead=0))
            alone_s = [_estimates_alone_s(arguments.log, executor) for _ in range(arguments.runs)]
        verdicts += timed
        span_s = timed[0].span_s
        everything_s = median(verdict.took_s for verdict in timed[1:])
        print(
            f"{jobs} workers: estimates {span_s / median(alone_s):.1f} x real time, "
            f"estimates and commands {span_s / everything_s:.1f} x, of {span_s:.1f} s"
        )
    counts = ", ".join(f"{key} {tally.compared}" for key, tally in verdicts[0].comparison.topics.items())
    print(f"compared: {counts}")
    print(f"different: {verdicts[0].comparison.different}")
    alike = all(verdict.comparison == verdicts[0].comparison for verdict in verdicts)
    print(f"outcomes of {len(verdicts)} replays: {'all the same' if alike else 'NOT the same'}")


if __name__ == "__main__":
    main()
