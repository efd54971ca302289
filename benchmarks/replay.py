"""How fast a log replays, and that it does so to the same bits: `python benchmarks/replay.py [LOG] [--runs N]`.

Without LOG, the short recording of the tests, whose pictures are small; the yardstick asks for 1080p, as `nodal demo` records.
"""

import argparse
from pathlib import Path

from nodal import arithmetic

arithmetic.pin()

from nodal.replay.verification import Verdict, verified  # noqa: E402
from nodal.replay.workers import cores, workers  # noqa: E402

GOLDEN = Path(__file__).parents[1] / "tests" / "data" / "run.mcap"


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
        verdicts += timed
        speeds = sorted(verdict.span_s / verdict.took_s for verdict in timed[1:])
        print(f"{jobs} workers: {speeds[len(speeds) // 2]:.1f} x real time, of {timed[0].span_s:.1f} s")
    counts = ", ".join(f"{key} {tally.compared}" for key, tally in verdicts[0].comparison.topics.items())
    print(f"compared: {counts}")
    print(f"different: {verdicts[0].comparison.different}")
    alike = all(verdict.comparison == verdicts[0].comparison for verdict in verdicts)
    print(f"outcomes of {len(verdicts)} replays: {'all the same' if alike else 'NOT the same'}")


if __name__ == "__main__":
    main()
