"""Cameras, boards and the robot's base in space."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera_set import CalibratedCamera
from nodal.calibrate.report.material import Material
from nodal.report.page.markup import Content, element, figure, vector
from nodal.report.pictures.chart import NARROW_IN, page_svg
from nodal.report.pictures.style import FAINT, INK, MEASURED, NODE, PALETTE, drawing, robot_axes

Array = NDArray[np.float64]

TITLE = "In space"
ABOVE = 90
SIDES = (("from the side", 18, -62), ("from above", ABOVE, -90))
FRUSTUM = 0.25
"""How far the outlines of cameras reach, in shares of their distance."""
CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], float)


def content(known: Material) -> Content:
    """From two sides."""
    return [
        element("p", _words(known)),
        element(
            "div",
            [
                figure(
                    vector(_drawn(known, elevation, azimuth, name), f"Cameras and boards {name}"),
                    name.capitalize(),
                )
                for name, elevation, azimuth in SIDES
            ],
            class_="charts",
        ),
    ]


def _words(known: Material) -> str:
    robot = known.calibration.rig_from_robot is not None
    frame = (
        "the robot frame, with the robot standing straight"
        if robot
        else "the first camera's frame turned upright: y is where it looks, z is up"
    )
    return f"Cameras, and the board in every view, in {frame}."


def _drawn(known: Material, elevation: float, azimuth: float, name: str) -> str:
    shown_from_rig = _shown_from_rig(known)
    frusta = [_frustum(known, camera, shown_from_rig) for camera in known.cameras.cameras]
    boards = [
        _in_frame(shown_from_rig @ np.array(pose), _outline(known))
        for pose in known.kept.rig_from_board.values()
    ]
    robot = known.calibration.rig_from_robot is not None
    straight = (
        np.array([(0, 0, 0), (0, 0, known.bench.settings.robot.length_mm)], float)
        if robot
        else np.zeros((0, 3))
    )
    with drawing(NARROW_IN, NARROW_IN, name) as drawn:
        axes = robot_axes(drawn, 111, np.concatenate([*frusta, *boards, straight]))
        axes.view_init(elev=elevation, azim=azimuth)
        if elevation == ABOVE:
            axes.set(zticks=[], zlabel="")
        for number, (camera, frustum) in enumerate(zip(known.cameras.cameras, frusta, strict=True)):
            axes.plot(*frustum.T, color=PALETTE[number % len(PALETTE)], linewidth=1.2)
            axes.text(*frustum[0], f" {camera.name}", fontsize=8)
        for board in boards:
            axes.plot(*board.T, color=FAINT if len(boards) > 60 else INK, linewidth=0.5, alpha=0.6)
        if robot:
            _robot(axes, straight)
        return page_svg(drawn)


def _shown_from_rig(known: Material) -> Array:
    """The robot frame where it is known; else the first camera's frame, turned so that its picture's top is up."""
    rig_from_robot = known.calibration.rig_from_robot
    if rig_from_robot is not None:
        return np.asarray(np.linalg.inv(rig_from_robot))
    upright = np.eye(4)
    upright[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    return upright


def _frustum(known: Material, camera: CalibratedCamera, shown_from_rig: Array) -> Array:
    """One line (N, 3) along a camera's outline, which begins at its centre."""
    seen = next(one for one in known.figures.cameras if one.name == camera.name)
    (fx, _, cx), (_, fy, cy), _ = camera.intrinsics
    corners = CORNERS * [camera.width_px, camera.height_px]
    rays = np.column_stack([(corners - [cx, cy]) / [fx, fy], np.ones(5)]) * seen.distance_mm * FRUSTUM
    centre = np.zeros(3)
    path = np.array(
        [
            centre,
            rays[0],
            rays[1],
            centre,
            rays[1],
            rays[2],
            centre,
            rays[2],
            rays[3],
            centre,
            rays[3],
            rays[0],
        ]
    )
    return _in_frame(shown_from_rig @ np.linalg.inv(np.array(camera.camera_from_rig)), path)


def _outline(known: Material) -> Array:
    board = known.cameras.board or known.bench.settings.board
    size_mm = np.array(board.squares) * board.square_mm
    return np.column_stack([CORNERS * size_mm, np.zeros(5)])


def _robot(axes: Any, straight: Array) -> None:
    axes.plot(*straight.T, color=NODE, linewidth=2.5)
    for direction in np.eye(3):
        axis = np.array([np.zeros(3), direction * straight[-1, 2] / 3])
        axes.plot(*axis.T, color=MEASURED, linewidth=1)
        axes.text(*axis[1], "xyz"[int(direction.argmax())], fontsize=8)


def _in_frame(pose: Array, points: Array) -> Array:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])
