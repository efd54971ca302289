"""Sensing whose cameras are files: it hears them to their end, and then it is done."""

import threading
from pathlib import Path

from drivers.cameras import FolderCameraSettings
from messaging import topics
from messaging.session import open_rendezvous, open_session
from messaging.settings import RobotSettings
from nodal.calibration_file import load_rig
from recordings.log import Log
from sensing.process import run
from sensing.settings import NodalPointSetting, SensingSettings

DATA = Path(__file__).parents[1] / "data"
PICTURES = 4
ENDS_WITHIN_S = 30


def test_sensing_ends_when_every_camera_has_ended(tmp_path, zenoh_settings, eventually) -> None:
    cameras = {}
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
        for number, recorded in zip(
            range(PICTURES), Log(DATA / "run.mcap").messages((topics.CAMERA.named(name),)), strict=False
        ):
            (tmp_path / name / f"{number}.jpg").write_bytes(recorded.message.jpeg)
        cameras[name] = FolderCameraSettings(folder=str(tmp_path / name), rate_hz=5.0)
    with (
        open_rendezvous(zenoh_settings, "files"),
        open_session(zenoh_settings, "files", "outside") as outside,
        open_session(zenoh_settings, "files", "sensing") as session,
    ):
        shapes = outside.every(topics.SHAPE, 100)
        eventually(lambda: {"sensing", "outside"} <= outside.alive())
        settings = SensingSettings(nodal_points=(NodalPointSetting(name="tip", arc_mm=80.0),))
        robot, rig = RobotSettings(section_length_mm=(40.0, 40.0)), load_rig(DATA / "small-rig.json")
        stop = threading.Event()
        sensing = threading.Thread(
            target=run, args=(settings, robot, rig, {}, cameras, session, stop, lambda: None)
        )
        sensing.start()
        sensing.join(ENDS_WITHIN_S)
        ended = not sensing.is_alive()
        stop.set()
        sensing.join()
        assert ended
        assert eventually(shapes.take)
