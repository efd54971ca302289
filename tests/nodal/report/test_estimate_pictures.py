"""Pictures that explain an estimate: the geometry of what is drawn, and that everything is there."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from messaging.frames import CameraCalibration
from messaging.shape import NodalPoints
from nodal.report.confidence import inside, radius, semi_axes
from nodal.report.pictures.estimate.agreement import Agreement, of_skeleton
from nodal.report.pictures.estimate.labels import alignment, label_places
from nodal.report.pictures.estimate.regions import FACTORS, Region, ellipse_px, magnification
from nodal.report.pictures.estimate.subject import Subject
from sensing.geometry.camera import Camera
from sensing.method import METHODS
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Silhouette

DRAWS = 40_000
COVARIANCE_MM2 = np.array([[0.09, 0.05, 0.0], [0.05, 0.16, -0.03], [0.0, -0.03, 0.04]])
POINT_MM = np.array([12.0, -7.0, 61.0])


@pytest.fixture
def camera():
    return Camera(default_cameras()[0])


def share_inside(points, centre, axes):
    """Of points (n, d), how many lie within the ellipsoid that has these semi-axes as rows."""
    unit = (points - centre) @ np.linalg.inv(axes)
    return (np.linalg.norm(unit, axis=1) <= 1).mean()


@pytest.mark.parametrize("confidence", [0.5, 0.95])
def test_an_ellipse_holds_the_share_of_projected_points_that_it_promises(camera, confidence):
    points = np.random.default_rng(1).multivariate_normal(POINT_MM, COVARIANCE_MM2, DRAWS)

    ellipse = ellipse_px(camera, POINT_MM, COVARIANCE_MM2, confidence)

    held = share_inside(camera.project(points), ellipse.centre, ellipse.semi_axes)
    assert held == pytest.approx(confidence, abs=0.01)
    assert ellipse.reach == pytest.approx(np.linalg.norm(ellipse.semi_axes, axis=1).max())


def test_an_ellipsoid_holds_what_it_promises_and_so_does_the_coverage():
    errors = np.random.default_rng(2).multivariate_normal(np.zeros(3), COVARIANCE_MM2, DRAWS)

    assert share_inside(errors, np.zeros(3), semi_axes(COVARIANCE_MM2, 0.95)) == pytest.approx(0.95, abs=0.01)
    within = inside(errors, np.broadcast_to(COVARIANCE_MM2, (DRAWS, 3, 3)))
    assert within.mean() == pytest.approx(0.95, abs=0.01)


def test_what_is_claimed_to_be_exact_holds_nothing_but_itself():
    errors = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]])

    assert inside(errors, np.zeros((2, 3, 3))).tolist() == [True, False]


def test_quantiles_are_those_of_the_tables():
    assert radius(0.95, 2) ** 2 == pytest.approx(5.991, abs=1e-3)
    assert radius(0.95, 3) ** 2 == pytest.approx(7.815, abs=1e-3)


@given(st.floats(1.0, 500.0))
def test_magnified_outlines_keep_their_centre_and_direction(factor):
    region = Region.of(np.array([5.0, 7.0]), np.array([[4.0, 1.0], [1.0, 2.0]]), 0.95)

    plain, magnified = region.surface() - region.centre, region.surface(factor) - region.centre

    assert magnified == pytest.approx(factor * plain)


def test_sections_lie_on_the_surface_of_an_ellipsoid():
    region = Region.of(POINT_MM, COVARIANCE_MM2, 0.95)

    on_it = np.concatenate([region.surface(3).reshape(-1, 3), *region.sections(3)])

    unit = (on_it - POINT_MM) @ np.linalg.inv(3 * region.semi_axes)
    assert np.linalg.norm(unit, axis=1) == pytest.approx(1.0)


@given(st.floats(1e-6, 1e3), st.floats(0.01, 1e3))
def test_a_magnification_is_as_large_as_there_is_room(largest, room):
    factor = magnification(largest, room)

    assert factor == 1 or factor * largest <= room
    larger = [more for more in FACTORS if more > factor]
    assert not larger or larger[0] * largest > room


def test_names_stand_beside_the_line_inside_of_the_frame_and_apart():
    line = np.column_stack([np.full(50, 10.0), np.linspace(0, 100, 50)])
    points = np.array([[10.0, 40.0], [10.0, 42.0]])

    places = label_places(line, points, np.full(2, 8.0), np.array([0.0, 0.0]), np.array([100.0, 100.0]))

    assert np.abs(places[:, 0] - 10) == pytest.approx(8.0)
    assert places[0, 0] != places[1, 0], "both stand on one side and cover one another"
    assert alignment(1.0, 0.1) == {"ha": "left", "va": "center"}
    assert alignment(0.0, -1.0) == {"ha": "center", "va": "top"}


def test_stretches_end_half_way_to_what_was_not_seen():
    offsets = np.array([np.nan, 0.1, 0.1, np.nan, 0.2])
    agreement = Agreement(np.arange(5.0), offsets, np.zeros((5, 2)))

    assert agreement.stretches_mm() == [(0.5, 2.0), (3.5, 0.5)]
    assert agreement.unseen.tolist() == [True, True, True, True, True]


def on_arc(arc_mm, curvature=0.012, heading=2.6):
    angle = curvature * np.asarray(arc_mm, dtype=float)
    aside = (1 - np.cos(angle)) / curvature
    return np.column_stack([aside * np.cos(heading), aside * np.sin(heading), np.sin(angle) / curvature])


def turned(calibration, name, angle):
    """The same camera, carried round the robot."""
    round_z = np.eye(4)
    round_z[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return CameraCalibration(
        camera=name,
        width_px=calibration.width_px,
        height_px=calibration.height_px,
        intrinsics=calibration.intrinsics,
        distortion=calibration.distortion,
        camera_from_robot=calibration.camera_from_robot @ round_z,
    )


@pytest.fixture(scope="module")
def subjects():
    """Estimates of one arc seen by three cameras, by the default method, from nothing and from the shape before."""
    left, right = default_cameras()
    rig = (left, right, turned(left, "third", 1.9))
    robot = on_arc(np.arange(81))
    jpegs = {
        camera.camera: Renderer(camera, np.array([40.0, 80.0]), SimulatedCamerasSettings(), seed).render(
            robot, robot
        )
        for seed, camera in enumerate(rig)
    }
    method = METHODS[MethodName.REFINED](Scene.of(rig, length_mm=80.0))
    pictures = {name: method.scene.picture(name, jpeg) for name, jpeg in jpegs.items()}
    cold = method.estimate(pictures, 0.0, None, time.perf_counter)
    warm = method.estimate(pictures, 0.0, cold.track, time.perf_counter)
    nodes = NodalPoints(names=("middle", "tip"), arc_mm=np.array([40.0, 80.0]))
    return {"cold": Subject(method, jpegs, cold, nodes), "warm": Subject(method, jpegs, warm, nodes)}


def test_a_skeleton_that_lies_off_tells_by_how_much_and_where_it_ends(subjects):
    subject = subjects["cold"]
    camera = subject.cameras[0]
    line = camera.project(subject.shape.centreline.points_mm[:40])
    along = np.gradient(line, axis=0)
    normal = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    silhouette = Silhouette(np.zeros((4, 4), np.uint8), line + 3.0 * normal, 20.0)

    agreement = of_skeleton(camera, subject.shape, silhouette)

    assert agreement.offset_px[agreement.seen] == pytest.approx(3.0, abs=0.1)
    [(begin_mm, length_mm)] = agreement.stretches_mm()
    assert (begin_mm, length_mm) == pytest.approx((0.0, 39.5), abs=1.6)


@pytest.mark.parametrize("start", ["cold", "warm"])
def test_everything_is_drawn_for_each_camera(subjects, start, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    from matplotlib.figure import Figure  # noqa: PLC0415  part of an extra

    from nodal.report.pictures.estimate import along, cameras, space  # noqa: PLC0415

    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: drawn.append(figure))
    subject = subjects[start]
    for draw in (cameras.draw_cameras, space.draw_space, along.draw_along):
        draw(tmp_path / "picture", subject, [])
    by_camera, in_space, by_length = drawn[::2]

    assert [axes.get_ylabel() for axes in by_camera.axes if axes.get_ylabel()] == [
        "camera left",
        "camera right",
        "camera third",
    ]
    assert len(by_camera.axes) == 3 * len(cameras.COLUMNS)
    words = [text.get_text() for axes in by_camera.axes for text in axes.texts]
    assert words.count("tip") == 3
    assert words.count("10 mm") == 3
    assert ("followed from the shape\nbefore: none was sought" in words) == (start == "warm")
    assert len(in_space.axes) == (3 if start == "cold" else 2), (
        "the gaps' scale is missing, or measures nothing"
    )
    assert {"left", "right", "third"} <= {text.get_text() for text in in_space.axes[-1].texts}
    assert len(by_length.axes) == (5 if start == "cold" else 4)
    for figure in (by_camera, in_space, by_length):
        assert figure.get_suptitle() == "Method refined, no flags"
        assert "Length 80." in figure.get_supxlabel() or "Length 79." in figure.get_supxlabel()
