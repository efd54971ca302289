"""Cameras from the command line: the bench's own, or files in their place."""

import argparse
from pathlib import Path

import pytest

from drivers.cameras import AviCameraSettings, CameraError, FolderCameraSettings, RecordingCameraSettings
from nodal.bench_file import read_bench
from nodal.cameras.chosen import add_source_arguments, chosen_cameras, running_cameras
from nodal.errors import CommandError

LOG = str(Path(__file__).parents[2] / "data" / "run.mcap")


@pytest.fixture
def bench():
    return read_bench("simulated")


@pytest.fixture
def chosen(bench):
    def choose(*words):
        parser = argparse.ArgumentParser()
        add_source_arguments(parser)
        return dict(chosen_cameras(parser.parse_args(words), bench.settings))

    return choose


def test_without_files_the_bench_has_its_own_cameras(chosen, bench) -> None:
    assert chosen() == bench.settings.cameras


def test_folders_patterns_and_single_pictures(chosen, tmp_path) -> None:
    (tmp_path / "deep[1]" / "a").mkdir(parents=True)
    for name in ("1_left.jpg", "1[a].jpg", "1_right.jpg", "deep[1]/a/1.png"):
        (tmp_path / name).touch()

    def folder(text):
        return chosen("--images", f"left={tmp_path}/{text}")["left"]

    assert folder("*_left.jpg") == FolderCameraSettings(folder=str(tmp_path), pattern="*_left.jpg")
    assert folder("") == FolderCameraSettings(folder=f"{tmp_path}/")
    assert folder("1_left.jpg") == FolderCameraSettings(folder=str(tmp_path), pattern="1_left.jpg")
    assert folder("1[a].jpg").pattern == "1[[]a].jpg"
    assert folder("*/a/*.png") == FolderCameraSettings(folder=str(tmp_path), pattern="*/a/*.png")
    assert list(chosen("--images", f"right={tmp_path}/*_right.jpg", f"left={tmp_path}/*_left.jpg")) == [
        "left",
        "right",
    ]


def test_videos_and_recordings(chosen) -> None:
    assert chosen("--video", "right=r.avi") == {"right": AviCameraSettings(file="r.avi")}
    assert chosen("--recording", LOG) == dict.fromkeys(("left", "right"), RecordingCameraSettings(file=LOG))


def test_parts_that_are_not_read_are_named(chosen, tmp_path, capsys) -> None:
    for name in ("run.mcap", "run.part2.mcap"):
        (tmp_path / name).touch()
    chosen("--recording", f"{tmp_path}/run.mcap")
    assert (
        capsys.readouterr().err
        == f"only {tmp_path}/run.mcap is read; it goes on in {tmp_path}/run.part2.mcap\n"
    )
    chosen("--recording", LOG)
    assert capsys.readouterr().err == ""


def test_a_recording_runs_without_the_bench(chosen, bench) -> None:
    with running_cameras(bench, chosen("--recording", LOG), "cameras") as (cameras, _):
        assert [camera.read().name for camera in cameras] == ["left", "right"]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("top={}",), "top={}: top is not one of the cameras left, right"),
        (("left",), "left: allowed is NAME=FILE"),
        (("left=",), "left=: allowed is NAME=FILE"),
        (("left={}", "left=b"), "camera left is given twice, {} and b"),
        (("left={}", "right={}/*.jpg"), "picture {}/1.jpg is given to camera left and to camera right"),
    ],
)
def test_what_cannot_be_meant_is_refused(words, fault, chosen, tmp_path) -> None:
    (tmp_path / "1.jpg").touch()
    with pytest.raises(CommandError) as refused:
        chosen("--images", *(word.format(tmp_path) for word in words))
    assert fault.format(tmp_path) in str(refused.value)


def test_a_folder_without_pictures_is_refused(chosen, tmp_path) -> None:
    with pytest.raises(CameraError, match="camera left: no picture"):
        chosen("--images", f"left={tmp_path}")
    with pytest.raises(CameraError, match="camera left: there is no folder"):
        chosen("--images", f"left={tmp_path}/away/*.jpg")
