"""Every case's pictures can be made, and differ from undegraded ones as the case says; at a quarter of the size."""

import dataclasses

import cv2
import numpy as np
import pytest

from benchmarks.degradations.cases import CASES
from benchmarks.degradations.level import FRAME_S, Level
from benchmarks.degradations.motions import eye, towards
from benchmarks.degradations.optics import shadow
from benchmarks.degradations.rigs import Rig, project, sized, smaller
from benchmarks.degradations.scenery import REFERENCE, Bench
from benchmarks.poses import LENGTH_MM

LEVELS = {f"{case.name}: {level.name}": level for case in CASES for level in case.levels}
UNCHANGED_PICTURES = {"none", "calibration", "background picture"}
BENCHES: dict[Bench, Bench] = {}


def small(rig: Rig) -> Rig:
    return tuple(smaller(camera, 4) for camera in rig)


def cheap(level: Level) -> Level:
    bench = BENCHES.setdefault(level.bench, dataclasses.replace(level.bench, rig=small(level.bench.rig)))
    return dataclasses.replace(level, bench=bench)


PLAIN = cheap(Level(name="plain"))


def shown(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR).astype(float)


def pictures(name, number=1, time_s=0.0):
    return {camera: shown(data) for camera, data in cheap(LEVELS[name]).pictures(number, time_s).items()}


@pytest.fixture(scope="module")
def plain():
    return {camera: shown(data) for camera, data in PLAIN.pictures(1, 0.0).items()}


@pytest.mark.parametrize("name", LEVELS)
def test_pictures_of_every_level_can_be_made(name):
    level = cheap(LEVELS[name])
    coded = level.pictures(1, 0.0)

    assert coded == level.pictures(1, 0.0)
    assert set(coded) <= {camera.camera for camera in level.bench.rig}
    assert (coded == PLAIN.pictures(1, 0.0)) == (name.split(":")[0] in UNCHANGED_PICTURES)
    assert len(level.scene().cameras) == len(level.bench.rig)


def test_case_and_level_names_are_unique_and_can_be_typed():
    assert len(LEVELS) == sum(len(case.levels) for case in CASES)
    assert not any("," in case.name or ":" in case.name for case in CASES)


def test_noise_grows(plain):
    spread = [np.std(pictures(f"noise: {sigma} levels")["left"][:60, :60]) for sigma in (4, 8, 16)]

    assert np.std(plain["left"][:60, :60]) < spread[0] < spread[1] < spread[2]


def test_blur_flattens(plain):
    slopes = [
        np.abs(np.diff(cv2.blur(pictures(f"blur: {px} px")["left"], (3, 3)), axis=1)).max()
        for px in ("1.5", "3", "6")
    ]

    assert slopes[0] > slopes[1] > slopes[2]


def test_lower_quality_is_fewer_bytes():
    lengths = [
        len(cheap(LEVELS[f"jpeg quality: {quality}"]).pictures(1, 0.0)["left"]) for quality in (95, 60, 30)
    ]

    assert lengths[0] > lengths[1] > lengths[2]


def test_stops_double_and_halve_light(plain):
    light = {stops: (pictures(f"exposure: {stops} stop")["left"] / 255) ** 2.2 for stops in ("+1", "-1")}

    middle = (plain["left"] / 255) ** 2.2
    assert np.median(light["+1"][..., 1] / middle[..., 1]) == pytest.approx(2, rel=0.1)
    assert np.median(light["-1"][..., 1] / middle[..., 1]) == pytest.approx(0.5, rel=0.1)


def test_codings_are_what_they_say():
    coded = {
        name: cheap(LEVELS[f"coding: {name}"]).pictures(1, 0.0)["left"]
        for name in ("grey", "16-bit PNG", "progressive")
    }

    unchanged = {
        name: cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        for name, data in coded.items()
    }
    assert unchanged["grey"].ndim == 2
    assert unchanged["16-bit PNG"].dtype == np.uint16
    assert b"\xff\xc2" in coded["progressive"][:2000]


def changed_at(plain, name, camera="left"):
    """Pixels (n, 2) that a level changed by much more than noise."""
    off = np.abs(cv2.blur(pictures(name)[camera], (3, 3)) - cv2.blur(plain[camera], (3, 3))).max(axis=2)
    return np.argwhere(off > 12)[:, ::-1]


def point(arc_mm, camera="left"):
    seen = next(seen for seen in PLAIN.bench.rig if seen.camera == camera)
    return project(seen, PLAIN.moves(1).at(0.0)[[arc_mm]])[0]


@pytest.mark.parametrize(
    ("level", "arc_mm"),
    [("15 mm, like the backdrop", 50), ("15 mm, dark", 50), ("tip, dark", 80), ("base, dark", 8)],
)
def test_what_hides_the_robot_is_before_it_in_one_view_alone(plain, level, arc_mm):
    off = changed_at(plain, f"hidden in one view: {level}")

    assert np.linalg.norm(off - point(arc_mm), axis=1).max() < 25
    assert len(changed_at(plain, f"hidden in one view: {level}", "right")) < 5


