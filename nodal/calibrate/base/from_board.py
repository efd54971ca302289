"""Where the robot stands, from the board in its fixture at the base."""

from collections.abc import Sequence

import cv2
import numpy as np

from calibration.base import Base
from calibration.base_board import base_from_board
from calibration.board import Board
from calibration.camera_set import CameraSet
from calibration.views import find_view
from messaging.board import BoardSettings
from nodal.calibrate.looking import Jpegs
from nodal.errors import CalibrationError

GREY = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION


def board_base(settings: BoardSettings, cameras: CameraSet, sets: Sequence[Jpegs]) -> Base:
    """The robot frame from sets of pictures of the board at the base.

    Raises CalibrationError when it is not said where the board stands there, or a picture is not one of its camera, and
    ViewsError when a camera does not see the board.
    """
    if settings.at_base is None:
        raise CalibrationError(
            "the bench file has no [board.at_base], which says where the board stands in the robot frame while it is in its "
            "fixture; without a fixture use --robot"
        )
    board = Board(settings)
    sizes = {camera.name: (camera.width_px, camera.height_px) for camera in cameras.cameras}
    views = []
    for number, jpegs in enumerate(sets):
        pictures = {name: cv2.imdecode(np.frombuffer(data, np.uint8), GREY) for name, data in jpegs.items()}
        for name, picture in pictures.items():
            if picture is None or picture.shape[::-1] != sizes[name]:
                found = (
                    "cannot be decoded" if picture is None else f"is {picture.shape[1]}x{picture.shape[0]} px"
                )
                raise CalibrationError(
                    f"camera {name}: a picture {found}; it was calibrated for {sizes[name]} px"
                )
        views.append(find_view(board, f"{number}", {name: np.asarray(one) for name, one in pictures.items()}))
    for camera in cameras.cameras:
        if not any(camera.name in view.corners for view in views):
            reason = next(
                (view.missing[camera.name] for view in views if camera.name in view.missing), "no picture"
            )
            raise CalibrationError(f"camera {camera.name} does not see the board at the base: {reason}")
    return base_from_board(
        cameras, [view.corners for view in views], board.points_mm, settings.at_base.robot_from_board
    )
