"""`nodal cameras` as it is typed, on webcams that stand in below the V4L2 calls, and on files."""

import json
import shutil

import cv2
import numpy as np
import pytest
from linuxpy.video.raw import PixelFormat

from drivers.simulated.v4l2 import StandInCamera, plugged_in
from drivers.simulated.v4l2.description import CameraDescription
from nodal.__main__ import main
from nodal.bench_file import SHIPPED, read_bench
from nodal.toml_file import read_table

SIZE_PX = 960, 540
FORMATS = {
    PixelFormat.YUYV: {SIZE_PX: (5,)},
    PixelFormat.MJPEG: {(320, 180): (60,), SIZE_PX: (60, 30), (3840, 2160): (30,)},
}


@pytest.fixture
def bench(tmp_path, monkeypatch, zenoh_settings):
    """A bench file that says something of its cameras already, and is not calibrated."""
    monkeypatch.chdir(tmp_path)
    text = (SHIPPED / "simulated.toml").read_text(encoding="utf-8")
    text = text.replace(
        '[cameras.left]\nsource = "simulated"',
        '[cameras.left]  # the near one\nsource = "avi"\nfile = "a.avi"',
    )
    text += f'\n[zenoh]\nrendezvous = "{zenoh_settings.rendezvous}"\n'
    (tmp_path / "bench.toml").write_text(text, encoding="utf-8")
    return tmp_path / "bench.toml"


@pytest.fixture(scope="module")
def pictures(scene, coded):
    """Of two webcams, the first of which is in the dark."""
    return [[coded(share * scene, seed=seed) for seed in range(3)] for share in (0.4, 1.0)]


@pytest.fixture
def webcams(pictures):
    """Their lasting paths."""
    cameras = [
        StandInCamera(those, CameraDescription(usb_port=f"{number}", formats=FORMATS))
        for number, those in enumerate(pictures, 1)
    ]
    with plugged_in(*cameras):
        yield [str(camera.path) for camera in cameras]


def test_list_gives_lasting_paths_sizes_and_controls(webcams, capsys) -> None:
    assert main(["cameras", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line in webcams] == webcams
    assert "  MJPG  320x180 60 Hz, 960x540 60 Hz, 3840x2160 30 Hz" in lines
    assert [" ".join(line.split()) for line in lines if "exposure_s" in line] == [
        "exposure_s (exposure_time_absolute) 0.025 0.0003 to 0.2047; default 0.025"
    ] * 2
    assert main(["cameras", "list", "--json"]) == 0
    described = json.loads(capsys.readouterr().out)
    assert [camera["path"] for camera in described] == webcams


def test_list_without_cameras_says_why_that_may_be(capsys) -> None:
    with plugged_in():
        assert main(["cameras", "list"]) == 3
        assert "no camera is plugged in" in capsys.readouterr().out
        assert main(["cameras", "list", "--json"]) == 3
        assert json.loads(capsys.readouterr().out) == []


def test_write_sets_up_every_camera_and_keeps_the_rest_of_the_file(webcams, bench, capsys) -> None:
    assert main(["cameras", "write", "--config", str(bench), "--mains", "60"]) == 0
    cameras = read_bench(bench).settings.cameras
    assert [camera.device for camera in cameras.values()] == webcams
    left = cameras["left"]
    assert (left.width_px, left.height_px, left.rate_hz) == (*SIZE_PX, 30.0)
    assert (left.controls.exposure_s, left.controls.power_line_hz, left.controls.brightness) == (
        0.0083,
        60,
        None,
    )
    text = bench.read_text(encoding="utf-8")
    assert "[cameras.left]  # the near one" in text
    assert "a.avi" not in text
    assert "\n\n[cameras.right]" in text
    assert f"# which is right? nodal cameras look --device {webcams[1]}" in capsys.readouterr().out


def test_write_takes_devices_by_any_of_their_names(webcams, bench) -> None:
    words = ["--camera", f"left={webcams[1]}", f"right={webcams[0].replace('by-path', 'x')}"]
    assert main(["cameras", "write", "--config", str(bench), *words]) == 2
    words[-1] = f"right={webcams[0][: webcams[0].index('/v4l')]}/video0"
    assert main(["cameras", "write", "--config", str(bench), *words]) == 0
    assert [camera["device"] for camera in read_table(bench)["cameras"].values()] == webcams[::-1]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("--camera", "le ft={0}"), "allowed is NAME=DEVICE"),
        (("--camera", "left={0}", "left={1}"), "left is given twice"),
        (("--camera", "left={0}", "right={0}"), "is left already"),
        (("--camera", "left=/dev/nothing"), "/dev/nothing is no camera; there are {0}, {1}"),
        (("--config", "simulated"), "it comes with nodal and stays as it is"),
    ],
)
def test_write_refuses_what_cannot_be_meant(words, fault, webcams, bench, capsys) -> None:
    before = bench.read_text(encoding="utf-8")
    assert main(["cameras", "write", "--config", str(bench), *(word.format(*webcams) for word in words)]) == 2
    assert fault.format(*webcams) in capsys.readouterr().err
    assert bench.read_text(encoding="utf-8") == before


