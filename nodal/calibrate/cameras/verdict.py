"""How good a calibration of cameras is, in grades whose limits have reasons. Pure."""

import dataclasses
from collections.abc import Iterator
from enum import StrEnum

import numpy as np

from calibration.board import corners_mm
from calibration.camera_set import CalibratedCamera, CameraSet
from calibration.rig import BoardShape
from nodal.calibration.formats.calibration import Calibration
from nodal.calibration.show.figures import figures

PER_MILLE = 1000


class Grade(StrEnum):
    """From what needs no thought to what must not be used."""

    GOOD = "good"
    FAIR = "fair"
    POOR = "poor"


GRADES = tuple(Grade)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Judgement:
    """One figure with its grade; `limits` are the largest good and the largest fair value, `why` says why they are there."""

    what: str
    value: float
    unit: str
    limits: tuple[float, float]
    why: str
    advice: str

    @property
    def grade(self) -> Grade:
        """What a person is to make of it; what is not a number is poor."""
        good, fair = self.limits
        return Grade.GOOD if self.value <= good else Grade.FAIR if self.value <= fair else Grade.POOR


def judgements(cameras: CameraSet) -> list[Judgement]:
    """Of every camera, and of all together; what is not known is left out."""
    return [
        *(judgement for camera in cameras.cameras for judgement in _of_camera(camera)),
        *_of_space(cameras),
        *_of_board(cameras),
        *_of_angles(cameras),
    ]


def shape_of(cameras: CameraSet) -> BoardShape | None:
    """The board as it was solved for; None where nothing is known of it."""
    if cameras.board is None or not cameras.board_shape:
        return None
    return BoardShape.of(corners_mm(cameras.board), cameras.board_shape)


def overall(found: list[Judgement]) -> Grade:
    """The worst."""
    return max((judgement.grade for judgement in found), key=GRADES.index, default=Grade.FAIR)


def _of_camera(camera: CalibratedCamera) -> Iterator[Judgement]:
    if camera.empty_ninths is not None:
        yield Judgement(
            what=f"{camera.name}: picture without corners",
            value=camera.empty_ninths,
            unit="of 9 parts",
            limits=(0, 4),
            why="distortion is guessed where no view shows the board: rays there are off by up to a pixel without the four corners, by 10 px and more with the middle alone",
            advice="hold the board into the parts that are named as missing, corners included",
        )
    if camera.held_out_rms_px is not None:
        yield Judgement(
            what=f"{camera.name}: held-out reprojection",
            value=camera.held_out_rms_px,
            unit="px",
            limits=(0.2, 0.5),
            why="sharp corners are found to 0.1 px; above half a pixel the model does not describe the lens or the board",
            advice="focus, light, and hold the board still; is it flat?",
        )
    if camera.held_out_rms_px is not None and camera.rms_px is not None:
        yield Judgement(
            what=f"{camera.name}: held-out beyond fitted error",
            value=float(np.sqrt(max(camera.held_out_rms_px**2 - camera.rms_px**2, 0.0))),
            unit="px",
            limits=(0.1, 0.3),
            why="it is what calibration itself adds: views that were not used fit as well as those that were, if there are enough",
            advice="take more views, in other places and tilts",
        )
    if "fx_px" in camera.sigma:
        sigma = max(camera.sigma[key] for key in ("fx_px", "fy_px") if key in camera.sigma)
        yield Judgement(
            what=f"{camera.name}: focal length, one sigma",
            value=100 * sigma / camera.intrinsics[0][0],
            unit="%",
            limits=(0.1, 0.3),
            why="distances along the view are off by the same share: 0.2 mm in 200 mm for 0.1 %",
            advice="tilt the board more, up to 45 degrees, and bring it closer and farther away",
        )


def _of_space(cameras: CameraSet) -> Iterator[Judgement]:
    check = cameras.board_check
    if check is None:
        return
    yield Judgement(
        what="sides of squares, RMS error",
        value=check.rms_error_mm,
        unit="mm",
        limits=(0.05, 0.1),
        why="it is what two points that are measured in 3-D are off from one another",
        advice="hold the board still; are the cameras in step and their focus locked?",
    )
    yield Judgement(
        what="surface of the board, RMS error",
        value=check.surface_error_mm,
        unit="mm",
        limits=(0.05, 0.1),
        why="it is by how much space is bent, or the board otherwise in one view than in the next",
        advice="take more views near the pictures' rims; glue the board onto something stiff",
    )


def _of_board(cameras: CameraSet) -> Iterator[Judgement]:
    if (board := shape_of(cameras)) is None:
        return
    yield Judgement(
        what="bow of the board",
        value=board.bow_mm,
        unit="mm",
        limits=(0.5, 1.5),
        why="it is solved for as a plain bend, which a board glued onto something stiff keeps to; loose paper does not",
        advice="glue it onto glass or aluminium",
    )
    yield Judgement(
        what="stretch of the board, down over across",
        value=abs(PER_MILLE * board.named["stretch"]),
        unit="‰",
        limits=(5.0, 10.0),
        why="it is solved for as well, but printers differ by a few per mille, pages fitted to the paper by more",
        advice="print it at 100 %, measure its ruler again (nodal calibrate board --measured MM)",
    )


def _of_angles(cameras: CameraSet) -> Iterator[Judgement]:
    """Of the two cameras that stand best to one another."""
    angles_deg = [pair.angle_deg for pair in figures(Calibration(cameras=cameras)).pairs]
    if angles_deg:
        yield Judgement(
            what="angle between the cameras, off 60 degrees",
            value=min(abs(angle - 60) for angle in angles_deg),
            unit="°",
            limits=(30.0, 42.0),
            why="below 30 degrees depth is known twice as badly as at 60, above 90 tips hide from one of both",
            advice="move the cameras (docs/bench-setup.md)",
        )
