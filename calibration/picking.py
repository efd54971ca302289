"""Which of many views are worth solving: sharp ones, no two alike, as different from one another as can be."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calibration.board import Board
from calibration.errors import ViewsError
from calibration.outlines import ALIKE, apart, outlines
from calibration.views import Size, View

MOST_VIEWS = 60
FEWEST_VIEWS = 3
"""Of each camera: two give as many equations as there are unknowns, and no word on how wrong they are."""
SHARP_QUANTILE = 0.25
MOST_BLUR = 1.6
"""How much more than a camera's sharpest views; a moving board's corners shift with the motion."""
HARMLESS_BLUR_PX = 1.2


@dataclass(frozen=True)
class Picked:
    """The views to solve, and why the others are not among them, by name."""

    views: tuple[View, ...]
    rejected: Mapping[str, str]


def pick(board: Board, views: Sequence[View], sizes: Mapping[str, Size], most: int = MOST_VIEWS) -> Picked:
    """At most `most` views, the more different ones first.

    Raises ViewsError for pictures of another size than `sizes` says, and for cameras that saw the board hardly or never.
    """
    views = [view.seen_by(sizes) for view in views]
    _check_sizes(views, sizes)
    rejected: dict[str, str] = {}
    good: list[View] = []
    sharpest_px = _sharpest(views)
    for view in views:
        reason = _fault(view, sharpest_px)
        if reason:
            rejected[view.name] = reason
        else:
            good.append(view)
    _check_seen(views, good, sizes, rejected)
    chosen = _spread(board, good, sizes, most, rejected)
    for camera in sizes:
        seen = sum(camera in view.corners for view in chosen)
        if seen < FEWEST_VIEWS:
            raise ViewsError(
                f"camera {camera} sees the board in {seen} views that differ; at least {FEWEST_VIEWS} are needed, "
                "15 or more are good: move and tilt the board between them"
            )
    return Picked(tuple(chosen), rejected)


def _check_sizes(views: Sequence[View], sizes: Mapping[str, Size]) -> None:
    for view in views:
        for camera, (width, height) in view.sizes.items():
            if camera in sizes and (width, height) != tuple(sizes[camera]):
                expected = " x ".join(map(str, sizes[camera]))
                raise ViewsError(
                    f"mixed sizes: view {view.name} of camera {camera} is {width} x {height} px, others are {expected}; "
                    "calibrate with pictures of the size that the bench runs at"
                )


def _sharpest(views: Sequence[View]) -> dict[str, float]:
    blurs: dict[str, list[float]] = {}
    for view in views:
        for camera, blur_px in view.blur_px.items():
            blurs.setdefault(camera, []).append(blur_px)
    return {camera: float(np.quantile(found, SHARP_QUANTILE)) for camera, found in blurs.items()}


def _fault(view: View, sharpest_px: Mapping[str, float]) -> str:
    if not view.corners:
        return (
            "; ".join(f"{camera}: {reason}" for camera, reason in view.missing.items()) or "no board in sight"
        )
    for camera, blur_px in view.blur_px.items():
        if too_blurred(blur_px, sharpest_px[camera]):
            return (
                f"{camera}: blurred over {blur_px:.1f} px, where {sharpest_px[camera]:.1f} px is possible: "
                "the board moved, or is out of focus"
            )
    return ""


def too_blurred(blur_px: float, sharpest_px: float) -> bool:
    """Whether a picture is much less sharp than its camera's best."""
    return blur_px > max(HARMLESS_BLUR_PX, MOST_BLUR * sharpest_px)


def _check_seen(
    views: Sequence[View], good: Sequence[View], sizes: Mapping[str, Size], rejected: Mapping[str, str]
) -> None:
    if not views:
        raise ViewsError("there are no views of the board at all")
    for camera in sizes:
        if any(camera in view.corners for view in good):
            continue
        reasons = Counter(view.missing.get(camera, rejected.get(view.name, "no picture")) for view in views)
        (reason, times), *_ = reasons.most_common(1)
        raise ViewsError(
            f"camera {camera} has no usable view of the board; in {times} of {len(views)}: {reason}"
        )


def _spread(
    board: Board, good: Sequence[View], sizes: Mapping[str, Size], most: int, rejected: dict[str, str]
) -> list[View]:
    """Farthest-point sampling (Gonzalez, 1985) of how views look, begun with the view that shows most corners."""
    looks = [outlines(board, view, sizes) for view in good]
    first = int(np.argmax([sum(map(len, view.corners.values())) for view in good]))
    nearest, distance = np.full(len(good), first), np.array([apart(look, looks[first]) for look in looks])
    taken = [first]
    distance[first] = -1.0
    while len(taken) < min(most, len(good)) and distance.max() >= ALIKE:
        farthest = int(np.argmax(distance))
        taken.append(farthest)
        to_it = np.array([apart(look, looks[farthest]) for look in looks])
        closer = to_it < distance
        nearest[closer], distance[closer] = farthest, to_it[closer]
        distance[farthest] = -1.0
    for left in sorted(set(range(len(good))) - set(taken)):
        like = good[nearest[left]].name
        rejected[good[left].name] = (
            f"shows the same as view {like}"
            if distance[left] < ALIKE
            else f"{most} views that differ more are enough"
        )
    return [good[number] for number in sorted(taken)]
