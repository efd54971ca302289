"""Backgrounds: what is written, what is refused, and what is said about light and backdrop."""

import contextlib
import dataclasses
import json
from types import SimpleNamespace

import cv2
import msgspec
import numpy as np
import pytest

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from nodal.__main__ import main
from nodal.bench_file import load_bench, read_bench
from nodal.calibrate.background import taking
from nodal.calibrate.background.area import Reach, holder_mask, reach_mask, work_area
from nodal.calibrate.background.judging import judged, refusals
from nodal.calibrate.background.keeping import stage_of
from nodal.calibrate.background.robot import robot_seen
from nodal.calibrate.background.statistics import Pictures
from nodal.calibrate.background.warnings import warnings
from nodal.calibration_file import save_rig
from nodal.toml_file import read_table, written
from sensing.geometry.camera import Camera
from sensing.pictures.grid import Grid
from sensing.scene import Scene

REACH = Reach(length_mm=80.0, travel_mm=(0.0, 40.0), holder_radius_mm=25.0)
SIZE = (540, 960, 3)


@pytest.fixture(scope="module")
def studio(light_bench):
    """Renderers of half-size cameras by name, and their rig."""
    rig = load_bench(light_bench).rig
    made = {
        one.camera: Renderer(one, np.array([40.0, 80.0]), SimulatedCamerasSettings(), seed)
        for seed, one in enumerate(rig)
    }
    empty = {name: [renderer.render_empty(np.zeros(3)) for _ in range(6)] for name, renderer in made.items()}
    line = np.column_stack([np.zeros((81, 2)), np.arange(81.0)])
    robot = {name: renderer.render(line, line) for name, renderer in made.items()}
    return SimpleNamespace(rig=rig, empty=empty, robot=robot)


def decoded(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)


def seen(pictures):
    taken = Pictures()
    for picture in pictures:
        taken.add(picture)
    return taken.statistics()


def noisy(count=8, sigma=2.0, level=150.0, seed=0):
    random = np.random.default_rng(seed)
    return [np.clip(np.rint(level + sigma * random.standard_normal(SIZE)), 0, 255).astype(np.uint8) for _ in range(count)]  # fmt: skip


def about(pictures, camera=None):
    return judged("left", seen(pictures), camera, REACH, 0.0)


def said(pictures, camera=None):
    return " / ".join(warnings(about(pictures, camera)))


