"""Bench files with webcams: what is refused before a camera is opened."""

import tomllib

import pytest

from drivers.cameras import V4l2CameraSettings, V4l2Controls
from nodal.bench_file import bench_path, load_bench
from nodal.errors import BenchFileError
from nodal.toml_file import written

SIMULATED = bench_path("simulated")


@pytest.fixture
def table():
    table = tomllib.loads(SIMULATED.read_text(encoding="utf-8"))
    table["calibration"] = str(SIMULATED.with_name(table["calibration"]))
    table["cameras"] = {
        name: {"source": "v4l2", "device": f"/dev/v4l/by-path/{name}", "controls": {"exposure_s": 0.01}}
        for name in ("left", "right")
    }
    return table


@pytest.fixture
def loaded(tmp_path, table):
    def _loaded():
        file = tmp_path / "bench.toml"
        file.write_text(written(table), encoding="utf-8")
        return load_bench(file)

    return _loaded


def test_webcams_are_read_and_written_again(loaded, tmp_path):
    bench = loaded()
    assert bench.settings.cameras["left"] == V4l2CameraSettings(
        device="/dev/v4l/by-path/left", controls=V4l2Controls(exposure_s=0.01)
    )
    (tmp_path / "again.toml").write_text(bench.text(), encoding="utf-8")
    assert load_bench(tmp_path / "again.toml").settings.cameras == bench.settings.cameras


def test_another_size_than_the_calibrations_is_refused(loaded, table):
    table["cameras"]["right"] |= {"width_px": 1280, "height_px": 720}
    with pytest.raises(
        BenchFileError, match=r"cameras\.right is asked for 1280x720 px, but was calibrated at 1920x1080 px"
    ):
        loaded()


def test_one_device_for_two_cameras_is_refused(loaded, table):
    table["cameras"]["right"]["device"] = "/dev/v4l/by-path/left"
    with pytest.raises(
        BenchFileError, match=r"cameras\.left and cameras\.right have the same device /dev/v4l"
    ):
        loaded()


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("device", "video0", r"cameras\.right\.device"),
        ("controls", {"power_line_hz": 55}, r"controls\.power_line_hz = 55"),
        ("controls", {"exposure_s": 0}, r"controls\.exposure_s = 0"),
        ("controls", {"iris": 1}, "iris"),
    ],
)
def test_a_value_that_cannot_be_is_named(loaded, table, key, value, message):
    table["cameras"]["right"][key] = value
    with pytest.raises(BenchFileError, match=message):
        loaded()
