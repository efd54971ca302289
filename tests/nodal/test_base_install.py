"""A base install: the controller in another program, and commands that say what they lack."""

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import controller
from controller import sighting_of
from messaging.errors import InvalidMessageError
from nodal import __main__ as command_line

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "embedded_controller.py"

WITHOUT_THE_REST = """
import runpy, sys
REST = {"zenoh", "cv2", "mcap", "mcap_protobuf", "scipy", "foxglove_schemas_protobuf", "serial", "lz4", "rich"}

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in REST:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
"""


def python(program, *words):
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def test_the_example_needs_neither_cameras_nor_bus_nor_recordings_nor_serial_ports():
    done = python(WITHOUT_THE_REST + "runpy.run_path(sys.argv[1], run_name='__main__')", str(EXAMPLE))

    assert done.returncode == 0, done.stderr
    mode, _, rest = done.stdout.partition(": the tip stands ")
    assert mode == "tracking"
    assert float(rest.split()[0]) < 0.1


def test_importing_the_controller_brings_nothing_that_a_bench_alone_needs():
    program = (
        "import sys, controller\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules} - set(sys.stdlib_module_names)))"
    )
    brought = set(python(program).stdout.split())

    assert {"controller", "numpy"} <= brought
    assert not brought & {
        "zenoh",
        "cv2",
        "mcap",
        "mcap_protobuf",
        "scipy",
        "foxglove_schemas_protobuf",
        "serial",
    }
    assert not brought & {"nodal", "sensing", "recordings"}


def test_everything_that_the_controller_offers_is_there():
    assert [name for name in controller.__all__ if not hasattr(controller, name)] == []


@pytest.mark.parametrize(
    ("words", "missing"),
    [
        (["control", "--config", "simulated"], "nodal control"),
        (["demo"], "nodal demo"),
        (["estimate", "--calibration", "rig.json", "--image", "left=a.jpg"], "nodal estimate"),
        (["do", "status", "--config", "simulated"], "nodal do"),
    ],
)
def test_a_command_that_needs_the_bench_says_so_in_one_line(words, missing):
    program = WITHOUT_THE_REST + "from nodal.__main__ import main\nsys.exit(main(sys.argv[1:]))"
    done = python(program, *words)

    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("nodal: error: there is no ")
    assert f"{missing} needs the bench extra: pip install 'nodal[bench]'" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_modules_of_the_bench_are_those_of_its_extra():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extra = {re.split(r"[<>=]", one)[0] for one in project["optional-dependencies"]["bench"]}
    brought = {
        module
        for module, distributions in metadata.packages_distributions().items()
        if extra & {name.lower() for name in distributions}
    }

    assert {
        name for name in brought if name.isidentifier() and not name.startswith("_")
    } == command_line.BENCH_MODULES


def test_a_module_that_no_extra_brings_is_not_explained_away(monkeypatch):
    def absent(_):
        raise ModuleNotFoundError("No module named 'moon'", name="moon")

    monkeypatch.setattr(command_line, "_parser", absent)
    with pytest.raises(ModuleNotFoundError, match="moon"):
        command_line.main(["demo"])


def test_points_of_another_program_become_a_sighting():
    seen = sighting_of(("tip",), [80.0], [[1.0, 2.0, 83.0]], age_s=0.01, standard_deviation_mm=0.2)

    assert seen.age_s == 0.01
    assert seen.shape.trusted
    assert np.array_equal(seen.shape.node_mm, [[1.0, 2.0, 83.0]])
    assert np.allclose(seen.shape.node_covariance_mm2, 0.04 * np.eye(3))
    with pytest.raises(InvalidMessageError, match="node_mm"):
        sighting_of(("tip",), [80.0], [[np.nan, 2.0, 83.0]], age_s=0.01, standard_deviation_mm=0.2)
    for never in (np.nan, np.inf):
        with pytest.raises(InvalidMessageError, match="the age must be finite"):
            sighting_of(("tip",), [80.0], [[1.0, 2.0, 83.0]], age_s=never, standard_deviation_mm=0.2)
