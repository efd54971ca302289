"""`nodal cameras` as it is typed, on webcams that stand in below the V4L2 calls, and on files."""

import dataclasses
import json
import shutil
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from linuxpy.video.raw import ControlID, PixelFormat

from drivers.cameras import CameraDeviceError
from drivers.cameras.v4l2.listing import DeviceControl, DeviceDescription, PictureFormat, devices
from drivers.simulated.v4l2 import Scene, StandInCamera, plugged_in
from drivers.simulated.v4l2.description import CONTROLS, CameraDescription
from nodal.__main__ import main
from nodal.bench_editing import edit_bench_file
from nodal.bench_file import SHIPPED, read_bench
from nodal.cameras.devices import suggested_settings
from nodal.toml_file import read_table

SIZE_PX = 960, 540
FORMATS = {
    PixelFormat.YUYV: {SIZE_PX: (5,)},
    PixelFormat.MJPEG: {(320, 180): (60,), SIZE_PX: (60, 30), (3840, 2160): (30,)},
}

FAST = {PixelFormat.MJPEG: {SIZE_PX: (45,)}}
SMALL = {PixelFormat.MJPEG: {(480, 270): (120,)}}


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


def test_a_rule_of_ones_own_names_a_camera_too(webcams, bench, capsys) -> None:
    own = bench.parent / "nodal-left"
    own.symlink_to(webcams[0])
    words = ["--camera", f"left={own}", f"right={webcams[1]}"]
    assert main(["cameras", "write", "--config", str(bench), *words]) == 0
    assert [camera["device"] for camera in read_table(bench)["cameras"].values()] == webcams
    edit_bench_file(bench, {"cameras": {"left": {"device": str(own)}}})
    assert main(["cameras", "look", "--config", str(bench), "--pictures", "1"]) in {0, 3}


def test_write_leaves_nothing_of_another_camera(webcams, bench) -> None:
    assert main(["cameras", "write", "--config", str(bench)]) == 0
    edit_bench_file(bench, {"cameras": {"left": {"controls": {"contrast": 7}}}})
    assert main(["cameras", "write", "--config", str(bench)]) == 0
    assert "contrast" not in bench.read_text(encoding="utf-8")


def test_a_bench_file_without_tables_of_cameras_is_refused_by_name(webcams, tmp_path, capsys) -> None:
    file = tmp_path / "three.toml"
    file.write_text("cameras = 3\n", encoding="utf-8")
    assert main(["cameras", "write", "--config", str(file)]) == 2
    assert "three.toml: cameras = 3" in capsys.readouterr().err


def test_what_a_camera_is_asked_for_is_what_the_driver_takes(coded, scene) -> None:
    ntsc = {PixelFormat.MJPEG: {(640, 480): (60,), SIZE_PX: (Fraction(30000, 1001),)}}
    with plugged_in(StandInCamera([coded(scene)], CameraDescription(formats=ntsc))):
        settings = suggested_settings(devices()[0])
    assert (settings.width_px, settings.height_px) == SIZE_PX
    assert settings.rate_hz == pytest.approx(29.97, abs=0.01)
    jpeg = PictureFormat(pixel_format="JPEG", width_px=640, height_px=480, rates_hz=(30.0,))
    with pytest.raises(CameraDeviceError, match="gives no JPEG pictures; its formats: JPEG"):
        suggested_settings(
            DeviceDescription(path=Path("/x"), lasting_paths=(), node=Path("/x"), formats=(jpeg,))
        )
    fast = dataclasses.replace(jpeg, pixel_format="MJPG", rates_hz=(120.0,))
    exposure = DeviceControl(
        name="e", setting="exposure_s", minimum=1, maximum=5000, step=1, default=250, value=250, menu={}
    )
    settings = suggested_settings(
        DeviceDescription(
            path=Path("/x"), lasting_paths=(), node=Path("/x"), formats=(fast,), controls=(exposure,)
        )
    )
    assert settings.controls.exposure_s == 0.0075


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