def test_write_asks_which_is_which_when_numbers_differ(bench, scene, coded, capsys) -> None:
    with plugged_in(StandInCamera([coded(scene)])):
        assert main(["cameras", "write", "--config", str(bench)]) == 2
    assert "1 cameras are plugged in" in capsys.readouterr().err
    yuyv = {PixelFormat.YUYV: FORMATS[PixelFormat.YUYV]}
    with plugged_in(StandInCamera([coded(scene)], CameraDescription(formats=yuyv))) as folder:
        assert main(["cameras", "write", "--config", str(bench), "--camera", f"left={folder}/video0"]) == 2
    assert "gives no JPEG pictures; its formats: YUYV" in capsys.readouterr().err


def test_look_judges_each_webcam_and_writes_what_it_suggests(webcams, bench, scene, capsys) -> None:
    assert main(["cameras", "write", "--config", str(bench)]) == 0
    capsys.readouterr()
    # skew depends on when the cameras were started, and so does the exit status
    main(["cameras", "look", "--config", str(bench), "--pictures", "3", "--write"])
    report = capsys.readouterr().out
    assert "dark: the backdrop is at level" in report
    assert "well exposed: the backdrop is at level" in report
    assert "pictures that belong together are up to" in report
    controls = {name: camera.controls for name, camera in read_bench(bench).settings.cameras.items()}
    assert controls["left"].exposure_s == 0.03
    assert controls["right"].exposure_s == 0.01
    seen = cv2.imread(str(bench.parent / "look" / "right.jpg"))
    assert np.abs(seen.astype(float) - scene).mean() < 3
    assert (bench.parent / "look" / "left-judged.png").stat().st_size > 10_000


def test_look_shows_a_device_that_is_on_no_bench(webcams, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["cameras", "look", "--device", webcams[1], "--pictures", "2", "--out", "shown"]) == 0
    assert "camera device, picture" in capsys.readouterr().out
    assert sorted(file.name for file in (tmp_path / "shown").iterdir()) == ["device-judged.png", "device.jpg"]
    assert main(["cameras", "look", "--device", webcams[1], "--write"]) == 2
    assert main(["cameras", "look", "--device", webcams[1], "--pictures", "0"]) == 2


def test_look_through_pictures_tells_that_they_do_not_fit_the_calibration(
    bench, scene, coded, capsys
) -> None:
    shutil.copy(SHIPPED / "simulated-rig.json", bench.parent)
    for number in range(2):
        (bench.parent / f"{number}.jpg").write_bytes(coded(scene, seed=number))
    words = ["--config", str(bench), "--images", f"left={bench.parent}/*.jpg", "--json"]
    assert main(["cameras", "look", *words]) == 3
    left = json.loads(capsys.readouterr().out)["cameras"]["left"]
    assert {finding["subject"]: finding["verdict"] for finding in left["findings"]}["size"] == "poor"
    assert left["size_px"] == list(SIZE_PX)
    assert 0.7 < left["figures"]["edge_width_px"] < 3.0
    assert left["timing"] is left["figures"]["noise_levels"] is None
