"""Which pictures of several folders were taken together, by their names. Pure."""

import re
from collections.abc import Mapping, Sequence


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

    It is the number in their names where all have one and every two cameras share some; else their place in order.
    """
    numbers = {camera: numbers_in(those) for camera, those in names.items()}
    known = {camera: those for camera, those in numbers.items() if those is not None}
    shared = set.intersection(*map(set, known.values())) if known else set()
    if len(known) < len(names) or not shared:
        return {camera: list(range(len(those))) for camera, those in names.items()}
    return known
