"""The film: every frame set once, at its time, with what was made of that very set and of no other."""

import cv2
import numpy as np
import pytest

from messaging.control import State
from nodal.exports.video.captions import Tone, caption
from nodal.exports.video.film import scenes_of
from nodal.exports.video.scenes import SETTLED_NS, Scenes
from nodal.exports.video.stage import CENTRELINE, DESIRED, NODE, Stage
from nodal.log.spans import Span
from recordings import Log


def scenes_heard(*heard):
    """Scenes of (sequence, seconds, message)."""
    scenes = Scenes()
    found = []
    for sequence, at_s, message in heard:
        found += scenes.hear(sequence, round(1e9 * at_s), message)
    return found + list(scenes.rest())


@pytest.fixture
def frames(made):
    from messaging.frames import Frame  # noqa: PLC0415

    def both(number):
        return [
            Frame(camera=c.camera, capture_time_ns=made.capture_ns(number), jpeg=made.picture_of(c))
            for c in made.rig
        ]

    return both


@pytest.fixture
def story(made, frames):
    """What is heard of one frame set, at 50 ms for each."""

    def tell(number, *, shape=True, state=True):
        at_s = 0.05 * number
        left, right = frames(number)
        heard = [(number, at_s, left), (number, at_s, right)]
        if shape:
            heard.append((number, at_s + 0.06, made.shape_of(number)))
        if state:
            heard.append((7000 + number, at_s + 0.07, made.state_of(number)))
        return heard

    return tell


def in_order(*stories):
    return sorted((heard for story in stories for heard in story), key=lambda heard: heard[1])


def test_a_scene_holds_what_was_made_of_its_own_frames(story):
    scenes = scenes_heard(*in_order(*(story(number) for number in range(10, 14))))
    assert [scene.shape.sequence for scene in scenes] == [10, 11, 12, 13]
    assert all(scene.acted_on and scene.state.shape_sequence == scene.shape.sequence for scene in scenes)
    assert all(set(scene.frames) == {"left", "right"} for scene in scenes)


def test_a_set_without_an_estimate_borrows_none(story):
    first, bare, last = scenes_heard(*in_order(story(10), story(11, shape=False, state=False), story(12)))
    assert bare.shape is None
    assert not bare.acted_on
    assert first.acted_on
    assert last.acted_on


def test_an_estimate_that_nobody_acted_on_has_the_state_of_its_time(story):
    scenes = scenes_heard(*in_order(story(10), story(13, state=False), story(16)))
    assert not scenes[1].acted_on
    assert scenes[1].state.shape_sequence == 10


def test_the_target_is_the_one_that_the_controller_names(made, story):
    (scene,) = scenes_heard((0, 0.0, made.target), *story(10))
    assert scene.target is not None
    (without,) = scenes_heard((0, 0.0, made.target), *story(2))
    assert without.target is None


def test_numbers_that_begin_anew_are_not_mixed_up(made, story):
    again = [(n, at_s + 100, message) for n, at_s, message in story(10, shape=False, state=False)]
    scenes = scenes_heard(*story(10), *again)
    assert [scene.shape is None for scene in scenes] == [False, True]


def test_no_more_than_what_settles_is_held(story):
    scenes = Scenes()
    held = 0
    for number in range(200):
        for sequence, at_s, message in story(number % 30):
            now_ns = round(1e9 * (at_s + 0.05 * (number - number % 30)))
            list(scenes.hear(sequence, now_ns, message))
        held = max(held, len(scenes._drafts))
    assert held <= SETTLED_NS / 50e6 + 2


@pytest.mark.parametrize(
    ("number", "words", "tone"),
    [
        (12, "no shape: camera left: no robot in view", Tone.TROUBLE),
        (15, "not to be trusted: tip unseen", Tone.DOUBT),
        (10, "", Tone.PLAIN),
    ],
)
def test_refusals_and_flags_are_said_in_words(story, made, number, words, tone):
    (scene,) = scenes_heard(*story(number))
    said = caption(scene, made.start_ns)
    assert (said.remark, said.remark_tone) == (words, tone)


