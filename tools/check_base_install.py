"""Check what `pip install nodal`, without any extra, needs and brings; asks the package registry, takes half a minute.

Run it as `python tools/check_base_install.py`. Every base dependency must come as a wheel for x86-64 and aarch64, in the
versions of requirements.lock. Then the project is built, installed into a fresh environment, weighed, and the embedding
example is run there.
"""

import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "docs" / "examples" / "embedded_controller.py"
MACHINES = ("x86_64", "aarch64")
PYTHONS = ("3.11", "3.12", "3.13")
OLDEST_GLIBC = 28
"""Debian 10, RHEL 8, and everything newer."""


def main() -> int:
    """Check; the exit status of a failed step, or 0."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    with tempfile.TemporaryDirectory() as folder:
        pins = Path(folder) / "pins.txt"
        pins.write_text("\n".join(_pins()), encoding="utf-8")
        for machine in MACHINES:
            for python in PYTHONS:
                _find_wheels(project["dependencies"], pins, machine, python)
        python = _fresh_install(Path(folder), pins)
        return subprocess.run([python, str(EXAMPLE)], check=False, cwd=folder).returncode


def _pins() -> list[str]:
    """Names and versions of requirements.lock, without its hashes: what is not built for a platform has none there."""
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    return re.findall(r"^([\w.-]+==[^\s;]+)", lock, re.MULTILINE)


def _find_wheels(dependencies: list[str], pins: Path, machine: str, python: str) -> None:
    platforms = [f"manylinux_2_{minor}_{machine}" for minor in range(OLDEST_GLIBC, 16, -1)]
    platforms += [f"manylinux2014_{machine}"]
    words = ["--dry-run", "--ignore-installed", "--only-binary=:all:", "--python-version", python]
    for platform in platforms:
        words += ["--platform", platform]
    _pip(
        sys.executable,
        "install",
        *words,
        "--target",
        str(pins.parent / "none"),
        "-c",
        str(pins),
        *dependencies,
    )
    print(f"wheels of every base dependency: {machine}, Python {python}")


def _fresh_install(folder: Path, pins: Path) -> str:
    """A new environment with the built project and its base dependencies; its interpreter."""
    _pip(sys.executable, "wheel", "--no-deps", "--wheel-dir", str(folder), str(ROOT))
    wheel = next(folder.glob("nodal-*.whl"))
    venv.create(folder / "env", with_pip=True)
    python = str(folder / "env" / "bin" / "python")
    packages = next((folder / "env" / "lib").glob("python*/site-packages"))
    before = _megabytes(packages)
    _pip(python, "install", "-c", str(pins), str(wheel))
    print(f"installed: {_megabytes(packages) - before:.0f} MB")
    return python


def _pip(python: str, *words: str) -> None:
    subprocess.run([python, "-m", "pip", "--quiet", "--disable-pip-version-check", *words], check=True)


def _megabytes(folder: Path) -> float:
    return sum(file.lstat().st_size for file in folder.rglob("*") if file.is_file()) / 1e6


if __name__ == "__main__":
    sys.exit(main())
