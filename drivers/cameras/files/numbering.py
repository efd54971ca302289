"""Which pictures of several folders were taken together, by their names. Pure."""

import re
from collections.abc import Mapping, Sequence

from drivers.cameras.errors import CameraError


def numbers_in(names: Sequence[str]) -> list[int] | None:
    """The number in each name that tells it from the others: `007_left` and `010_left` are 7 and 10. None where names lack one.

    Where several would do, the last one counts: in `cam2_0007` it is 7.
    """
    found = [[int(digits) for digits in re.findall(r"\d+", name)] for name in names]
    if not found or len({len(numbers) for numbers in found}) != 1:
        return None
    for column in reversed(list(zip(*found, strict=True))):
        if len(set(column)) == len(column):
            return list(column)
    return None


def together(names: Mapping[str, Sequence[str]]) -> dict[str, list[int]]:
    """A number for each camera's picture, equal where pictures were taken together.

    It is the number in their names where all have one and the cameras share some; else their place in order, of which every
    camera must have as many. Raises CameraError where they do not: nothing says which picture is missing.
    """
    numbers = {camera: numbers_in(those) for camera, those in names.items()}
    known = {camera: those for camera, those in numbers.items() if those is not None}
    shared = set.intersection(*map(set, known.values())) if known else set()
    if len(known) == len(names) and shared:
        return known
    counts = {camera: len(those) for camera, those in names.items()}
    if len(set(counts.values())) > 1:
        told = " and ".join(f"{count} of camera {camera}" for camera, count in counts.items())
        raise CameraError(
            f"pictures whose names have no number in common belong together by their order, but there are {told}: give those "
            "that were taken together the same number, such as 07_left and 07_right"
        )
    return {camera: list(range(count)) for camera, count in counts.items()}
