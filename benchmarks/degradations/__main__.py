"""The degradation table: `python -m benchmarks.degradations [--only NAME,NAME] [--poses N] [--show-silent]`.

Every case and level is photographed by the simulated cameras in seeded poses, and estimated without a prior and with one.
"""

import argparse
import sys
from pathlib import Path

import cv2

from benchmarks.degradations.cases import CASES
from benchmarks.degradations.level import Case
from benchmarks.degradations.running import Outcome, run
from benchmarks.degradations.table import COLUMNS, LEGEND, Row, as_json, as_markdown, as_text, cells
from sensing.method import METHODS
from sensing.settings import MethodName

POSES = 5


def main() -> int:
    """Measure and print."""
    arguments = _arguments()
    if arguments.list:
        for case in CASES:
            print(f"{case.name}: {', '.join(level.name for level in case.levels)}")
        return 0
    cv2.setNumThreads(1)
    for method in arguments.methods:
        rows, everything = [], []
        for case in arguments.only or CASES:
            for level in case.levels:
                outcomes: list[Outcome] = []
                for number in range(arguments.poses):
                    for seen in run(level, method, number):
                        outcomes.append(seen.outcome)
                        if seen.outcome.silent and arguments.show_silent:
                            print(_place(case, level.name, number, seen.outcome))
                rows.append(Row.of(method, case.name, level.name, arguments.poses, outcomes))
                everything += outcomes
                if sys.stderr.isatty() or arguments.progress:
                    print(" ".join(cells(rows[-1])), file=sys.stderr)
        rows.append(Row.of(method, "all", "", arguments.poses, everything))
        print(f"method {method}")
        print(as_text([COLUMNS, *map(cells, rows)]))
        print(LEGEND)
    return 0


def _place(case: Case, level: str, number: int, outcome: Outcome) -> str:
    kind = f"warm, frame {outcome.frame}" if outcome.warm else "cold"
    return f"silent: {case.name}:{level}:{number} ({kind}): nodal points off by up to {outcome.error_mm.max():.2f} mm"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.degradations", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--only", type=_cases, metavar="NAME,NAME", help="only these cases")
    parser.add_argument(
        "--poses", type=int, default=POSES, metavar="N", help=f"of each level (default {POSES})"
    )
    parser.add_argument(
        "--methods", "--method", type=_methods, default=(MethodName.REFINED,), metavar="NAME,NAME"
    )
    parser.add_argument("--list", action="store_true", help="name the cases and their levels")
    parser.add_argument("--show-silent", action="store_true", help="name each silent error")
    parser.add_argument("--progress", action="store_true", help="say each row as soon as it is there")
    return parser.parse_args()


def _cases(text: str) -> tuple[Case, ...]:
    known = {case.name: case for case in CASES}
    try:
        return tuple(known[name.strip()] for name in text.split(","))
    except KeyError as error:
        raise argparse.ArgumentTypeError(f"no case {error}; there are {', '.join(known)}") from None


def _methods(text: str) -> tuple[MethodName, ...]:
    try:
        return tuple(MethodName(name.strip()) for name in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: methods are {', '.join(METHODS)}") from None


if __name__ == "__main__":
    sys.exit(main())
