"""One run: a bench, a law, a scenario. And all of them, in several processes."""

import dataclasses
import logging
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.control.figures import Figures
from benchmarks.control.robots import Robot
from benchmarks.control.scenarios import SCENARIOS, Build, tuned
from controller.loop import Loop
from controller.plant import Plant
from controller.settings import ControllerSettings
from nodal.toml_file import Table
from nodal.virtual.bench import VirtualBench
from nodal.virtual.errors import VirtualBenchError
from nodal.virtual.random_bench import random_bench

OPEN_LOOP = str(Path(__file__).with_name("open_loop.py"))
NOT_RUN = Figures(
    rms_mm=np.inf, worst_mm=np.inf, held=1.0, violations=0, slack=0.0, unstable=False, fault="not run"
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Job:
    """A law on one bench in one scenario."""

    seed: int
    law: str
    scenario: str
    tuning: Table = dataclasses.field(default_factory=dict)
    """The law's own settings, where they are not its defaults."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Result:
    """What came of a job."""

    seed: int
    law: str
    scenario: str
    figures: Figures
    simulated_s: float
    cpu_s: float


def controlled_by(law: str, tuning: Table, controller: ControllerSettings) -> ControllerSettings:
    """The settings with a law by its name, or by the path of its file, and with that law's own settings."""
    named = {"law_file": law} if law.endswith(".py") else {"law": law}
    return msgspec.structs.replace(controller, **named, tuning=tuning)


def law_name(law: str) -> str:
    """What the table calls it."""
    return Path(law).stem


def run(job: Job) -> Result:
    """Home the bench and play the scenario; a bench that does not get that far is a fault of that run."""
    logging.getLogger("controller").setLevel(logging.ERROR)
    scenario = next(scenario for scenario in SCENARIOS if scenario.name == job.scenario)
    robot = scenario.robot
    simulated_s = cpu_s = 0.0
    try:
        bench = _homed(job.seed, robot, scenario.build).copy()
        controller = tuned(controlled_by(job.law, job.tuning, robot.controller), bench.settings)
        bench.hand_over(Loop(controller, robot.robot))
        begun_s, started_s = bench.now_s, time.process_time()
        figures = scenario.play(bench, Plant.of(controller, robot.robot).limits)
        simulated_s, cpu_s = bench.now_s - begun_s, time.process_time() - started_s
    except VirtualBenchError as error:
        figures = dataclasses.replace(NOT_RUN, fault=str(error))
    return Result(
        seed=job.seed,
        law=law_name(job.law),
        scenario=scenario.name,
        figures=figures,
        simulated_s=simulated_s,
        cpu_s=cpu_s,
    )


@lru_cache(maxsize=64)
def _homed(seed: int, robot: Robot, build: Build) -> VirtualBench:
    """A bench that many runs begin with, for homing is led by one law, whichever follows; raises VirtualBenchError when it
    cannot be homed.
    """
    settings = build(random_bench(seed, robot.bench))
    bench = VirtualBench(settings, tuned(robot.controller, settings), robot.robot)
    bench.home()
    return bench


def run_all(jobs: Sequence[Job], processes: int) -> Iterator[Result]:
    """Results in the order of the jobs."""
    if processes == 1:
        yield from map(run, jobs)
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        yield from pool.map(run, jobs)
