"""Calibrated cameras as people read them. Pure."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from calibration.camera_set import CalibratedCamera, CameraSet
from nodal.calibrate.cameras.verdict import PER_MILLE, Grade, Judgement, shape_of
from nodal.calibration.formats.calibration import Calibration
from nodal.calibration.show.figures import MEASURED_PX, figures

Row = Sequence[str]
UNKNOWN = "?"
DISTORTION = ("k1", "k2", "p1", "p2", "k3")
SUMMARIES = {
    Grade.GOOD: "good: nothing speaks against these cameras",
    Grade.FAIR: "fair: it will do; what is marked could be better",
    Grade.POOR: "poor: do not rely on it; do what the marked lines say and calibrate again",
}


def camera_rows(cameras: CameraSet) -> list[Row]:
    """A header, then a row for each figure: one column a camera."""
    rows: dict[str, Callable[[CalibratedCamera], str]] = {
        "picture": lambda c: f"{c.width_px} x {c.height_px}",
        "views": lambda c: str(c.views),
        "focal length x, px": lambda c: _with_sigma(c, "fx_px", c.intrinsics[0][0], 2),
        "focal length y, px": lambda c: _with_sigma(c, "fy_px", c.intrinsics[1][1], 2),
        "principal point x, px": lambda c: _with_sigma(c, "cx_px", c.intrinsics[0][2], 2),
        "principal point y, px": lambda c: _with_sigma(c, "cy_px", c.intrinsics[1][2], 2),
        **{f"distortion {key}": partial(_distortion, key) for key in DISTORTION},
        "reprojection, RMS px": lambda c: _known(c.rms_px, 3),
        "held-out views, RMS px": lambda c: _known(c.held_out_rms_px, 3),
    }
    return [
        ("", *(camera.name for camera in cameras.cameras)),
        *((label, *map(figure, cameras.cameras)) for label, figure in rows.items()),
    ]


def places(cameras: CameraSet) -> Iterator[str]:
    """How the cameras stand to one another, and what the board measures and is like."""
    for pair in figures(Calibration(cameras=cameras)).pairs:
        yield (
            f"{pair.names[0]} and {pair.names[1]}: {pair.baseline_mm:.2f} mm apart, {pair.angle_deg:.2f} degrees between their "
            f"views; {MEASURED_PX:g} px is {pair.across_mm:.3f} mm across and {pair.depth_mm:.3f} mm in depth"
        )
    if (check := cameras.board_check) is not None:
        yield (
            f"the board in 3-D: {check.squares} sides of squares, off by {round(check.mean_error_mm, 4) + 0.0:+.4f} mm on average and "
            f"{check.rms_error_mm:.4f} mm RMS; corners {check.surface_error_mm:.4f} mm RMS off its surface"
        )
    if (board := shape_of(cameras)) is not None:
        yield (
            f"the board itself: bowed by {board.bow_mm:.3f} mm, {round(PER_MILLE * board.named['stretch'], 2) + 0.0:+.2f} ‰ longer down than across, "
            f"{round(PER_MILLE * board.named['shear'], 2) + 0.0:+.2f} ‰ askew; all of this is taken out"
        )


def value_of(judgement: Judgement) -> str:
    """Its value with the unit."""
    value = judgement.value
    return f"{value if isinstance(value, int) else f'{value:.3f}'} {judgement.unit}".strip()


def hint(judgement: Judgement) -> str:
    """What to do about it, where it is not good."""
    return "" if judgement.grade is Grade.GOOD else f"{judgement.why}: {judgement.advice}"


def _distortion(key: str, camera: CalibratedCamera) -> str:
    return _with_sigma(camera, key, camera.distortion[DISTORTION.index(key)], 6)


def _with_sigma(camera: CalibratedCamera, key: str, value: float, digits: int) -> str:
    sigma = camera.sigma.get(key)
    return f"{value:.{digits}f}" + ("" if sigma is None else f" ± {sigma:.{digits}f}")


def _known(value: float | None, digits: int) -> str:
    return UNKNOWN if value is None else f"{value:.{digits}f}"


def aligned(rows: Sequence[Row]) -> Iterator[str]:
    """Rows of one length as lines of columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
