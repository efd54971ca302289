"""A camera that is not there, taken, forbidden, or gives something else is an error that says so."""

import errno
import os

import pytest
from linuxpy.video.device import Device, VideoCapture
from linuxpy.video.raw import PixelFormat

from drivers.cameras import CameraBusyError, CameraDeviceError, CameraFormatError
from drivers.cameras.v4l2.camera import V4l2Camera
from drivers.simulated.v4l2 import StandInCamera, plugged_in
from drivers.simulated.v4l2.description import CameraDescription


def test_a_missing_device_is_named_beside_those_that_are_there(webcam, settings):
    with pytest.raises(CameraDeviceError) as raised:
        V4l2Camera("left", settings(device="/dev/v4l/by-path/other-video-index0"))
    assert (
        str(raised.value)
        == f"camera left: /dev/v4l/by-path/other-video-index0 is not there; there are {webcam.path}"
    )


def test_no_camera_at_all_is_said(pictures, settings):
    with plugged_in(), pytest.raises(CameraDeviceError, match="no camera is there at all"):
        V4l2Camera("left", settings(device="/dev/video7"))


def test_a_device_that_gives_no_pictures_is_refused(webcam, settings):
    metadata = webcam.files.nodes[1]
    with pytest.raises(CameraDeviceError, match=f"{metadata} .*gives no pictures; there are {webcam.path}"):
        V4l2Camera("left", settings(device=str(metadata)))


def test_a_forbidden_device_names_the_group(webcam, opened):
    webcam.is_permitted = False
    with pytest.raises(CameraDeviceError, match="group `video`"):
        opened(webcam)


def test_a_camera_that_another_program_streams_from_is_busy(webcam, opened):
    with Device(webcam.path) as device, VideoCapture(device):
        with pytest.raises(CameraBusyError, match=r"is in use by another user's program: sudo fuser -v"):
            opened(webcam)
        # whoever has the device file itself open is named
        with webcam.files.nodes[0].open(), pytest.raises(CameraBusyError, match=rf"process {os.getpid()}\)"):
            opened(webcam)


def test_a_bus_without_room_is_said_and_the_camera_let_go(webcam, opened):
    webcam.start_refused = errno.ENOSPC
    with pytest.raises(CameraDeviceError, match="its USB bus has no room left"):
        opened(webcam)
    webcam.start_refused = 0
    opened(webcam)


def test_another_size_granted_is_an_error_naming_both_and_what_there_is(webcam, opened):
    webcam.formats.granted = (1280, 720)
    with pytest.raises(
        CameraFormatError,
        match=r"asked for 640x480 px, it grants 1280x720; it offers 640x480, 1280x720, 1920x1080",
    ):
        opened(webcam)
    webcam.formats.granted = None
    opened(webcam)


def test_another_rate_granted_is_an_error(webcam, opened):
    with pytest.raises(
        CameraFormatError, match=r"asked for 25 Hz, it grants 24; at 640x480 px it offers 30, 24, 20"
    ):
        opened(webcam, rate_hz=25)


def test_a_camera_without_jpeg_is_refused(pictures, settings):
    raw_only = StandInCamera(
        pictures, CameraDescription(formats={PixelFormat.YUYV: {(640, 480): (30,)}}), running=False
    )
    with (
        plugged_in(raw_only),
        pytest.raises(CameraFormatError, match=r"no JPEG pictures \(MJPG\), only YUYV"),
    ):
        V4l2Camera("left", settings(device=str(raw_only.path)))
