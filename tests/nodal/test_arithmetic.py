"""The arithmetic is fixed before the libraries that choose it are loaded, and the user's own choice stays."""

import json
import os
import re
import subprocess
import sys

import pytest

from nodal import arithmetic

V2 = {"sse4_2", "ssse3", "popcnt", "cx16"}
LEVELS = {"v2": V2, "v3": V2 | arithmetic.V3, "v4": V2 | arithmetic.V3 | arithmetic.V4, "aarch64": set()}

FEATURES = """
import json, os
from nodal.__main__ import main
try:
    main(["--version"])
except SystemExit:
    pass
import cv2, numpy, scipy.linalg
from numpy._core._multiarray_umath import __cpu_features__, __cpu_dispatch__
print(json.dumps({
    "numpy": [name for name in __cpu_dispatch__ if __cpu_features__[name]],
    "opencv": cv2.getCPUFeaturesLine(),
    "ipp": cv2.ipp.getIppVersion(),
    "blas": os.environ.get("OPENBLAS_CORETYPE"),
}))
"""

PRODUCT = """
from nodal.arithmetic import pin
pin()
import hashlib, numpy as np
matrix = np.random.default_rng(5).normal(size=(60, 60))
print(hashlib.sha256((matrix @ matrix).tobytes()).hexdigest())
"""


def python(program, **environment):
    """What a Python with no settings but these prints, warnings being errors."""
    bare = {
        name: value for name, value in os.environ.items() if name not in arithmetic.settings(LEVELS["v4"])
    }
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env=bare | environment,
    )
    assert not run.stderr
    return run.stdout.splitlines()[-1]


@pytest.fixture(params=LEVELS)
def cpu(request, tmp_path, monkeypatch):
    """A CPU of each level."""
    monkeypatch.setattr(arithmetic, "CPU", tmp_path / "cpuinfo")
    arithmetic.CPU.write_text(
        f"processor\t: 0\nflags\t\t: {' '.join(LEVELS[request.param])}\n"
        if LEVELS[request.param]
        else "processor\t: 0\nFeatures\t: fp asimd\n"
    )
    return request.param


@pytest.fixture
def nothing_loaded(monkeypatch):
    monkeypatch.setattr(arithmetic, "LIBRARIES", ())


def test_each_level_is_told_what_it_can_do_and_no_more(cpu, nothing_loaded):
    environment = {}
    arithmetic.pin(environment)
    told = {
        "v2": {"OPENBLAS_NUM_THREADS"},
        "v3": {"OPENBLAS_NUM_THREADS", "OPENBLAS_CORETYPE", "NPY_ENABLE_CPU_FEATURES", "OPENCV_IPP"},
    }
    told |= {"aarch64": told["v2"], "v4": told["v3"] | {"OPENCV_CPU_DISABLE"}}
    assert set(environment) == told[cpu]


def test_what_the_user_set_stays(cpu, nothing_loaded):
    own = {"OPENBLAS_CORETYPE": "Zen", "OPENBLAS_NUM_THREADS": "2", "NPY_DISABLE_CPU_FEATURES": "X86_V4"}
    environment = dict(own)
    arithmetic.pin(environment)
    assert environment.items() >= own.items()
    assert "NPY_ENABLE_CPU_FEATURES" not in environment


def test_too_late_is_said():
    import numpy as np  # noqa: F401, PLC0415

    with pytest.warns(RuntimeWarning, match=r"numpy.* loaded before"):
        arithmetic.pin({})


def test_again_is_not_too_late(recwarn):
    arithmetic.pin(os.environ)
    assert not recwarn


def test_the_command_has_its_libraries_stop_at_v3():
    found = json.loads(python(FEATURES))
    assert set(found["numpy"]) <= {"X86_V3", "NEON", "ASIMD", "ASIMDHP", "ASIMDDP", "ASIMDFHM", "SVE"}
    # a question mark says that OpenCV has code for a feature and does not use it
    assert not re.search(r"AVX512-SKX(?!\?)", found["opencv"])
    if found["blas"]:
        assert found["blas"] == "Haswell"
        assert "AVX2" in found["ipp"]


@pytest.mark.skipif(
    "OPENBLAS_CORETYPE" not in os.environ, reason="this CPU has no choice of kernels: it is below x86-64-v3"
)
def test_kernels_are_told_apart_by_their_bytes():
    """What all of this is for: another kernel's product of the same matrices has other bytes."""
    pinned = python(PRODUCT)
    assert python(PRODUCT, OPENBLAS_CORETYPE="Haswell") == pinned
    assert python(PRODUCT, OPENBLAS_CORETYPE="Nehalem") != pinned
