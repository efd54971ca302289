"""Work areas: which are refused, and which pixels are in them."""

import numpy as np
import pytest

from sensing.errors import WorkAreaError
from sensing.pictures.grid import Grid
from sensing.pictures.work_area import work_area_mask
from sensing.scene import Scene

WHOLE = np.array([[0, 0], [1919, 0], [1919, 1079], [0, 1079]])


@pytest.mark.parametrize(
    ("areas", "reason"),
    [
        ({"top": WHOLE}, r"work_area.top is not one of the cameras left, right"),
        (
            {"left": WHOLE + np.array([9, 0])},
            r"work_area.left has a corner \[1928, 0\] outside of the picture, which is 1920x1080 px",
        ),
        (
            {"left": WHOLE - np.array([0, 40])},
            r"work_area.left has a corner \[0, -40\] outside of the picture",
        ),
        ({"right": WHOLE * np.nan}, r"work_area.right has a corner \[nan, nan\] outside of the picture"),
        (
            {"right": WHOLE // 4},
            r"work_area.right does not contain the robot's base, which the camera sees at \[\d+, \d+\] px",
        ),
        (
            {"left": WHOLE[:2]},
            r"work_area.left has the shape \(2, 2\); a polygon is 3 corners \[x, y\] or more",
        ),
        ({"left": WHOLE // 4, "top": WHOLE}, r"work_area.left does not .*; work_area.top is not one"),
    ],
    ids=["unknown camera", "beyond", "above", "no numbers", "without the base", "two corners", "both"],
)
def test_a_work_area_that_cannot_be_is_refused(rig, areas, reason):
    with pytest.raises(WorkAreaError, match=reason):
        Scene.of(rig, work_areas=areas)


def test_a_work_area_goes_to_its_camera_alone(rig):
    scene = Scene.of(rig, work_areas={"left": WHOLE}, threshold=20.0)
    assert np.array_equal(scene.limits("left").work_area, WHOLE)
    assert scene.limits("right").work_area is None
    assert scene.limits("right").threshold == 20.0


@pytest.mark.parametrize("step", [1, 2, 4])
def test_the_mask_covers_the_polygon(step):
    grid = Grid((160, 120), step)
    mask = work_area_mask(np.array([[40.0, 20], [120, 20], [120, 100], [40, 100]]), grid)
    y, x = np.nonzero(mask)
    places = grid.fine(np.column_stack([x, y]).astype(float))
    assert mask.shape == grid.shape
    assert (np.abs(places.min(axis=0) - [40, 20]) <= step).all()
    assert (np.abs(places.max(axis=0) - [120, 100]) <= step).all()
