"""What `nodal calibration show` says of cameras whose geometry is known beforehand."""

import json
import math
import shutil

import msgspec
import numpy as np
import pytest

from calibration.camera_set import CameraSet
from messaging.frames import CameraCalibration
from nodal.__main__ import main
from nodal.bench_file import bench_path, load_bench
from nodal.calibration.folder import save_json
from nodal.calibration.formats.calibration import Calibration
from nodal.calibration.show.figures import MEASURED_PX, figures
from nodal.calibration_file import save_rig

DISTANCE_MM, FOCAL_PX = 200.0, 1000.0


def facing(name, azimuth_deg, height_mm):
    """A camera without distortion, at this distance from the robot's axis, at this height, looking horizontally at it."""
    azimuth = math.radians(azimuth_deg)
    place = np.array([DISTANCE_MM * math.sin(azimuth), -DISTANCE_MM * math.cos(azimuth), height_mm])
    forward = -np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
    rotation = np.stack([np.cross(forward, [0.0, 0.0, 1.0]), [0.0, 0.0, -1.0], forward])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, -rotation @ place
    return CameraCalibration(
        camera=name,
        width_px=2000,
        height_px=1000,
        intrinsics=np.array([[FOCAL_PX, 0, 1009.5], [0, FOCAL_PX, 499.5], [0, 0, 1]]),
        distortion=np.zeros(5),
        camera_from_robot=pose,
    )


def seen(angle_deg):
    rig = [facing("left", -angle_deg / 2, 40.0), facing("right", angle_deg / 2, 40.0)]
    return figures(Calibration(cameras=CameraSet.of_rig(rig), rig_from_robot=rig[0].camera_from_robot), 80.0)


@pytest.mark.parametrize("angle_deg", [20.0, 60.0, 90.0])
def test_a_rig_on_paper_is_told_as_it_was_drawn(angle_deg):
    found = seen(angle_deg)
    (left, _), (pair,) = found.cameras, found.pairs
    half = math.radians(angle_deg / 2)
    assert left.field_of_view_deg == pytest.approx((90.0, 2 * math.degrees(math.atan(0.5))))
    assert left.off_centre_px == pytest.approx((10.0, 0.0))
    assert left.corner_distortion_px == pytest.approx(0.0, abs=1e-9)
    assert left.position_mm == pytest.approx(
        (-DISTANCE_MM * math.sin(half), -DISTANCE_MM * math.cos(half), 40.0)
    )
    assert left.looks == pytest.approx((math.sin(half), math.cos(half), 0.0))
    assert (left.distance_mm, left.mm_per_px) == pytest.approx((DISTANCE_MM, DISTANCE_MM / FOCAL_PX))
    assert pair.angle_deg == pytest.approx(angle_deg)
    assert pair.baseline_mm == pytest.approx(2 * DISTANCE_MM * math.sin(half))
    sideways_mm = MEASURED_PX * DISTANCE_MM / FOCAL_PX / math.sqrt(2)
    assert pair.depth_mm == pytest.approx(sideways_mm / math.sin(half))
    assert pair.across_mm == pytest.approx(sideways_mm * math.sqrt((1 + math.cos(half) ** -2) / 2))


def test_without_a_robot_it_is_told_for_where_the_axes_meet():
    rig = [facing("left", -30.0, 40.0), facing("right", 30.0, 40.0)]
    found = figures(Calibration(cameras=CameraSet.of_rig(rig)))
    assert found.frame == "rig"
    assert found.place_mm == pytest.approx((0.0, 0.0, DISTANCE_MM))
    assert found.pairs[0].angle_deg == pytest.approx(60.0)


def test_a_bench_is_shown_with_what_is_known_of_its_exactness(tmp_path, capsys):
    rig = load_bench("simulated").rig
    shutil.copy(bench_path("simulated"), tmp_path / "bench.toml")
    save_rig(tmp_path / "simulated-rig.json", rig)
    assert main(["calibration", "show", "--config", str(tmp_path / "bench.toml")]) == 0
    assert "one standard deviation" not in capsys.readouterr().out
    cameras = CameraSet.of_rig(rig)
    first = msgspec.structs.replace(
        cameras.cameras[0], sigma={"fx_px": 0.5, "x_mm": 0.02}, rms_px=0.1, held_out_rms_px=0.2, views=12
    )
    save_json(
        tmp_path / "cameras.json", msgspec.structs.replace(cameras, cameras=(first, *cameras.cameras[1:]))
    )
    assert main(["calibration", "show", "--config", str(tmp_path / "bench.toml")]) == 0
    shown = capsys.readouterr().out
    assert "known to (one standard deviation) fx 0.50 px, x 0.020 mm" in shown
    assert "reprojection 0.100 px RMS in 12 views, 0.200 px in views that were held out" in shown
    assert "in the robot frame" in shown


def test_json_is_one_object(capsys):
    assert main(["calibration", "show", "--config", "simulated", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [camera["name"] for camera in shown["cameras"]] == ["left", "right"]
    assert shown["pairs"][0]["angle_deg"] == pytest.approx(59.7, abs=0.1)


def test_it_is_a_file_or_a_bench(capsys):
    assert main(["calibration", "show"]) == 2
    assert "a FILE, or --config BENCH" in capsys.readouterr().err
