"""What is plugged in, and what it can do."""

from linuxpy.video.device import Device, VideoCapture

from drivers.cameras.v4l2.listing import PictureFormat, devices
from drivers.simulated.v4l2 import StandInCamera, plugged_in
from drivers.simulated.v4l2.description import CameraDescription


def test_cameras_are_listed_by_the_names_that_last(pictures):
    left = StandInCamera(pictures)
    right = StandInCamera(pictures, CameraDescription(usb_port="2"))
    with plugged_in(left, right) as folder:
        found = devices()
        assert [one.path for one in found] == [left.path, right.path]
        # each has a second device file, which gives no pictures
        assert [one.node for one in found] == [folder / "video0", folder / "video2"]
        assert found[1].lasting_paths == (
            folder / "v4l/by-path/pci-0000:00:14.0-usb-0:2:1.0-video-index0",
            folder / "v4l/by-id/usb-046d_C922_Pro_Stream_Webcam_5B0C2E02-video-index0",
        )
        assert {(one.card, one.driver, one.bus, one.problem) for one in found} == {
            ("C922 Pro Stream Webcam", "uvcvideo", "usb-0000:00:14.0-1", ""),
            ("C922 Pro Stream Webcam", "uvcvideo", "usb-0000:00:14.0-2", ""),
        }
        left.pull_out()
        assert [one.path for one in devices()] == [right.path]


def test_formats_and_controls_are_told_as_the_camera_has_them(webcam):
    (found,) = devices()
    assert (
        PictureFormat(
            pixel_format="MJPG",
            width_px=1920,
            height_px=1080,
            rates_hz=(30.0, 24.0, 20.0, 15.0, 10.0, 7.5, 5.0),
        )
        in found.formats
    )
    controls = {control.name: control for control in found.controls}
    exposure = controls["exposure_time_absolute"]
    assert (exposure.setting, exposure.minimum, exposure.maximum, exposure.value) == (
        "exposure_s",
        3,
        2047,
        250,
    )
    assert exposure.in_setting(exposure.value) == 0.025
    assert controls["power_line_frequency"].menu == {0: "Disabled", 1: "50 Hz", 2: "60 Hz"}
    assert controls["power_line_frequency"].in_setting(2) == 60
    backlight = controls["backlight_compensation"]
    assert (backlight.setting, backlight.in_setting(1)) == (None, 1)


def test_a_camera_that_another_program_uses_can_be_asked_all_the_same(webcam):
    with Device(webcam.path) as device, VideoCapture(device):
        assert devices()[0].formats


def test_a_camera_that_may_not_be_opened_is_listed_with_its_problem(webcam):
    webcam.is_permitted = False
    found = devices()
    assert found[0].path == webcam.path
    # what cannot be asked may give pictures, for all that is known
    assert [one.node for one in found] == list(webcam.files.nodes)
    assert all("group `video`" in one.problem for one in found)
