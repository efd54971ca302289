"""Scenes of the simulated bench: who may set them, when they are answered, and what a camera then sees."""

import threading

import numpy as np
import pytest

from drivers.simulated.cameras.projection import Lens
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.schedule import Pose
from drivers.simulated.cameras.subjects import BoardBeforeHolder, EmptyHolder, RobotInHolder
from drivers.simulated.hands import Hands
from drivers.simulated.scenes import Scenes
from messaging.board import BoardPlace
from messaging.scene import Scene, SceneRequest
from messaging.session import open_rendezvous, open_session
from messaging.topics import SIMULATION_SCENE

AT_BASE = BoardPlace(origin_mm=(-45, 0, 77), x_axis=(1, 0, 0), y_axis=(0, 0, -1))
STRAIGHT_MM = np.column_stack([np.zeros(81), np.zeros(81), np.linspace(0, 80, 81)])


class Camera:
    """How far one camera's pictures are."""

    scene = 0


@pytest.fixture
def bench(zenoh_settings, eventually):
    with (
        open_rendezvous(zenoh_settings, "scenes"),
        open_session(zenoh_settings, "scenes", "simulation") as simulation,
        open_session(zenoh_settings, "scenes", "asking") as asking,
    ):
        yield Bench(simulation, asking, eventually)


class Bench:
    """Scenes that are attended while somebody asks for one."""

    def __init__(self, simulation, asking, eventually, at_base=AT_BASE):
        lenses = [Lens(camera) for camera in default_cameras()]
        self.cameras = [Camera(), Camera()]
        self.at_base = at_base
        self.scenes = Scenes(
            simulation,
            self.cameras,
            Hands(np.array([90.0, 70.0]), lenses, np.array([0.0, 0.0, 40.0]), 1),
            at_base,
        )
        self._asking, self._eventually = asking, eventually

    def ask(self, scene):
        """Replies come into the list that is returned."""
        replies = []
        request = SceneRequest(scene=scene)
        threading.Thread(
            target=lambda: replies.append(self._asking.ask(SIMULATION_SCENE, request, 20.0)), daemon=True
        ).start()
        return replies

    def attend_until(self, condition, insertion_mm=0.0, time_ns=0):
        pose = Pose(time_ns, STRAIGHT_MM + np.array([0, 0, insertion_mm]))

        def attended():
            self.scenes.attend(pose)
            return condition()

        self._eventually(attended)

    def set(self, scene, **where):
        """Set it, with cameras that follow at once, and return the answer."""
        replies = self.ask(scene)

        def answered():
            for camera in self.cameras:
                camera.scene = self.scenes.number
            return replies

        self.attend_until(answered, **where)
        return replies[0]

    def subject(self, opened_s=0.0, closed_s=0.006):
        poses = [Pose(int(time_s * 1e9), STRAIGHT_MM) for time_s in (opened_s, closed_s)]
        return self.scenes.subject(*poses)


def test_a_scene_is_answered_only_when_every_camera_has_shown_it(bench):
    replies = bench.ask(Scene.EMPTY)
    bench.attend_until(lambda: bench.scenes.number == 1)
    bench.cameras[0].scene = 1
    for _ in range(50):
        bench.attend_until(lambda: True)
    assert not replies
    bench.cameras[1].scene = 1
    bench.attend_until(lambda: replies)
    assert replies[0].accepted
    assert replies[0].state == "empty"


def test_each_scene_is_seen_as_what_it_is(bench):
    assert isinstance(bench.subject(), RobotInHolder)
    assert bench.scenes.robot_is_seen
    assert bench.set(Scene.EMPTY).accepted
    assert isinstance(bench.subject(), EmptyHolder)
    assert bench.set(Scene.BOARD_AT_BASE).accepted
    at_base = bench.subject()
    np.testing.assert_array_equal(at_base.opened, AT_BASE.robot_from_board)
    assert bench.set(Scene.BOARD, time_ns=5_000_000_000).accepted
    held, moving = bench.subject(5.1, 5.106), bench.subject(5.8, 5.806)
    assert isinstance(held, BoardBeforeHolder)
    np.testing.assert_array_equal(held.opened, held.closed)
    assert not np.allclose(moving.opened, moving.closed)
    assert not bench.scenes.robot_is_seen
    assert bench.set(Scene.ROBOT).accepted
    assert bench.scenes.robot_is_seen


def test_hands_begin_anew_each_time_the_board_is_asked_for(bench):
    bench.set(Scene.BOARD, time_ns=0)
    first = bench.subject(3.0, 3.0).opened
    bench.set(Scene.BOARD, time_ns=7_000_000_000)
    np.testing.assert_array_equal(bench.subject(10.0, 10.0).opened, first)


def test_a_board_at_the_base_needs_a_place_and_the_stage_at_zero(bench):
    refused = bench.set(Scene.BOARD_AT_BASE, insertion_mm=12.5)
    assert not refused.accepted
    assert "stage stands at 12.50 mm" in refused.reason
    bench.scenes._at_base = None
    refused = bench.set(Scene.BOARD_AT_BASE)
    assert not refused.accepted
    assert "no [board.at_base]" in refused.reason
    assert bench.scenes.robot_is_seen
    assert refused.state == "robot"


def test_whoever_is_overtaken_by_another_request_is_told(bench):
    first = bench.ask(Scene.EMPTY)
    bench.attend_until(lambda: bench.scenes.number == 1)
    assert bench.set(Scene.BOARD).accepted
    bench.attend_until(lambda: first)
    assert not first[0].accepted
    assert "asked for before this one stood" in first[0].reason
