"""The table: a row for each scenario and law, and what the yardsticks say."""

from collections.abc import Sequence

import numpy as np

from benchmarks.control.robots import BENCH_ROBOT
from benchmarks.control.running import Result
from benchmarks.control.scenarios import SCENARIOS
from benchmarks.yardstick import yardstick

BENCH_CIRCLE = "circle"
HEAD = (
    f"{'scenario':<16}{'law':<16}{'RMS mm':>8}{'worst':>8}{'peak mm':>9}{'settle s':>10}{'worst':>7}"
    f"{'over %':>8}{'held %':>8}{'slack %':>9}{'pull N':>8}{'limits':>8}{'unstable':>10}{'faults':>8}"
)
LEGEND = """
RMS: of the tip's distance from where it should be, median over the benches, and of the worst bench; peak: the largest
distance on any bench; settle: until the tip stays within 0.5 mm of its goal, median and worst; over: largest overshoot;
held: share of the time in which the controller did not lead the tip; slack: share of the time in which a tendon was
slack; pull: the highest tension; limits: commands beyond travel or rate; unstable, faults: benches."""


def row(scenario: str, law: str, results: Sequence[Result]) -> str:
    """One line."""
    figures = [result.figures for result in results]
    rms, peak = [f.rms_mm for f in figures], max(f.worst_mm for f in figures)
    settle, over = [f.settle_s for f in figures], max(f.overshoot_percent for f in figures)
    stepped = not np.isnan(settle).any()
    return (
        f"{scenario:<16}{law:<16}{np.median(rms):8.3f}{max(rms):8.3f}{peak:9.2f}"
        + (f"{np.median(settle):10.2f}{max(settle):7.2f}{over:8.1f}" if stepped else " " * 25)
        + f"{100 * np.mean([f.held for f in figures]):8.1f}{100 * np.mean([f.slack for f in figures]):9.1f}"
        + f"{max(f.tension_N for f in figures):8.1f}{sum(f.violations for f in figures):8d}{sum(f.unstable for f in figures):10d}"
        + f"{sum(bool(f.fault) for f in figures):8d}"
    )


def hardness(results: Sequence[Result], open_loop: str) -> list[str]:
    """Whether the benches are as far from the nominal model as real robots are."""
    circles = [r.figures.rms_mm for r in results if (r.scenario, r.law) == (BENCH_CIRCLE, open_loop)]
    if not circles:
        return []
    share = 100 * min(circles) / BENCH_ROBOT.robot.length_mm
    name = "open loop misses the circle on the kindest bench, of the robot's length"
    return [yardstick(name, ">= 5 %", f"{share:.1f} % ({min(circles):.2f} mm)", met=share >= 5)]


def yardsticks(results: Sequence[Result], law: str, open_loop: str) -> list[str]:
    """What was promised against what was measured."""

    def of(scenario: str, kind: str = law) -> list[Result]:
        return [r for r in results if (r.scenario, r.law) == (scenario, kind)]

    lines = []
    if calm := [r.figures.rms_mm for r in of(BENCH_CIRCLE)]:
        median = float(np.median(calm))
        lines.append(_most("circle of 15 mm at 0.1 Hz, median bench, RMS", median, 0.4))
        if other := [r.figures.rms_mm for r in of(BENCH_CIRCLE, open_loop)]:
            ratio = float(np.median(other)) / median
            lines.append(
                yardstick("circle beside open loop", ">= 10 x better", f"{ratio:.1f} x", met=ratio >= 10)
            )
    disturbed = [r for s in SCENARIOS if s.disturbance for r in of(s.name)]
    if disturbed:
        worst = max(disturbed, key=lambda r: r.figures.rms_mm)
        name = f"worst bench of all disturbances ({worst.scenario}, bench {worst.seed}), RMS"
        lines.append(_most(name, worst.figures.rms_mm, 1.2))
    if still := [r.figures.rms_mm for r in of("steady state")]:
        lines.append(_most("steady state, worst bench, RMS", max(still), 0.1))
    if steps := [r.figures for r in of("step 10 mm")]:
        slowest, highest = max(f.settle_s for f in steps), max(f.overshoot_percent for f in steps)
        lines.append(
            yardstick(
                "10 mm step settles to 0.5 mm, worst bench", "<= 1 s", f"{slowest:.2f} s", met=slowest <= 1
            )
        )
        lines.append(
            yardstick("10 mm step overshoots, worst bench", "<= 10 %", f"{highest:.1f} %", met=highest <= 10)
        )
    every = [r.figures for r in results if r.law == law]
    wrong = sum(f.unstable or bool(f.violations) or bool(f.fault) for f in every)
    lines.append(yardstick("runs unstable, beyond limits or at fault", "none", f"{wrong}", met=not wrong))
    return [f"{law}: {line}" for line in lines]


def _most(name: str, measured_mm: float, most_mm: float) -> str:
    return yardstick(name, f"<= {most_mm:g} mm", f"{measured_mm:.3f} mm", met=measured_mm <= most_mm)
