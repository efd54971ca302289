"""The degradation table: `python -m benchmarks.degradations [--only NAME,NAME] [--poses N] [--show-silent]`.

Every case and level is photographed by the simulated cameras in seeded poses, and estimated without a prior and with one.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2

from benchmarks.degradations.cases import CASES
from benchmarks.degradations.level import Case, Level
from benchmarks.degradations.looking import draw, errors_in_words, in_words
from benchmarks.degradations.running import Outcome, prior, run
from benchmarks.degradations.table import COLUMNS, LEGEND, Row, as_json, as_line, as_markdown, cells
from sensing.method import METHODS
from sensing.settings import MethodName

POSES = 5


def main(words: Sequence[str] | None = None) -> int:
    """Measure and print; `words` are those of the command line unless given."""
    arguments = _arguments(words)
    cv2.setNumThreads(1)
    cases = arguments.only or CASES
    if arguments.list:
        for case in cases:
            print(f"{case.name}: {', '.join(level.name for level in case.levels)}")
        return 0
    if arguments.reproduce:
        for method in arguments.methods:
            _reproduce(arguments.reproduce, method, arguments.figures)
        return 0
    rows = [
        row
        for method in arguments.methods
        for row in _measure(cases, method, arguments.poses, arguments.show_silent)
    ]
    print(LEGEND)
    for path, text in ((arguments.json, as_json(rows)), (arguments.markdown, as_markdown(rows))):
        if path:
            path.write_text(text, encoding="utf-8")
    return 0


def _measure(cases: tuple[Case, ...], method: MethodName, poses: int, show_silent: bool) -> list[Row]:
    """Rows of all levels and one of all together, each printed as soon as it is there."""
    widths = (
        max(len(case.name) for case in cases),
        max(len(level.name) for case in cases for level in case.levels),
    )
    print(f"method {method}", as_line(COLUMNS, *widths), sep="\n", flush=True)
    rows: list[Row] = []
    everything: list[Outcome] = []
    silent: list[str] = []
    for case in cases:
        for level in case.levels:
            outcomes: list[Outcome] = []
            for number in range(poses):
                found = [seen.outcome for seen in run(level, method, number)]
                outcomes += found
                if any(outcome.silent for outcome in found):
                    before = prior(level, method, number).outcome
                    silent.append(
                        f"silent: {case.name}:{level.name}:{number} {errors_in_words([before, *found])}"
                    )
            rows.append(Row.of(method, case.name, level.name, poses, outcomes))
            print(as_line(cells(rows[-1]), *widths), flush=True)
            everything += outcomes
    rows.append(Row.of(method, "all", "", poses, everything))
    print(as_line(cells(rows[-1]), *widths))
    if show_silent:
        print(*silent, sep="\n")
    return rows


def _reproduce(place: tuple[str, Level, int], method: MethodName, folder: Path | None) -> None:
    case, level, number = place
    for seen in (prior(level, method, number), *run(level, method, number)):
        print(f"{method} {case}:{level.name}:{number} {in_words(seen.outcome)}")
        if folder:
            draw(folder / f"{method}-{seen.outcome.start}", level, seen)


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.degradations", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--list", action="store_true", help="name the cases and their levels")
    parser.add_argument("--only", type=_cases, metavar="CASE,CASE", help="only these cases")
    parser.add_argument(
        "--poses", type=_positive, default=POSES, metavar="N", help=f"poses of each level (default {POSES})"
    )
    parser.add_argument(
        "--methods",
        "--method",
        type=_methods,
        default=(MethodName.REFINED,),
        metavar="NAME,NAME",
        help=f"ways to a shape, of {', '.join(METHODS)} (default {MethodName.REFINED})",
    )
    parser.add_argument("--show-silent", action="store_true", help="name each silent error")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows here, too")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the table here, too")
    parser.add_argument(
        "--reproduce",
        type=_place,
        metavar="CASE:LEVEL:NUMBER",
        help="only this pose, as --show-silent names it",
    )
    parser.add_argument(
        "--figures",
        type=Path,
        metavar="DIR",
        help="draw what --reproduce finds, and keep its pictures and calibration",
    )
    return parser.parse_args(words)


def _cases(text: str) -> tuple[Case, ...]:
    return tuple(_case(name.strip()) for name in text.split(","))


def _case(name: str) -> Case:
    found = [case for case in CASES if case.name == name]
    if not found:
        raise argparse.ArgumentTypeError(
            f"no case {name!r}; there are {', '.join(case.name for case in CASES)}"
        )
    return found[0]


def _place(text: str) -> tuple[str, Level, int]:
    name, _, rest = text.partition(":")
    level_name, _, number = rest.rpartition(":")  # levels may be called 4:2:2
    case = _case(name)
    levels = [level for level in case.levels if level.name == level_name]
    if not (levels and number.isdecimal()):
        names = ", ".join(level.name for level in case.levels)
        raise argparse.ArgumentTypeError(f"{text!r} is not CASE:LEVEL:NUMBER; levels of {name} are {names}")
    return name, levels[0], int(number)


def _methods(text: str) -> tuple[MethodName, ...]:
    try:
        return tuple(MethodName(name.strip()) for name in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: methods are {', '.join(METHODS)}") from None


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of poses; it must be 1 or more")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
