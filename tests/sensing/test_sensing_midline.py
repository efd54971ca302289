"""The midline of masks whose middle is known."""

import cv2
import numpy as np
import pytest

from sensing.refined.midline import half_width, midlines

HALF_WIDTH = 9


def dense(line):
    """The line at 2000 evenly numbered places."""
    places = np.linspace(0, len(line) - 1, 2000)
    return np.column_stack([np.interp(places, np.arange(len(line)), column) for column in line.T])


def thick(line, half_width_px=HALF_WIDTH, size=(260, 320)):
    """The mask of what lies within a half width of a line."""
    away = np.full(size, 255, np.uint8)
    away[tuple(np.rint(dense(line)[:, ::-1]).astype(int).T)] = 0
    return np.where(cv2.distanceTransform(away, cv2.DIST_L2, 5) <= half_width_px, np.uint8(255), np.uint8(0))


def ring(from_deg, to_deg, radius_px=90.0):
    angle = np.deg2rad(np.linspace(from_deg, to_deg, 200))
    return np.column_stack([160 + radius_px * np.cos(angle), 130 - radius_px * np.sin(angle)])


OFFSET = np.array([55.0, 0.0])
LINES = {
    "upright": np.array([[150.0, 240], [150, 40]]),
    "slanted": np.array([[60.0, 230], [250, 40]]),
    "quarter": ring(0, 90),
    "hook": ring(-40, 200),
    "s": np.vstack([ring(180, 20, 55.0) - OFFSET, ring(200, 340, 55.0) + OFFSET + np.array([-9.0, -38.0])]),
}


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("from_base", [True, False], ids=["from base", "from tip"])
def test_the_midline_runs_along_the_middle_from_the_base_to_the_tip(name, from_base):
    line = LINES[name] if from_base else LINES[name][::-1]
    path, *_ = midlines(thick(line), line[0])
    away = np.linalg.norm(path[:, None] - dense(line)[None], axis=2)
    assert np.linalg.norm(path[0] - line[0]) < 2
    assert np.linalg.norm(path[-1] - line[-1]) < 1.6 * HALF_WIDTH
    inner = (np.linalg.norm(path - line[0], axis=1) > 15) & (np.linalg.norm(path - line[-1], axis=1) > 15)
    assert away[inner].min(axis=1).max() < 2.0
    assert (np.diff(away.argmin(axis=1)[inner]) > -30).all()
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < HALF_WIDTH


def test_disks_along_the_tube_are_not_branches():
    mask = thick(LINES["upright"])
    for row in range(60, 230, 24):
        mask[row : row + 4, 136:165] = 255
    (path,) = midlines(mask, np.array([150.0, 240.0]))
    inner = (path[:, 1] > 60) & (path[:, 1] < 225)
    assert np.abs(path[inner, 0] - 150).max() <= 1.5


def test_a_mask_at_the_border_of_the_picture_has_a_midline():
    mask = np.zeros((100, 60), np.uint8)
    mask[:, 20:33] = 255
    (path,) = midlines(mask, np.array([26.0, 99.0]))
    assert path[0].tolist() == [26.0, 99.0]
    assert path[-1, 1] < 4
    assert np.abs(path[10:-10, 0] - 26).max() <= 1


@pytest.mark.parametrize("half_width_px", [4, 7, 12])
def test_the_half_width_is_the_tubes(half_width_px):
    assert half_width(thick(LINES["quarter"], half_width_px)) == pytest.approx(half_width_px + 0.5, abs=0.8)


def test_the_half_width_of_nothing_is_one():
    assert half_width(np.zeros((20, 20), np.uint8)) == 1.0


def away_from(path, line):
    """How far (n,) the places of a line are from a path."""
    return np.linalg.norm(dense(path)[None] - line[:, None], axis=2).min(axis=1)


STEM = np.array([[160.0, 245], [160, 150]])
LOOP = np.vstack([STEM, ring(270, 270 + 330, 45.0) - [0.0, 25.0]])
TAIL = np.vstack([LOOP, [[60.0, 170]]])


@pytest.mark.parametrize("line", [LOOP, TAIL], ids=["ends on itself", "crosses itself"])
def test_a_loop_is_walked_through_once(line):
    found = midlines(thick(line), line[0])
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    lengths = [np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in found]
    assert min(abs(np.array(lengths) - length)) < 4 * HALF_WIDTH
    assert away_from(found[0], line).max() < 2.5 * HALF_WIDTH


def test_where_another_thing_touches_the_robot_both_ways_are_offered():
    robot, stick = np.array([[150.0, 240], [150, 40]]), np.array([[155.0, 120], [290, 60]])
    mask = np.maximum(thick(robot), thick(stick))
    ends = [path[-1] for path in midlines(mask, robot[0])]
    assert min(np.linalg.norm(end - robot[1]) for end in ends) < 2 * HALF_WIDTH
    assert min(np.linalg.norm(end - stick[1]) for end in ends) < 2 * HALF_WIDTH


@pytest.mark.parametrize("half_width_px", [1, 2, 3, 5, 20])
def test_thin_and_thick_tubes_have_midlines(half_width_px):
    line = ring(0, 120)
    path, *_ = midlines(thick(line, half_width_px), line[0])
    assert away_from(path, line).max() < max(2.0, half_width_px)
    assert np.linalg.norm(path[-1] - line[-1]) < 2 * half_width_px + 2


def test_nothing_has_no_midline():
    assert midlines(np.zeros((20, 20), np.uint8), np.array([3.0, 3.0])) == ()
    dot = np.zeros((20, 20), np.uint8)
    dot[4:6, 4:6] = 255
    assert len(midlines(dot, np.array([3.0, 3.0]))) == 1


def test_a_blob_has_no_middle_and_does_no_harm():
    """As a damaged picture shows one."""
    corners = np.array([[11, 0], [26, 3], [26, 13], [29, 22], [29, 30], [0, 30], [4, 12], [5, 6], [11, 6]])
    random = np.random.default_rng(4)
    for _ in range(200):
        mask = np.zeros((60, 60), np.uint8)
        cv2.fillPoly(mask, [corners + random.integers(-2, 3, corners.shape) + 10], 255)
        for line in midlines(mask, np.array([25.0, 41.0])):
            assert np.isfinite(line).all()