def test_following_what_is_suggested_makes_the_pictures_good(bench, scene, capsys) -> None:
    # a quarter of the light that the exposure of `write` needs; gain gives three times as much, with as much noise
    dark = Scene(picture=scene, exposed_at=400, noise_levels=3.0, sharp_at=0)
    webcams = [StandInCamera(dark, CameraDescription(usb_port=port, formats=FAST)) for port in "12"]
    words = ["cameras", "look", "--config", str(bench), "--pictures", "6", "--write"]
    with plugged_in(*webcams):
        for webcam in webcams:
            webcam.controls.values |= {ControlID.GAIN: 100, ControlID.SHARPNESS: 200}
        assert main(["cameras", "write", "--config", str(bench)]) == 0
        edit_bench_file(bench, {"sensing": {"maximum_skew_s": 0.034}})
        main(words)
        assert capsys.readouterr().out.count("gain = 0  # noise of") == 2
        main(words)
        assert capsys.readouterr().out.count("exposure_s = 0.02  # the backdrop is at level") == 2
        assert main(words) == 0
    report = capsys.readouterr().out
    assert "suggested" not in report
    assert report.count("well exposed") == 2
    for camera in read_bench(bench).settings.cameras.values():
        assert (camera.controls.gain, camera.controls.sharpness) == (0, 128)


def test_look_finds_the_focus_and_writes_it(bench, scene, capsys) -> None:
    shutil.copy(SHIPPED / "simulated-rig.json", bench.parent)
    sharp = StandInCamera(Scene(picture=scene[::2, ::2], sharp_at=145), CameraDescription(formats=SMALL))
    fixed = tuple(control for control in CONTROLS if control.id != ControlID.FOCUS_ABSOLUTE)
    by_hand = StandInCamera(
        Scene(picture=scene), CameraDescription(usb_port="2", formats=SMALL, controls=fixed)
    )
    with plugged_in(sharp, by_hand):
        assert main(["cameras", "write", "--config", str(bench)]) == 0
        said = capsys.readouterr().err
        assert "The focus of left stays where it stands now, sharp or not" in said
        assert f"nodal cameras look --config {bench} --focus --write" in said
        assert main(["cameras", "look", "--config", str(bench), "--focus", "--write"]) == 0
        found = sharp.controls.values[ControlID.FOCUS_ABSOLUTE]
    # one step beside it the picture is as sharp
    assert abs(found - 145) <= 5
    said = capsys.readouterr()
    assert "camera right: it has no focus that can be set" in said.err
    assert "The calibration holds for the focus before: nodal calibrate cameras" in said.err
    assert "camera left: sharp: edges are" in said.out
    assert f"at focus {found}; at 0, where it was, " in said.out
    assert read_bench(bench).settings.cameras["left"].controls.focus == found


def test_focus_of_what_has_none_is_refused(bench, webcams, capsys) -> None:
    assert main(["cameras", "look", "--config", "simulated", "--focus"]) == 2
    assert "none of the cameras is a webcam with a focus" in capsys.readouterr().err
    assert main(["cameras", "look", "--config", str(bench), "--focus", "--video", "left=a.avi"]) == 2
    assert "--focus moves the lens of a webcam" in capsys.readouterr().err


def test_a_picture_without_edges_is_blurred_at_any_focus(scene, capsys) -> None:
    even = StandInCamera(Scene(picture=np.full_like(scene[::2, ::2], 120)), CameraDescription(formats=SMALL))
    with plugged_in(even):
        assert main(["cameras", "look", "--device", str(even.path), "--focus", "--json"]) == 3
    found = json.loads(capsys.readouterr().out)["device"]
    assert found["verdict"] == "poor"
    assert set(found["edge_widths_px"].values()) == {None}


def test_look_shows_a_device_that_is_on_no_bench(webcams, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["cameras", "look", "--device", webcams[1], "--pictures", "2", "--out", "shown"]) == 0
    assert "camera device, picture" in capsys.readouterr().out
    assert sorted(file.name for file in (tmp_path / "shown").iterdir()) == ["device-judged.png", "device.jpg"]
    assert main(["cameras", "look", "--device", webcams[1], "--write"]) == 2
    assert main(["cameras", "look", "--device", webcams[1], "--pictures", "0"]) == 2


def test_a_picture_that_cannot_be_written_is_named(webcams, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "look" / "device.jpg").mkdir(parents=True)
    assert main(["cameras", "look", "--device", webcams[1], "--pictures", "2"]) == 2
    assert "--out: look/device.jpg cannot be written: Is a directory" in capsys.readouterr().err


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
