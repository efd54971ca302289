"""`nodal new`: benches to begin with, real and simulated."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from drivers.cameras import worst_skew_periods
from drivers.simulated.cameras.rig import default_cameras
from nodal.__main__ import _parser, main
from nodal.bench_file import read_bench
from nodal.calibration_file import load_rig
from nodal.new.writing import MARK


@pytest.fixture
def new(tmp_path, capsys):
    def run(*words: str, name: str = "try it"):
        folder = tmp_path / name
        status = main(["new", str(folder), *words])
        return status, folder, capsys.readouterr()

    return run


def test_a_real_bench_says_what_to_fill_in_and_agrees_with_itself(new):
    status, folder, said = new()
    bench = read_bench(folder / "bench.toml")
    settings = bench.checked()
    text = bench.path.read_text(encoding="utf-8")
    assert status == 0
    assert settings.name == "try-it"
    assert settings.simulation is None
    assert settings.board.at_base is None
    assert all("FILL-IN" in camera.device for camera in settings.cameras.values())
    assert text.count(f"# {MARK}: ") == 6
    period_s = 1 / max(camera.rate_hz for camera in settings.cameras.values())
    assert settings.sensing.maximum_skew_s >= worst_skew_periods(len(settings.cameras)) * period_s
    steps = said.out.splitlines()[1:]
    assert [step.split()[2] for step in steps if "calibrate" in step] == [
        "board",
        "board",
        "cameras",
        "base",
        "background",
        "robot",
    ]


@pytest.mark.parametrize("words", [(), ("--simulated",)], ids=("real", "simulated"))
def test_what_comes_next_can_be_typed_as_it_is_printed(new, words):
    _, folder, said = new(*words)
    steps = [line.strip() for line in said.out.splitlines()[1:] if line.startswith("  nodal ")]
    assert len(steps) >= 5
    for step in steps:
        command, _ = re.split(r" {2,}", step)
        typed = shlex.split(command.replace(" MM", " 99.5"))[1:]
        config = getattr(_parser(typed).parse_args(typed), "config", folder / "bench.toml")
        assert Path(config or folder / "bench.toml") == folder / "bench.toml"


def test_the_fixture_of_a_real_bench_only_needs_its_comment_signs_removed(new):
    _, folder, _ = new()
    file = folder / "bench.toml"
    text = file.read_text(encoding="utf-8")
    for line in ("[board.at_base]", "origin_mm", "x_axis", "y_axis"):
        text = text.replace(f"# {line}", line)
    file.write_text(text, encoding="utf-8")
    assert read_bench(file).checked().board.at_base.origin_mm == (-45.0, 0.0, 77.0)


def test_a_simulated_bench_is_not_calibrated_and_not_as_the_drawing_says(new):
    status, folder, said = new("--simulated", "--seed", "4")
    settings = read_bench(folder / "bench.toml").checked()
    simulation = settings.simulation
    assert status == 0
    assert MARK not in (folder / "bench.toml").read_text(encoding="utf-8") + said.out
    assert not (folder / "calibration").exists()
    believed = np.array([axis.mm_per_rad for axis in settings.servos.tendons])
    true = np.array(simulation.drive.each_pulley_mm_per_rad)
    assert sorted(np.sign(true)) == [-1, 1, 1, 1]
    assert (np.abs(np.abs(true) - believed) < 0.1 * believed).all()
    assert settings.board.at_base is not None
    for drawn, nominal in zip(load_rig(folder / "true-rig.json"), default_cameras(), strict=True):
        turned = np.linalg.norm(drawn.camera_from_robot[:3, :3] - nominal.camera_from_robot[:3, :3])
        assert 0.001 < turned < 0.15
        assert 0 < abs(drawn.intrinsics[0, 0] / nominal.intrinsics[0, 0] - 1) <= 0.03


def test_the_same_seed_gives_the_same_bench_on_a_port_of_its_own(new):
    folders = [
        new("--simulated", "--seed", seed, name=name)[1]
        for seed, name in (("7", "a"), ("7", "b"), ("8", "c"))
    ]
    rigs = [(folder / "true-rig.json").read_bytes() for folder in folders]
    benches = [read_bench(folder / "bench.toml").settings for folder in folders]
    simulations = [bench.simulation for bench in benches]
    assert rigs[0] == rigs[1] != rigs[2]
    assert simulations[0].robot == simulations[1].robot != simulations[2].robot
    assert simulations[0].drive == simulations[1].drive
    assert len({bench.zenoh.rendezvous for bench in benches}) == 3


def test_what_is_there_already_is_left_alone(new, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("keep")
    status, _, said = new(name="mine")
    assert status == 2
    assert "it is there already" in said.err
    assert [file.name for file in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    (tmp_path / "empty").mkdir()
    assert new(name="empty")[0] == 0


@pytest.mark.parametrize(
    ("words", "reason"),
    [(["--seed", "2"], "only a bench that is --simulated"), (["--simulated", "--seed", "-1"], "0 or more")],
)
def test_a_seed_that_means_nothing_is_refused(new, words, reason):
    status, folder, said = new(*words)
    assert status == 2
    assert reason in said.err
    assert not folder.exists()