def test_the_caption_says_state_time_and_error(story, made):
    (scene,) = scenes_heard(*story(10))
    said = caption(scene, made.start_ns)
    assert said.doing == "tracking rise"
    assert "tracking error 0.50 mm" in said.figures
    assert said.time.startswith("0.50 s")
    (waiting,) = scenes_heard(*story(25))
    assert waiting.state.state is State.HOLD
    assert caption(waiting, made.start_ns).doing == "hold: the operator asked to hold"


def pixels(camera, points_mm, panel_width_px):
    """Where points are in a panel, without the code under test."""
    pose = camera.camera_from_robot
    seen, _ = cv2.projectPoints(
        points_mm, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], camera.intrinsics, camera.distortion
    )
    scale = panel_width_px / camera.width_px
    return np.rint((seen[:, 0] + 0.5) * scale - 0.5).astype(int)


def test_the_robot_is_drawn_where_each_camera_sees_it(story, made):
    stage = Stage(made.rig, 1920, made.start_ns)
    (scene,) = scenes_heard(*story(10))
    film = stage.drawn(scene)
    shape = made.shape_of(10)
    for number, camera in enumerate(made.rig):
        for points_mm, colour in ((shape.node_mm, NODE), (shape.centreline_mm[10:11], CENTRELINE)):
            for x, y in pixels(camera, points_mm, 960):
                assert film[y, x + 960 * number] == pytest.approx(colour, abs=3)
        shown = film[: stage.panels[0].height_px, 960 * number : 960 * (number + 1)]
        assert (np.abs(shown.astype(int) - DESIRED).max(axis=2) < 12).sum() > 50


def test_nothing_is_drawn_over_a_refused_picture(story, made):
    stage = Stage(made.rig, 1920, made.start_ns)
    (scene,) = scenes_heard(*story(made.refused))
    film = stage.drawn(scene)
    for x, y in pixels(made.rig[0], made.shape_of(10).centreline_mm, 960):
        assert film[y, x] == pytest.approx([made.grey] * 3, abs=4)


def test_a_camera_without_a_picture_says_so(story, made):
    heard = [one for one in story(10) if getattr(one[2], "camera", "") != "right"]
    (scene,) = scenes_heard(*heard)
    film = Stage(made.rig, 1920, made.start_ns).drawn(scene)
    assert film[200, 960 + 600].max() < 60
    assert film[200, 100] == pytest.approx([made.grey] * 3, abs=4)


def test_the_film_shows_every_set_at_its_time(nodal, recording, made, tmp_path):
    av = pytest.importorskip("av", reason="needs the extra `export`")
    out = tmp_path / "lean.mp4"
    answer = nodal("log", "export", recording, "--to", "mp4", "-o", out, "--width", "640")
    assert (answer.status, answer.err) == (0, [])
    assert f"{made.sets} pictures" in answer.out[0]
    with av.open(str(out)) as film:
        (stream,) = film.streams
        assert (stream.codec_context.name, stream.width, stream.height % 2) == ("h264", 640, 0)
        times = [frame.time for frame in film.decode(stream)]
    assert times == pytest.approx([0.05 * number for number in range(made.sets)], abs=1e-3)


def test_one_camera_and_a_stretch_of_time(nodal, recording, tmp_path):
    av = pytest.importorskip("av", reason="needs the extra `export`")
    out = tmp_path / "right.mp4"
    words = ("--width", "480", "--camera", "right", "--from", "0.5", "--until", "1")
    assert nodal("log", "export", recording, "--to", "mp4", "-o", out, *words).status == 0
    with av.open(str(out)) as film:
        pictures = [frame.to_ndarray(format="bgr24") for frame in film.decode(video=0)]
    assert len(pictures) == 10
    assert pictures[0].shape[1] == 480


def test_a_stretch_knows_the_target_that_was_accepted_before_it(recording, made):
    begin_ns = made.capture_ns(10)
    span = Span(beginning_ns=made.start_ns, start_ns=begin_ns, end_ns=begin_ns + 150_000_000)
    assert [scene.target.name for scene in scenes_of(Log(recording), span)] == ["rise"] * 3
