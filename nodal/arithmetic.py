"""The same arithmetic on every CPU: the same frames and the same messages give the same bytes.

NumPy, SciPy (through OpenBLAS) and OpenCV (with IPP) look at the CPU when they are loaded, and choose among kernels that
add in different orders or round differently. On x86-64 they are told to stop at AVX2 and FMA (the level x86-64-v3, any Zen
and any Core since Haswell); a lesser CPU keeps what it has, and so does aarch64. docs/arithmetic.md says what was measured.
"""

import os
import sys
import warnings
from collections.abc import Collection, MutableMapping
from pathlib import Path

CPU = Path("/proc/cpuinfo")
LIBRARIES = ("numpy", "scipy", "cv2")

V3 = {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}
"""What x86-64-v3 adds to v2, as Linux names it."""
V4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}
"""What x86-64-v4 adds to v3."""

NUMPY_CHOICES = ("NPY_ENABLE_CPU_FEATURES", "NPY_DISABLE_CPU_FEATURES")
"""NumPy refuses to be told both."""


def pin(environment: MutableMapping[str, str] = os.environ) -> None:
    """Fix the arithmetic of this process and of those that it starts; what the user has set already stays as it is.

    Warns when it is too late for this process, because one of the libraries is loaded.
    """
    user_chose_numpy = any(name in environment for name in NUMPY_CHOICES)
    missing = {
        name: value
        for name, value in settings(_cpu_flags()).items()
        if name not in environment and not (name in NUMPY_CHOICES and user_chose_numpy)
    }
    environment.update(missing)
    if missing and (loaded := [name for name in LIBRARIES if name in sys.modules]):
        warnings.warn(
            f"{', '.join(loaded)} loaded before nodal.arithmetic.pin(): results may depend on the CPU",
            RuntimeWarning,
            stacklevel=2,
        )


def settings(cpu_flags: Collection[str]) -> dict[str, str]:
    """Environment variables that fix the arithmetic on a CPU with these flags."""
    # one thread: matrices are small here, threads for them would only get in the way of the other processes
    chosen = {"OPENBLAS_NUM_THREADS": "1"}
    if V3.issubset(cpu_flags):
        # never on a lesser CPU: OpenBLAS runs what it is told to, and dies of it
        chosen |= {
            "OPENBLAS_CORETYPE": "Haswell",
            "NPY_ENABLE_CPU_FEATURES": "X86_V3",
            "OPENCV_IPP": "avx2",
        }
    if V4.issubset(cpu_flags):
        # not without need: OpenCV prints a warning about a feature that the CPU has not
        chosen["OPENCV_CPU_DISABLE"] = "AVX512-SKX"
    return chosen


def _cpu_flags() -> set[str]:
    """Features of the first CPU, as Linux names them; none on other architectures, which list theirs differently."""
    with CPU.open(encoding="ascii", errors="replace") as lines:
        return next((set(line.split()) for line in lines if line.startswith("flags")), set())
