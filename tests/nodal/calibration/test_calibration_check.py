"""Whether a camera that was bumped is seen, and one that was not is left alone."""

import dataclasses
import json
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from messaging.frames import Frame
from messaging.topics import CAMERA
from nodal.__main__ import main
from nodal.bench_file import load_bench
from nodal.calibration.check.scenery import Motion, Scenery
from nodal.calibration.check.tracks import Sighting, Track, tracks
from nodal.calibration.check.verdict import judged
from nodal.calibration_file import save_rig
from nodal.toml_file import read_table, written
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter
from sensing.geometry.camera import Camera
from sensing.scene import Scene

WIDTH, HEIGHT = 480, 320
BEGIN_NS = 1_780_000_000_000_000_000
NS_PER_S = 1_000_000_000


def scenery(right_px=0.0, down_px=0.0, turn_rad=0.0, light=1.0, seed=0, rod=False):
    """A dark block on a bright backdrop with a fold, with soft edges at exact places; with noise."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    middle = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    turn = np.array([[np.cos(turn_rad), -np.sin(turn_rad)], [np.sin(turn_rad), np.cos(turn_rad)]])

    def inside(*corners):
        points = (np.array(corners, dtype=np.float64) - middle) @ turn.T + middle + [right_px, down_px]
        share = np.ones_like(x)
        for (x0, y0), (x1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
            within = ((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / np.hypot(x1 - x0, y1 - y0)
            share = share * ndtr(within / 0.8)
        return share

    picture = 150 - 90 * inside((180, 200), (290, 190), (300, 280), (185, 290))
    picture = picture - 30 * inside((60, 40), (70, 40), (90, 200), (80, 200))
    if rod:
        picture[20:200, 230:250] = 30
    noise = np.random.default_rng(seed).normal(0, 1.5, picture.shape)
    return np.clip(np.rint(light * picture + noise), 0, 255).astype(np.uint8)


NOTHING = np.zeros((HEIGHT, WIDTH), dtype=bool)
KNOWN = Scenery(scenery())


@settings(max_examples=15, deadline=None)
@given(
    right_px=st.floats(-25, 25), down_px=st.floats(-25, 25), turn_rad=st.floats(-0.01, 0.01), light=st.floats(0.6, 1.5)
)  # fmt: skip
def test_a_shift_and_a_turn_are_told_whatever_the_light(right_px, down_px, turn_rad, light):
    seen = scenery(right_px, down_px, turn_rad, light, seed=1)
    motion = KNOWN.motion(seen, NOTHING, NOTHING, np.zeros(2))
    middle = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    assert motion.at(middle) == pytest.approx([right_px, down_px], abs=0.03)
    assert motion.turn_rad == pytest.approx(turn_rad, abs=2e-4)
    assert motion.alike > 0.9


def test_what_it_says_of_itself_is_about_right():
    shifts = [
        KNOWN.motion(scenery(0.3, 0.2, seed=seed), NOTHING, NOTHING, np.zeros(2)) for seed in range(2, 12)
    ]
    spread = np.array([motion.shift_px for motion in shifts]).std(axis=0).max()
    said = np.median([motion.sigma_px for motion in shifts])
    assert spread < said < 4 * spread


def test_the_robot_is_no_scenery():
    hidden = NOTHING.copy()
    hidden[10:205, 222:258] = True
    motion = KNOWN.motion(scenery(0.0, 0.0, seed=3, rod=True), hidden, NOTHING, np.zeros(2))
    assert np.abs(motion.shift_px).max() < 0.05


def test_what_the_stage_carries_is_expected_elsewhere():
    carried = NOTHING.copy()
    carried[170:310, 160:320] = True
    holder_only = Scenery(np.where(carried, scenery(), 150).astype(np.uint8))
    seen = scenery(0.5, -12.0, seed=4)
    motion = holder_only.motion(seen, NOTHING, carried, np.array([0.0, -12.0]))
    assert motion.shift_px == pytest.approx([0.5, 0.0], abs=0.05)


def test_an_empty_wall_tells_nothing():
    plain = np.clip(150 + np.random.default_rng(5).normal(0, 2, (HEIGHT, WIDTH)), 0, 255).astype(np.uint8)
    assert Scenery(plain).motion(plain, NOTHING, NOTHING, np.zeros(2)) is None


def camera(name="left"):
    return Camera(next(one for one in load_bench("simulated").rig if one.camera == name))


def seen_at(shifts, name="left", turn_rad=0.0, sigma_px=0.02, alike=0.99):
    """A track of these shifts, one each second."""
    track = Track(camera=camera(name))
    for number, shift in enumerate(shifts):
        motion = Motion(
            about_px=np.zeros(2), shift_px=np.array(shift), turn_rad=turn_rad, sigma_px=sigma_px, alike=alike
        )
        track.sightings.append(
            Sighting(time_ns=BEGIN_NS + number * NS_PER_S, insertion_mm=0.0, motion=motion, fixed=motion)
        )
    return track


def said(flags=(), refusal=""):
    return SimpleNamespace(
        refusal=refusal, flags=flags, ray_bias_mm=0.05, camera_names=("left", "right"), camera_residual_px=(0.1, 0.1)
    )  # fmt: skip


def verdict(*found, estimates=None):
    return judged(found, estimates or [said()], np.array([0.0, 0.0, 40.0]), BEGIN_NS)


STILL = [(0.02, -0.03), (-0.05, 0.04), (0.06, 0.0), (0.0, 0.08), (0.03, -0.02)]
JOLTED = [*STILL, *((x + 0.8, y) for x, y in STILL)]


def test_the_moment_of_a_jolt_is_told():
    found = verdict(seen_at(JOLTED), seen_at(STILL, "right"))
    left, right = found.cameras
    assert (left.moved, right.moved, found.fine) == (True, False, False)
    assert left.since_s == 5.0
    assert left.shift_px == pytest.approx((0.82, 0.0), abs=0.05)
    assert left.robot_mm == pytest.approx(0.82 / camera().px_per_mm(np.array([[0.0, 0, 40]]))[0], abs=0.01)
    assert found.verdict == "camera left has moved"
    assert "nodal calibrate cameras" in found.advice


def test_one_that_moved_before_has_no_moment():
    (left,) = verdict(seen_at([(x + 2, y) for x, y in STILL])).cameras
    assert (left.moved, left.since_s) == (True, None)


def test_cameras_that_moved_together_need_their_frame_alone():
    both = verdict(seen_at(JOLTED), seen_at(JOLTED, "right"))
    assert "agree with one another" in both.verdict
    assert "nodal calibrate cameras" not in both.advice
    apart = verdict(seen_at(JOLTED), seen_at(JOLTED, "right"), estimates=[said(("calibration_off",))])
    assert "nodal calibrate cameras" in apart.advice


def test_sensing_is_heard_where_the_scenery_stands():
    found = verdict(
        seen_at(STILL), seen_at(STILL, "right"), estimates=[said(("calibration_off",))] * 3 + [said()]
    )
    assert not found.fine
    assert "contradict one another" in found.verdict
    assert found.sensing.share_off == 0.75


@pytest.mark.parametrize(
    ("track", "moved", "reason"),
    [
        (seen_at(STILL), False, ""),
        (seen_at(STILL, turn_rad=0.004), True, ""),
        (seen_at(STILL, sigma_px=0.5), None, "tells a motion to 0.50 px only"),
        (seen_at(JOLTED, sigma_px=0.5), None, "tells a motion to 0.50 px only"),
        (seen_at(JOLTED, alike=0.3), None, "shows other scenery than the background picture"),
        (Track(camera=camera()), None, "none of its pictures can be used"),
        (Track(camera=camera(), sightings=[Sighting(time_ns=0, insertion_mm=0, motion=None, fixed=None)]), None, "too little stands still"),
    ],
)  # fmt: skip
def test_what_scenery_cannot_tell_it_does_not_say(track, moved, reason):
    (found,) = verdict(track).cameras
    assert found.moved is moved
    assert reason in found.reason


@pytest.fixture(scope="module")
def bench(tmp_path_factory, light_bench):
    """A bench of half-size pictures with backgrounds, its renderers, and those of a left camera that was turned by 1 mrad."""
    folder = tmp_path_factory.mktemp("checked")
    loaded = load_bench(light_bench)
    save_rig(folder / "rig.json", loaded.rig)

    def rendered(calibration, seed):
        return Renderer(calibration, np.array([40.0, 80.0]), SimulatedCamerasSettings(), seed)

    studio = {one.camera: rendered(one, seed) for seed, one in enumerate(loaded.rig)}
    turn, pose = cv2.Rodrigues(np.array([0.0, 1e-3, 0.0]))[0], loaded.rig[0].camera_from_robot.copy()
    pose[:3] = turn @ pose[:3]
    turned = rendered(dataclasses.replace(loaded.rig[0], camera_from_robot=pose), 7)
    table = read_table(light_bench)
    table["sensing"]["background"] = {name: f"{name}.jpg" for name in studio}
    (folder / "bench.toml").write_text(written(table), encoding="utf-8")
    for name, renderer in studio.items():
        (folder / f"{name}.jpg").write_bytes(renderer.render_empty(np.zeros(3)))
    return SimpleNamespace(folder=folder, studio=studio, turned=turned, config=str(folder / "bench.toml"))


def pose_mm(bend_rad, insertion_mm=0.0):
    arc = np.linspace(0, 1, 81)
    x = np.array([(1 - np.cos(bend_rad * a)) / bend_rad for a in arc]) * 80
    return np.column_stack([x, 0 * x, np.sin(bend_rad * arc) / bend_rad * 80 + insertion_mm])


def recorded(bench, out, bumped_from=99, damaged=()):
    """Eight frame sets of a robot that bends, one each second; the left camera is the turned one from a set on."""
    with RecordingWriter(out, RecorderSettings()) as recording:
        for number in range(8):
            centreline = pose_mm(0.2 + 0.1 * number)
            for name, renderer in bench.studio.items():
                seen = bench.turned if name == "left" and number >= bumped_from else renderer
                time_ns = BEGIN_NS + number * NS_PER_S
                jpeg = b"\xff\xd8" if (name, number) in damaged else seen.render(centreline, centreline)
                frame = Frame(camera=name, capture_time_ns=time_ns, jpeg=jpeg)
                recording.write(
                    CAMERA.named(name).key, Frame.protobuf, frame.to_bytes(), sequence=number, publish_time_ns=time_ns, log_time_ns=time_ns
                )  # fmt: skip
    return str(out)


def test_a_bumped_camera_in_a_recording_is_named_with_the_moment(bench, tmp_path, capsys):
    log = recorded(bench, tmp_path / "bumped.mcap", bumped_from=3)
    assert main(["calibration", "check", "--config", bench.config, "--recording", log, "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    left, right = found["cameras"]
    assert (left["moved"], right["moved"]) == (True, False)
    assert left["since_s"] == pytest.approx(3.0)
    # 1 mrad of a focal length of 720 px
    assert np.hypot(*left["shift_px"]) == pytest.approx(0.72, abs=0.08)
    assert left["angle_deg"] == pytest.approx(np.degrees(1e-3), rel=0.2)
    assert main(["calibration", "check", "--config", bench.config, "--recording", log]) == 3
    assert "camera left has moved" in capsys.readouterr().out


def test_cameras_that_stand_are_left_alone_by_pictures_that_cannot_be_used(bench, tmp_path, capsys):
    log = recorded(bench, tmp_path / "still.mcap", damaged=(("right", 2), ("left", 5)))
    assert main(["calibration", "check", "--config", bench.config, "--recording", log]) == 0
    shown = capsys.readouterr().out
    assert shown.count("where it was") == 2
    assert "fine: no camera has moved" in shown


@pytest.mark.parametrize("insertion_mm", [0.0, 12.0])
def test_a_holder_that_the_stage_has_lifted_is_no_bump(bench, insertion_mm):
    loaded = load_bench(bench.config)
    scene = Scene.on_bench(loaded.settings.sensing, loaded.settings.robot, loaded.rig, loaded.backgrounds)
    looks = []
    for number, lift_mm in enumerate([insertion_mm, insertion_mm + 4.0]):
        line = pose_mm(0.3, lift_mm)
        estimate = SimpleNamespace(refusal="", insertion_mm=lift_mm, centreline_mm=line)
        jpegs = {name: renderer.render(line, line) for name, renderer in bench.studio.items()}
        looks.append(SimpleNamespace(time_ns=number, jpegs=jpegs, estimate=estimate))
    references = {name: cv2.imread(str(bench.folder / f"{name}.jpg")) for name in bench.studio}
    for track in tracks(scene, references, 0.0, looks):
        for _, motion in track.motions:
            assert np.linalg.norm(motion.shift_px) < max(0.1, 2 * motion.sigma_px)
    assert verdict(*tracks(scene, references, 0.0, looks)).cameras[0].moved is not True


def test_a_bench_without_backgrounds_says_how_to_get_them(light_bench, bench, tmp_path, capsys):
    log = recorded(bench, tmp_path / "log.mcap")
    assert main(["calibration", "check", "--config", str(light_bench), "--recording", log]) == 2
    assert "`nodal calibrate background` takes them" in capsys.readouterr().err


def test_a_recording_of_other_cameras_is_refused(bench, tmp_path, capsys):
    with RecordingWriter(tmp_path / "log.mcap", RecorderSettings()):
        pass
    words = ["calibration", "check", "--config", bench.config, "--recording", str(tmp_path / "log.mcap")]
    assert main(words) == 2
    assert "no frame sets of the cameras left, right are in it" in capsys.readouterr().err
