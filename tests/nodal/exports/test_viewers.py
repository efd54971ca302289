"""What viewers need to draw a recording: schemas that stand alone, frames that fit, and Rerun's own word for it.

Rerun is a development extra: without it these tests are skipped, but not where everything is tested (CI=true).
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader

VIEWERS = Path(__file__).parents[3] / "docs" / "viewers"
RERUN = Path(sys.executable).with_name("rerun")

DRAWN = {
    "/camera/left": {"EncodedImage:blob", "EncodedImage:media_type", "CoordinateFrame:frame"},
    "/camera/left/calibration": {"Pinhole:image_from_camera", "Pinhole:resolution", "Pinhole:parent_frame"},
    "/camera/left/pose": {"Transform3D:translation", "Transform3D:quaternion", "Transform3D:child_frame"},
    "/shape/centreline": {"Points3D:positions", "Points3D:colors", "CoordinateFrame:frame"},
    "/shape/nodal_points": {"Points3D:positions", "Points3D:colors", "CoordinateFrame:frame"},
    "/controller/desired": {"Points3D:positions", "Points3D:colors", "CoordinateFrame:frame"},
    "/target/path": {"Points3D:positions", "Points3D:colors", "CoordinateFrame:frame"},
    "/log": {"TextLog:text", "TextLog:level"},
}
"""What Rerun must have made of each topic, in place of raw bytes."""


@pytest.fixture(scope="module")
def published(recording):
    """By topic, every message read with nothing but the schema that stands in the file."""
    messages = {}
    with recording.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            messages.setdefault(channel.topic, []).append(_read(schema, message.data))
    return messages


_CLASSES = {}


def _read(schema, data):
    if schema.name not in _CLASSES:
        pool = DescriptorPool()
        for file in FileDescriptorSet.FromString(schema.data).file:
            pool.Add(file)
        _CLASSES[schema.name] = GetMessageClass(pool.FindMessageTypeByName(schema.name))
    return _CLASSES[schema.name].FromString(data)


def test_every_schema_stands_alone_and_fits_its_messages(recording, published):
    with recording.open("rb") as file:
        summary = make_reader(file).get_summary()
    for channel in summary.channels.values():
        assert channel.message_encoding == "protobuf"
        assert summary.schemas[channel.schema_id].encoding == "protobuf"
        assert channel.topic in published
    assert published["controller/state"][10].state == "tracking"
    assert published["shape"][10].node_names == ["middle", "tip"]


def test_pictures_calibrations_and_poses_name_the_same_frames(published):
    for camera in ("left", "right"):
        picture = published[f"camera/{camera}"][0]
        calibration = published[f"camera/{camera}/calibration"][0]
        pose = published[f"camera/{camera}/pose"][0]
        assert picture.frame_id == calibration.frame_id == pose.child_frame_id == camera
        assert pose.parent_frame_id == "robot"
    for drawn in ("shape/centreline", "shape/nodal_points", "controller/desired", "target/path"):
        assert {message.frame_id for message in published.get(drawn, [])} <= {"robot"}


def test_what_viewers_compute_from_pose_and_calibration_is_where_the_camera_sees_a_point(published, made):
    """Through the viewers' own data: quaternion and translation in m, then K."""
    point_m = np.array([0.01, -0.02, 0.06])
    for camera in made.rig:
        pose = published[f"camera/{camera.camera}/pose"][0]
        matrix = np.array(published[f"camera/{camera.camera}/calibration"][0].K).reshape(3, 3)
        q, t = pose.rotation, pose.translation
        vector, real = np.array([q.x, q.y, q.z]), q.w
        away = point_m - np.array([t.x, t.y, t.z])
        # the inverse rotation: with the conjugate of the unit quaternion
        seen = away + 2 * np.cross(-vector, np.cross(-vector, away) + real * away)
        pixel = (matrix @ seen)[:2] / seen[2]
        expected = camera.camera_from_robot[:3] @ [*(1000 * point_m), 1]
        assert pixel == pytest.approx((camera.intrinsics @ expected)[:2] / expected[2], abs=1e-6)


