"""What a running camera survives: cables, corrupt pictures, frozen streams, clocks that go back."""

import dataclasses
import time

import pytest
from linuxpy.video.raw import BufferFlag, ControlID

from drivers.cameras import V4l2Controls
from drivers.cameras.v4l2.inspection import PictureFault

pytestmark = pytest.mark.usefixtures("soon_again")


def test_unplugged_in_the_middle_of_a_picture_and_back_under_another_number(
    webcam, opened, taken, eventually, caplog
):
    camera = opened(webcam, controls=V4l2Controls(focus=40, exposure_s=0.005))
    before = taken(webcam, camera)
    node = webcam.files.nodes[0]
    webcam.pull_out()
    eventually(lambda: "is not there" in caplog.text)
    # as long as a program maps them, the kernel keeps the device's number
    assert all(memory.closed for memory in webcam.buffers.mapped)
    # somebody else takes the number meanwhile
    node.touch()
    webcam.plug_in()
    assert webcam.files.nodes[0] != node
    eventually(lambda: webcam.starts == 2 and webcam.controls.values[ControlID.FOCUS_ABSOLUTE] == 40)
    # surely after everything is locked
    frame = taken(webcam, camera, lost_before=10, timestamp_ns=time.monotonic_ns() + 500_000_000)
    assert frame.jpeg == webcam.buffers.sent[10]
    # what a stream loses before its first picture, nobody counts
    assert frame.number == before.number + 1
    assert PictureFault.LOST not in camera.faults
    assert webcam.controls.values[ControlID.EXPOSURE_ABSOLUTE] == 50
    assert caplog.text.count("No such device") == 1
    assert caplog.text.count("is not there") == 1


def test_a_camera_that_comes_back_as_another_one_is_waited_for_and_named(
    webcam, opened, taken, eventually, caplog
):
    camera = opened(webcam, controls=V4l2Controls(focus=40))
    taken(webcam, camera)
    webcam.pull_out()
    webcam.controls.stubborn[ControlID.FOCUS_ABSOLUTE] = 0
    webcam.plug_in()
    eventually(lambda: "focus: asked for 40, the camera holds 0" in caplog.text)
    webcam.controls.stubborn.clear()
    assert eventually(lambda: webcam.expose() or camera.read())


def test_what_the_bench_does_not_say_is_afterwards_as_it_was_before(webcam, opened, taken, eventually):
    was = {ControlID.GAIN: 77, ControlID.ZOOM_ABSOLUTE: 150, ControlID.SATURATION: 90}
    webcam.controls.values |= was
    camera = opened(webcam, controls=V4l2Controls(focus=40))
    taken(webcam, camera)
    webcam.pull_out()
    webcam.plug_in()
    assert webcam.controls.values[ControlID.GAIN] == 0
    eventually(lambda: webcam.starts == 2 and webcam.controls.values.items() >= was.items())
    assert webcam.controls.values[ControlID.FOCUS_ABSOLUTE] == 40


def test_a_value_from_before_that_does_not_come_back_is_named(webcam, opened, taken, eventually, caplog):
    webcam.controls.values[ControlID.ZOOM_ABSOLUTE] = 150
    camera = opened(webcam)
    taken(webcam, camera)
    webcam.pull_out()
    webcam.controls.stubborn[ControlID.ZOOM_ABSOLUTE] = 100
    webcam.plug_in()
    eventually(lambda: "zoom_absolute: asked for 150, the camera holds 100" in caplog.text)
    assert camera.read() is None
    del webcam.controls.described[ControlID.ZOOM_ABSOLUTE]
    eventually(lambda: "it has no zoom any more: it is another camera than before" in caplog.text)


def test_a_driver_that_answers_nonsense_is_named_and_waited_for(webcam, opened, taken, eventually, caplog):
    camera = opened(webcam)
    taken(webcam, camera)
    webcam.pull_out()
    contrast = webcam.controls.described[ControlID.CONTRAST]
    webcam.controls.described[ControlID.CONTRAST] = dataclasses.replace(contrast, maximum=2**40)
    webcam.plug_in()
    eventually(lambda: "its driver answers with what makes no sense: Control contrast" in caplog.text)
    webcam.controls.described[ControlID.CONTRAST] = contrast
    assert eventually(lambda: webcam.expose() or camera.read())


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (lambda picture: {"picture": picture, "flags": BufferFlag.ERROR}, PictureFault.DAMAGED),
        (lambda picture: {"picture": picture[: len(picture) // 2]}, PictureFault.INCOMPLETE),
        (lambda picture: {"picture": picture[2:]}, PictureFault.INCOMPLETE),
        (lambda _: {"picture": b""}, PictureFault.INCOMPLETE),
        (lambda _: {"timestamp_ns": time.monotonic_ns() - 20_000_000_000}, PictureFault.OLDER),
    ],
)
def test_a_bad_picture_is_left_out_counted_and_said(webcam, opened, taken, caplog, spoil, fault):
    camera = opened(webcam)
    taken(webcam, camera)
    webcam.expose(**spoil(webcam.buffers.next_picture()))
    assert taken(webcam, camera).number == 2
    assert camera.faults == {fault: 1}
    assert f"camera left: pictures left out: 1 {fault}" in caplog.text


def test_zeros_behind_a_picture_are_no_fault(webcam, opened, taken):
    padded = webcam.buffers.next_picture() + bytes(500)
    assert taken(webcam, opened(webcam), picture=padded).jpeg == padded


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize("repeating", [False, True])
def test_a_frozen_stream_is_started_anew(running_webcam, opened, eventually, caplog, repeating):
    camera = opened(running_webcam)
    eventually(camera.read)
    running_webcam.hang(repeating=repeating)
    eventually(lambda: running_webcam.starts > 1)
    while camera.read() is not None:
        pass
    assert eventually(camera.read).jpeg in running_webcam.buffers.sent.values()
    assert "no good picture for 0.3 s" in caplog.text
    assert ("only such as were the same as the one before" in caplog.text) == repeating


@pytest.mark.usefixtures("impatient")
def test_a_camera_that_gives_nothing_at_all_is_started_again_and_again_but_said_once(
    webcam, opened, eventually, caplog
):
    opened(webcam)
    eventually(lambda: webcam.starts > 2)
    assert caplog.text.count("no good picture for 0.6 s") == 1