def test_a_shadow_is_dark_beside_the_robot_and_leaves_the_robot_alone():
    # it hangs down to where its shadow falls
    lying = Level(name="lying", bench=PLAIN.bench, motion=towards(0.5, 1.4, 0.8))
    clear = shown(lying.pictures(1, 0.0)["left"])
    cast = shown(dataclasses.replace(lying, optics=shadow(0.6)).pictures(1, 0.0)["left"])
    darker = cv2.blur(clear - cast, (3, 3)).max(axis=2)
    robot = project(PLAIN.bench.rig[0], lying.moves(1).at(0.0)[5:75])
    columns, rows = np.rint(robot).astype(int).T

    assert np.count_nonzero(darker > 30) > 200
    assert darker[rows, columns].max() < 15


def test_a_second_object_ends_on_the_robot_or_stands_off(plain):
    touching = changed_at(plain, "two objects: touching the tip")
    apart = changed_at(plain, "two objects: 40 mm apart")

    assert np.linalg.norm(touching - point(80), axis=1).min() < 3
    assert np.linalg.norm(apart - point(40), axis=1).min() > 15


def test_dust_is_everywhere_and_glare_is_white_where_it_is(plain):
    specks = changed_at(plain, "dust: 1000 specks")
    column, row = np.rint(point(50)).astype(int)

    assert np.ptp(specks, axis=0).min() > 200
    assert pictures("glare: on the robot")["left"][row, column].min() > 240


def test_two_cameras_are_swapped_or_lost():
    coded = PLAIN.pictures(1, 0.0)

    assert cheap(LEVELS["cameras swapped: 2 of 2"]).pictures(1, 0.0) == {
        "left": coded["right"],
        "right": coded["left"],
    }
    assert set(cheap(LEVELS["camera lost: 1 of 2"]).pictures(1, 0.0)) == {"right"}
    assert set(cheap(LEVELS["camera lost: 2 of 4"]).pictures(1, 0.0)) == {"right", "side"}


def test_late_pictures_are_of_another_moment():
    coded, before = PLAIN.pictures(1, 0.0), PLAIN.pictures(1, -FRAME_S)
    frozen = cheap(LEVELS["stale picture: frozen camera"])

    assert frozen.pictures(1, 0.0) == {"left": before["left"], "right": coded["right"]}
    assert frozen.pictures(1, 2 * FRAME_S)["left"] == before["left"]
    captured = LEVELS["skew: 12 ms"].captured
    assert captured("right", 1.0) - captured("left", 1.0) == pytest.approx(0.012)


def tangents(name, arc_mm):
    level = LEVELS[name]
    line = level.moves(1).at(0.0)
    return line[arc_mm] - line[arc_mm - 1], line[arc_mm]


def angle(one, other):
    return np.rad2deg(np.arccos(one @ other / np.linalg.norm(one) / np.linalg.norm(other)))


@pytest.mark.parametrize("degrees", [20, 10, 5, 0])
def test_hard_directions_are_met(degrees):
    left, right = REFERENCE.rig
    along, _ = tangents(f"along epipolar line: {degrees} degrees off", 70)
    aim, tip = tangents(f"straight at a camera: {degrees} degrees off", 80)

    assert angle(along, eye(right) - eye(left)) == pytest.approx(degrees, abs=3)
    assert angle(aim, eye(left) - tip) == pytest.approx(degrees, abs=4)


def test_an_overlapping_robot_meets_its_own_picture():
    seen = project(REFERENCE.rig[0], LEVELS["self-overlap: left view"].moves(1).at(0.0))

    assert np.linalg.norm(seen[80] - seen[:40], axis=1).min() < 10


@pytest.mark.parametrize(
    ("name", "lowest", "highest"), [("upper part", 1, 70), ("one side", 1, 81), ("wholly", 0, 0)]
)
def test_a_robot_out_of_view_is(name, lowest, highest):
    level = LEVELS[f"out of view: {name}"]
    camera = level.bench.rig[0]
    inside = [
        int(((pixels >= 0) & (pixels < [camera.width_px, camera.height_px])).all(axis=1).sum())
        for pixels in (project(camera, level.moves(number).at(0.0)) for number in range(4))
    ]

    assert lowest <= min(inside)
    assert max(inside) <= highest


def test_rigs_stand_as_they_say():
    for degrees in (20, 40, 90, 120):
        one, other = (
            eye(camera)[:2] for camera in LEVELS[f"angle between cameras: {degrees} degrees"].bench.rig
        )
        assert angle(one, other) == pytest.approx(degrees)
    near, far = (eye(LEVELS[f"distance: {mm} mm"].bench.rig[0]) for mm in (130, 450))
    assert np.linalg.norm(far[:2]) / np.linalg.norm(near[:2]) == pytest.approx(450 / 130)
    middle = np.array([[0.0, 0.0, LENGTH_MM / 2]])
    [small_camera, _] = sized(640, 480)
    assert 0 < project(small_camera, middle)[0, 0] < 640
    assert [len(LEVELS[f"cameras: {count}"].bench.rig) for count in (3, 4)] == [3, 4]


@pytest.mark.parametrize(
    "level",
    [level for case in CASES if case.name == "calibration" for level in case.levels],
    ids=lambda level: level.name,
)
def test_a_wrong_calibration_is_wrong_about_one_camera(level):
    (left, right), (taken_for, same) = level.bench.rig, level.believed(level.bench.rig)
    off = np.abs(project(left, level.moves(1).at(0.0)) - project(taken_for, level.moves(1).at(0.0))).max()

    assert same is right
    assert 0.3 < off < 60
    if level.name.startswith("turned"):
        assert off == pytest.approx(float(level.name.split()[1]), rel=0.2)
