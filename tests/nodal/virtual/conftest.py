import pytest

from benchmarks.control.paths import CIRCLE
from benchmarks.control.robots import BENCH_ROBOT
from benchmarks.control.scenarios import begin
from nodal.virtual.bench import VirtualBench


@pytest.fixture(scope="session")
def homed_once():
    bench = VirtualBench(BENCH_ROBOT.bench, BENCH_ROBOT.controller, BENCH_ROBOT.robot)
    bench.home()
    return bench


@pytest.fixture
def homed(homed_once):
    """The nominal virtual bench, homed."""
    return homed_once.copy()


@pytest.fixture(scope="session")
def tracking_once(homed_once):
    bench = homed_once.copy()
    begin(bench, CIRCLE)
    bench.run(3.0)
    return bench


@pytest.fixture
def tracking(tracking_once):
    """The nominal virtual bench, whose tip has followed the circle for three seconds."""
    return tracking_once.copy()