@pytest.mark.parametrize("count", [1, 8])
def test_noise_is_measured_and_taken_out(count):
    statistics = seen(noisy(count))
    assert statistics.noise == pytest.approx([2.0, 2.0, 2.0], rel=0.1)
    if count > 1:
        assert statistics.mean.astype(float).std() < 2.0 / np.sqrt(count) * 1.2
    assert statistics.stirred == ()
    assert said(noisy(count)) == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda picture, _: picture // 4, "the backdrop is dark (level 37 of 255)"),
        (lambda picture, _: np.full(SIZE, 255, np.uint8), "100.0% of what the robot can be seen before is too bright"),
        (lambda picture, number: (picture * (1 + 0.03 * (-1) ** number)).astype(np.uint8), "the light flickers by 3.0%"),
        (lambda picture, _: (picture * np.linspace(0.5, 1.3, 960)[:, None]).astype(np.uint8), "the light is uneven: brightness differs by"),
        (lambda picture, _: cv2.circle(picture.copy(), (400, 200), 20, (215, 215, 215), -1), "1 bright spot (glare?), the largest about 400, 200 px"),
        (lambda picture, _: cv2.rectangle(picture.copy(), (600, 100), (660, 260), (90, 60, 60), -1), "1 thing on the backdrop within the robot's reach, the largest about 630, 180 px"),
        (lambda picture, _: cv2.rectangle(picture.copy(), (840, 0), (960, 540), (40, 60, 90), -1), "the backdrop ends within the robot's reach"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_what_to_do(change, words):
    assert words in said([change(picture, number) for number, picture in enumerate(noisy())])


def test_noise_in_one_place_and_everywhere_is_told():
    assert "the pictures are noisy (sigma 9" in said(noisy(sigma=9.0))
    loud, calm = noisy(sigma=12.0, seed=1), noisy()
    for one, other in zip(calm, loud, strict=True):
        one[120:240, 480:640] = other[120:240, 480:640]
    assert "times as noisy as elsewhere" in said(calm)


def test_a_soft_shadow_is_no_thing():
    y, x = np.mgrid[:540, :960]
    shadow = 1 - 0.25 * np.exp(-(((x - 480) / 90) ** 2) - ((y - 250) / 120) ** 2)
    found = about([(picture * shadow[..., None]).astype(np.uint8) for picture in noisy()])
    assert found.spots == ()


def test_what_walks_through_is_refused():
    pictures = noisy(12)
    cv2.rectangle(pictures[5], (300, 100), (340, 180), (90, 90, 90), -1)
    (reason,) = refusals(seen(pictures), None, REACH, 0.0, stage_heard=False)
    assert "something moved while the pictures were taken, about 32" in reason


def test_a_robot_that_was_forgotten_is_refused_and_an_empty_holder_is_not(studio):
    for calibration in studio.rig:
        camera, name = Camera(calibration), calibration.camera
        empty = seen([decoded(jpeg) for jpeg in studio.empty[name]])
        assert list(refusals(empty, camera, REACH, 0.0, stage_heard=False)) == []
        for heard in (True, False):
            with_robot = seen([decoded(studio.robot[name])])
            (reason,) = refusals(with_robot, camera, REACH, 0.0, stage_heard=heard)
            assert "is the robot still in its holder?" in reason
            assert ("It was not heard, and is taken to stand at 0 mm" in reason) is not heard
        assert list(warnings(judged(name, empty, camera, REACH, 0.0))) == []


def test_all_that_the_robot_can_reach_lies_in_the_work_area(studio):
    random = np.random.default_rng(3)
    for calibration in studio.rig:
        camera = Camera(calibration)
        grid = Grid.of(camera.size_px)
        corners = work_area(camera, REACH, np.zeros(grid.shape, np.uint8))
        for _ in range(200):
            bends, heads = random.uniform(0, 2.4, 2), random.uniform(-np.pi, np.pi, 2)
            lift = np.array([0, 0, random.uniform(*REACH.travel_mm)])
            for x, y in camera.project(np.ascontiguousarray(bent(bends, heads) + lift)):
                if 0 <= x < camera.size_px[0] and 0 <= y < camera.size_px[1]:
                    assert cv2.pointPolygonTest(corners.astype(np.float32), (float(x), float(y)), True) > -1.0


def bent(bends, heads):
    """Two circular arcs of 40 mm, one after the other: points (82, 3)."""
    points, frame, base = [], np.eye(3), np.zeros(3)
    for bend, head in zip(bends, heads, strict=True):
        angles = np.linspace(0, bend, 41) + 1e-9
        arc = 40 / (bend + 1e-9) * np.column_stack([(1 - np.cos(angles)) * np.cos(head), (1 - np.cos(angles)) * np.sin(head), np.sin(angles)])  # fmt: skip
        points.append(base + arc @ frame.T)
        base = points[-1][-1]
        frame = frame @ cv2.Rodrigues(bend * np.array([-np.sin(head), np.cos(head), 0.0]))[0]
    return np.concatenate(points)


def test_the_work_area_ends_where_the_backdrop_does(studio):
    camera = Camera(studio.rig[0])
    beyond = np.zeros(Grid.of(camera.size_px).shape, np.uint8)
    beyond[:, 600:] = 255
    assert work_area(camera, REACH, beyond)[:, 0].max() < 600 * Grid.of(camera.size_px).step
    # what would take the base away is not cut
    beyond[:] = 255
    assert (work_area(camera, REACH, beyond) == work_area(camera, REACH, 0 * beyond)).all()
    assert not (reach_mask(camera, REACH) & holder_mask(camera, REACH, 0.0)).all()


@pytest.fixture
def bench(tmp_path, studio, light_bench):
    """A bench whose cameras are calibrated, with pictures of the empty holder and of the robot in folders."""
    save_rig(tmp_path / "rig.json", studio.rig)
    table = read_table(light_bench)
    (tmp_path / "bench.toml").write_text("# my bench\n" + written(table), encoding="utf-8")
    for name, jpegs in studio.empty.items():
        (tmp_path / "empty" / name).mkdir(parents=True)
        (tmp_path / "robot" / name).mkdir(parents=True)
        for number, jpeg in enumerate(jpegs):
            (tmp_path / "empty" / name / f"{number}.jpg").write_bytes(jpeg)
        (tmp_path / "robot" / name / "0.jpg").write_bytes(studio.robot[name])
    return tmp_path


def command(bench, what, *more):
    folders = [f"{name}={bench / what / name}" for name in ("left", "right")]
    return main(
        ["calibrate", "background", "--config", str(bench / "bench.toml"), "--images", *folders, *more]
    )


def test_backgrounds_and_work_areas_are_written_where_sensing_reads_them(bench, studio, capsys):
    assert command(bench, "empty", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert [camera["pictures"] for camera in found["cameras"]] == [6, 6]
    assert (bench / "bench.toml").read_text(encoding="utf-8").startswith("# my bench\n")
    loaded = load_bench(bench / "bench.toml")
    assert set(loaded.backgrounds) == set(loaded.settings.sensing.work_area) == {"left", "right"}
    assert stage_of(loaded) == 0.0
    mean = np.mean([decoded(jpeg).astype(float) for jpeg in studio.empty["left"]], axis=0)
    assert np.abs(decoded(loaded.backgrounds["left"]) - mean).mean() < 1.0
    assert (bench / "background-left-judged.jpg").exists()
    # and sensing takes them: the robot stands out from them
    scene = Scene.on_bench(loaded.settings.sensing, loaded.settings.robot, loaded.rig, loaded.backgrounds)
    estimate = SimpleNamespace(refusal="", flags=("base_unknown",), length_mm=80.0, insertion_mm=0.0)
    robot = robot_seen(scene, studio.robot, estimate)
    assert robot.fine
    assert all(contrast.robot > contrast.threshold > contrast.backdrop for contrast in robot.contrasts)


@pytest.mark.parametrize(("flags", "status"), [((), 0), (("hidden",), 3)])
def test_at_the_bench_the_robot_is_asked_away_and_back(bench, studio, monkeypatch, capsys, flags, status):
    asked = []
    session = SimpleNamespace(newest=lambda topic: SimpleNamespace(take=lambda: None))
    looks = iter(
        [
            [dict(zip(studio.empty, pair, strict=True)) for pair in zip(*studio.empty.values(), strict=True)],
            [studio.robot],
        ]
    )
    monkeypatch.setattr(taking, "running_cameras", lambda *_: contextlib.nullcontext(([], session)))
    monkeypatch.setattr(taking, "person_at", lambda *_: SimpleNamespace(please=asked.append))
    monkeypatch.setattr(taking, "taken", lambda *_: next(looks))
    monkeypatch.setattr(taking.Sensor, "estimate", flagged(taking.Sensor.estimate, flags))
    words = ["calibrate", "background", "--config", str(bench / "bench.toml"), "--json"]
    assert main(words) == status
    assert [str(scene) for scene in asked] == ["empty", "robot"]
    out, err = capsys.readouterr()
    assert ("next: nodal calibrate robot" in err) is (status == 0)
    robot = json.loads(out)["robot"]
    assert robot["length_mm"] == pytest.approx(80.0, abs=0.3)
    assert robot["flags"] == [*flags, "base_unknown"]


def flagged(estimate, flags):
    def changed(*arguments):
        found = estimate(*arguments)
        return dataclasses.replace(found, flags=(*flags, *found.flags))

    return changed


def test_a_refusal_leaves_everything_as_it_was(bench, capsys):
    before = (bench / "bench.toml").read_bytes()
    assert command(bench, "robot") == 3
    said = capsys.readouterr().err
    assert "camera left: something" in said
    assert "stage raised? It was not heard" in said
    assert (bench / "bench.toml").read_bytes() == before
    assert not list(bench.glob("background*"))


def test_before_the_robot_frame_is_known_there_is_no_work_area(bench, capsys):
    (bench / "rig.json").unlink()
    assert command(bench, "empty") == 0
    shown = capsys.readouterr()
    assert "there will be no work area" in shown.err
    assert "work area" not in shown.out
    settings = read_bench(bench / "bench.toml").settings.sensing
    assert set(settings.background) == {"left", "right"}
    assert settings.work_area == {}


def test_pictures_of_another_size_and_other_nonsense_are_one_line(bench, capsys):
    other = cv2.imencode(".jpg", np.zeros((480, 640, 3), np.uint8))[1].tobytes()
    for name in ("left", "right"):
        (bench / "robot" / name / "0.jpg").write_bytes(other)
    assert command(bench, "robot") == 2
    assert "its calibration is for 960x540 px" in capsys.readouterr().err
    assert command(bench, "empty", "--pictures", "0") == 2
    assert "--pictures 0: allowed is 1 or more" in capsys.readouterr().err


def test_sensing_that_sees_no_robot_is_told(studio):
    scene = Scene.of(studio.rig, backgrounds=studio.robot, length_mm=80.0)
    estimate = SimpleNamespace(refusal="nothing stands out", flags=(), length_mm=0.0, insertion_mm=0.0)
    robot = robot_seen(scene, studio.robot, estimate)
    assert not robot.fine
    assert all(
        contrast.threshold is None and "nothing stands out" in contrast.refusal
        for contrast in robot.contrasts
    )
    assert msgspec.json.decode(msgspec.json.encode(robot))["length_mm"] == 0.0
