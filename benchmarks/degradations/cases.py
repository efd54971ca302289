"""All cases, in the order of the table."""

from benchmarks.degradations.camera_cases import CAMERA_CASES
from benchmarks.degradations.level import Case, Level
from benchmarks.degradations.picture_cases import PICTURE_CASES
from benchmarks.degradations.robot_cases import ROBOT_CASES

CASES: tuple[Case, ...] = (
    Case("none", (Level(name="reference"),)),
    *PICTURE_CASES,
    *ROBOT_CASES,
    *CAMERA_CASES,
)
