"""A bench light enough to run beside other tests: pictures of half the size, half as often, and more patience."""

import dataclasses

import pytest

from nodal.bench_file import bench_path, load_bench
from nodal.calibration_file import save_rig
from nodal.toml_file import read_table, written


def halved(camera):
    """The same camera with pixels of twice the size; integer coordinates are pixel centres."""
    intrinsics = camera.intrinsics.copy()
    intrinsics[:2] /= 2
    intrinsics[:2, 2] -= 0.25
    return dataclasses.replace(
        camera, width_px=camera.width_px // 2, height_px=camera.height_px // 2, intrinsics=intrinsics
    )


@pytest.fixture(scope="session")
def light_bench(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    save_rig(folder / "rig.json", [halved(camera) for camera in load_bench("simulated").rig])
    table = read_table(bench_path("simulated"))
    table["calibration"] = "rig.json"
    table["simulation"]["cameras"] = {"sensor": {"rate_hz": 15.0}}
    table["controller"] = {
        "sensing": {"maximum_age_s": 0.5, "hold_at_most_s": 10.0},
        "homing": {"find_slack": False},
        "stall_s": 2.0,
    }
    table["servos"]["answer_timeout_ms"] = 100.0
    table["servos"]["watchdog_ms"] = 1000
    (folder / "bench.toml").write_text(written(table), encoding="utf-8")
    return folder / "bench.toml"
