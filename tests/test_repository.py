"""What holds for the repository as a whole."""

import re
import tomllib
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]
LOCKS = ("requirements.lock", "requirements-dev.lock")
SOURCES = [
    file
    for room in ("messaging", "drivers", "sensing", "controller", "recordings", "calibration", "nodal")
    for file in sorted((REPOSITORY / room).rglob("*.py"))
    if "generated" not in file.parts
]


@pytest.mark.parametrize("lock", LOCKS)
def test_a_lock_file_pins_with_hashes_and_names_no_registry(lock):
    text = (REPOSITORY / lock).read_text(encoding="utf-8")
    lines = [line.rstrip(" \\") for line in text.splitlines() if line and not line.lstrip().startswith("#")]
    pins = [line for line in lines if not line[0].isspace()]

    assert "://" not in text
    assert pins
    # options, among them those that name an address, are neither pins nor hashes
    assert all(re.fullmatch(r"[a-zA-Z0-9_.-]+(\[.*\])?==[^\s;]+( ; (?!.*--).*)?", pin) for pin in pins)
    assert all(re.fullmatch(r" +--hash=sha256:[0-9a-f]{64}", line) for line in lines if line not in pins)
    assert text.count("--hash=sha256:") >= len(pins)


def test_the_development_lock_holds_every_pin_of_the_other():
    base, development = (
        set(re.findall(r"^(\S+==\S+)", (REPOSITORY / lock).read_text(encoding="utf-8"), re.MULTILINE))
        for lock in LOCKS
    )

    assert base <= development


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(REPOSITORY)))
def test_a_source_file_can_be_read_in_one_sitting(file):
    assert len(file.read_text(encoding="utf-8").splitlines()) <= 400


def test_every_room_is_in_the_wheel():
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))

    packages = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]

    assert sorted(packages) == sorted({file.relative_to(REPOSITORY).parts[0] for file in SOURCES})
    assert "Private :: Do Not Upload" in project["project"]["classifiers"]
