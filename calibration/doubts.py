"""When a solution is none: parameters that the views leave open, or that no camera has."""

from collections.abc import Mapping, Sequence

import numpy as np

from calibration.bundle import Adjusted
from calibration.corners import Array
from calibration.equations import PER_CAMERA
from calibration.errors import ViewsError
from calibration.views import Size

MOST_FOCAL = 0.01
"""Standard deviation of a focal length, relative: a robot at 200 mm would be 2 mm nearer or farther."""
MOST_CENTRE = 0.01
"""Standard deviation of a principal point, in widths of the picture."""
MOST_TURN_RAD, MOST_SHIFT = 0.01, 0.01
"""Standard deviation of how two cameras stand to one another; the shift in shares of the board's distance."""
MOST_NOISE_PX = 2.0
SOLIDLY_TILTED = "tilt the board by 30 to 45 degrees to the left, right, top and bottom, and show it in every corner of the picture"


def standard_deviations(solved: Adjusted) -> Array:
    """(c, 15) of all cameras' unknowns."""
    cameras = PER_CAMERA * len(solved.rig.intrinsics)
    return np.sqrt(np.diag(solved.covariance)[:cameras]).reshape(-1, PER_CAMERA)


def check(names: Sequence[str], sizes: Mapping[str, Size], solved: Adjusted) -> None:
    """Raises ViewsError for the first camera that is not determined, or is no camera."""
    distance_mm = float(np.median(np.linalg.norm(solved.rig.rig_from_board[:, :3, 3], axis=1)))
    sigmas = standard_deviations(solved)
    for name, intrinsics, sigma, noise_px in zip(
        names, solved.rig.intrinsics, sigmas, solved.noise_px, strict=True
    ):
        width, height = sizes[name]
        if noise_px > MOST_NOISE_PX:
            raise ViewsError(
                f"camera {name}: no camera fits the views better than to {noise_px:.1f} px, at most {MOST_NOISE_PX:g} px is "
                "allowed: is the board flat, its squares all alike, and the lens no fisheye?"
            )
        relative = float(np.max(sigma[:2] / np.abs(intrinsics[:2])))
        if not relative <= MOST_FOCAL:
            raise ViewsError(
                f"camera {name}: the views leave the focal length open by {_percent(relative)}, at most {MOST_FOCAL:.0%} is "
                f"allowed: they show the board at hardly more than one tilt; {SOLIDLY_TILTED}"
            )
        off = float(np.max(sigma[2:4])) / width
        if not off <= MOST_CENTRE:
            raise ViewsError(
                f"camera {name}: the views leave the principal point open by {_percent(off)} of the picture's width, at most "
                f"{MOST_CENTRE:.0%} is allowed; {SOLIDLY_TILTED}"
            )
        fx, fy, cx, cy = intrinsics[:4]
        if not (fx > 0 and fy > 0 and 0 < cx < width and 0 < cy < height and 0.8 < fx / fy < 1.25):
            raise ViewsError(
                f"camera {name}: fx {fx:.0f}, fy {fy:.0f}, cx {cx:.0f}, cy {cy:.0f} px in a picture of {width} x {height} px "
                "is no camera: are all views of this camera, at this size, and none of them cropped?"
            )
        turn_rad, shift = float(np.max(sigma[9:12])), float(np.max(sigma[12:])) / distance_mm
        if not (turn_rad <= MOST_TURN_RAD and shift <= MOST_SHIFT):
            raise ViewsError(
                f"cameras {names[0]} and {name}: the views leave open how they stand to one another, by {np.degrees(turn_rad):.1f} "
                f"degrees and {_percent(shift)} of the board's distance: show the board to both at once, more often and differently"
            )


def _percent(share: float) -> str:
    return f"{share:.1%}" if share < 1 else "more than all of it"