def test_the_layout_for_foxglove_names_what_is_recorded(published):
    layout = json.loads((VIEWERS / "foxglove-layout.json").read_text(encoding="utf-8"))
    panels = layout["configById"]
    assert set(_leaves(layout["layout"])) == set(panels)
    known = set(published) | {"controller/desired", "target/path"}
    for panel in panels.values():
        image = panel.get("imageMode", {})
        named = {*panel.get("topics", {}), *(image[key] for key in image if key.endswith("Topic"))}
        assert named <= known
        for path in panel.get("paths", ()):
            topic, _, field = path["value"].partition(".")
            assert field.partition("[")[0] in published[topic][0].DESCRIPTOR.fields_by_name


def _leaves(node):
    return [node] if isinstance(node, str) else _leaves(node["first"]) + _leaves(node["second"])


@pytest.fixture(scope="module")
def rerun(tmp_path_factory):
    """Run its command line, with a home of its own in which it is told to report nothing to anybody."""
    if not RERUN.exists():
        if os.environ.get("CI") == "true":
            pytest.fail(f"{RERUN} is missing; it is part of the extra `dev`")
        pytest.skip(f"{RERUN} is missing; it is part of the extra `dev`")
    home = tmp_path_factory.mktemp("home")
    quiet = {**os.environ, "HOME": str(home), "XDG_CONFIG_HOME": str(home), "XDG_DATA_HOME": str(home)}

    def run(*words):
        return subprocess.run(
            [RERUN, *words], env=quiet, capture_output=True, text=True, timeout=60, check=False
        )

    run("analytics", "disable")
    return run


@pytest.fixture(scope="module")
def converted(rerun, recording, tmp_path_factory):
    """By entity, its components with their first values, as Rerun keeps them after reading a part of the recording."""
    from rerun.chunk import RrdReader  # noqa: PLC0415  slow, and part of an extra

    found = {}
    for part in (recording, recording.with_name("lean.part2.mcap")):
        path = tmp_path_factory.mktemp("rerun") / "lean.rrd"
        answer = rerun("mcap", "convert", str(part), "-o", str(path))
        assert answer.returncode == 0, answer.stderr
        for chunk in RrdReader(path).stream():
            batch = chunk.to_record_batch()
            for name in batch.schema.names:
                if ":" in name and not name.startswith("Mcap"):
                    found.setdefault(chunk.entity_path, {}).setdefault(name, batch.column(name)[0].as_py())
    return found


@pytest.mark.parametrize("entity", DRAWN)
def test_rerun_draws_rather_than_keeps_bytes(converted, entity):
    assert set(converted[entity]) >= DRAWN[entity]


def test_rerun_hangs_the_cameras_in_the_robot_frame(converted):
    pose, calibration = converted["/camera/left/pose"], converted["/camera/left/calibration"]
    assert (pose["Transform3D:parent_frame"], pose["Transform3D:child_frame"]) == (["robot"], ["left"])
    assert calibration["Pinhole:parent_frame"] == ["left"]
    assert calibration["Pinhole:child_frame"] == converted["/camera/left"]["CoordinateFrame:frame"]
    assert converted["/shape/nodal_points"]["CoordinateFrame:frame"] == ["robot"]


def test_rerun_has_the_points_in_metres(converted, made):
    first = converted["/shape/nodal_points"]["Points3D:positions"]
    assert np.array(first) == pytest.approx(made.shape_of(0).node_mm / 1000, abs=1e-6)


def test_rerun_tells_the_clouds_apart_by_their_colours(converted):
    colours = {
        entity: tuple(parts["Points3D:colors"])
        for entity, parts in converted.items()
        if "Points3D:colors" in parts
    }
    assert len(colours) == len({whole[0] for whole in colours.values()}) == 4
    assert all(len(set(whole)) == 1 for whole in colours.values())


def test_rerun_finds_nothing_wrong_with_the_file(rerun, recording):
    answer = rerun("mcap", "check", str(recording))
    assert answer.returncode == 0, answer.stdout + answer.stderr


def test_an_independent_reader_counts_the_same(recording):
    if not (shutil.which("node") and shutil.which("npm")):
        pytest.skip("node and npm are missing; they run @mcap/core")
    asked = subprocess.run(["npm", "view", "@mcap/core", "version"], capture_output=True, check=False)
    if asked.returncode:
        pytest.skip("npm's registry does not answer, so @mcap/core cannot be had")
    script = Path(__file__).parents[3] / "benchmarks" / "independent_reader.py"
    answer = subprocess.run(
        [sys.executable, script, recording], capture_output=True, text=True, timeout=120, check=False
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "shape/nodal_points" in answer.stdout
