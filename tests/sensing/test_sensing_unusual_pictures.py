"""Pictures that a camera rarely sends: used where they show the robot, refused by name where not, and never the end."""

import cv2
import numpy as np
import pytest

from messaging.shape import Flag, NodalPoints
from sensing.refined.method import Refined
from sensing.scene import Scene
from sensing.sensor import Sensor

POSE = (0.5, 0.4, 0.3, 0.4)
POINTS = NodalPoints(names=("middle", "tip"), arc_mm=np.array([40.0, 80.0]))


@pytest.fixture(scope="module")
def seen(small_bench, arcs):
    return small_bench.photograph(arcs(*POSE))


def again(jpegs, decode, coder):
    """The same pictures, coded otherwise."""
    return {name: coder(decode(jpeg)) for name, jpeg in jpegs.items()}


def grey(picture):
    return cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY))[1].tobytes()


def deep(picture):
    return cv2.imencode(".png", picture.astype(np.uint16) * 257)[1].tobytes()


def deep_and_grey(picture):
    return cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.uint16) * 257)[
        1
    ].tobytes()


def progressive(picture):
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()


@pytest.mark.parametrize("coder", [grey, deep, deep_and_grey, progressive])
@pytest.mark.parametrize("backdrop", ["fitted", "pictures", "colour"])
def test_pictures_coded_otherwise_show_the_same_shape(
    small_bench, without_robot, seen, decode, arcs, look, coder, backdrop, capfd
):
    """Grey pictures too, although the backdrop that is known is green."""
    known = {
        "fitted": {},
        "pictures": {"backgrounds": without_robot},
        "colour": {"colour_rgb": (64.0, 150.0, 82.0)},
    }[backdrop]
    scene = Scene.of(small_bench.rig, length_mm=80.0, **known)
    pictures = again(seen, decode, coder)
    cold = look(scene, pictures)
    for shape in (cold, look(scene, pictures, cold)):
        assert shape.flags == ()
        assert np.abs(shape.nodes(POINTS.arc_mm)[0] - arcs(*POSE)[[40, 80]]).max() < 0.3


def test_a_camera_that_changes_its_size_is_named_until_the_size_returns(small_bench, seen, decode, encode):
    sensor = Sensor(Refined(small_bench.scene()), POINTS, 80.0, 0.5)

    def sense(jpegs):
        return sensor.estimate(jpegs, 0, 1, lambda: 0)

    before = sense(seen)
    smaller = again(seen, decode, lambda picture: encode(cv2.resize(picture, (640, 480))))
    for changed in ({**seen, "right": smaller["right"]}, smaller):
        refused = sense(changed)
        assert "the picture is 640x480 px, its calibration is for 960x540 px" in refused.refusal
    assert sense({**seen, "right": smaller["right"]}).refusal.startswith("camera right: ")
    back = sense(seen)
    assert back.refusal == ""
    assert "cold_start" not in back.stage_names
    assert np.abs(back.node_mm - before.node_mm).max() < 0.05


def plainly_coded(picture):
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()


@pytest.mark.parametrize("markers", [True, False])
def test_damaged_data_are_refused_flagged_or_do_no_harm(small_bench, seen, decode, arcs, markers, capfd):
    """Changed bits, changed bytes and lost bytes, anywhere in one camera's data."""
    random = np.random.default_rng(8)
    sensor = Sensor(Refined(small_bench.scene()), POINTS, 80.0, 0.5)
    pictures = seen if markers else again(seen, decode, plainly_coded)
    sensor.estimate(pictures, 0, 1, lambda: 0)
    outcomes = {"refused": 0, "flagged": 0, "harmless": 0}
    for number in range(24):
        data = bytearray(pictures["left"])
        at = int(random.integers(700, len(data) - 60))
        if number % 3 == 0:
            data[at] ^= 1 << int(random.integers(8))
        elif number % 3 == 1:
            data[at : at + 8] = random.bytes(8)
        else:
            del data[at : at + int(random.integers(1, 60))]
        estimate = sensor.estimate({**pictures, "left": bytes(data)}, 0, 1, lambda: 0)
        doubts = set(estimate.flags) - {Flag.BASE_UNKNOWN}
        outcomes["refused" if estimate.refusal else "flagged" if doubts else "harmless"] += 1
        if not estimate.refusal and not doubts:
            assert np.abs(estimate.node_mm - arcs(*POSE)[[40, 80]]).max() < 0.6
    assert outcomes["refused"] > 2
    assert outcomes["harmless"] > 0
