"""The silhouette's midline from base to tip (METHOD step 4).

A silhouette is thinned to lines, and its midline is a walk along them that begins at the base. Where a robot crosses or
touches itself, or something else touches it, the lines branch and there are several walks: those that leave little of the
silhouette out and turn little at junctions come first, and the other cameras tell which is right (`cold_start`).
"""

from collections.abc import Iterator
from itertools import pairwise

import cv2
import numpy as np

from messaging.checked import FloatArray
from sensing.pictures.grid import Grid
from sensing.pictures.segmentation import Mask
from sensing.pictures.thinning import thinned
from sensing.refined.network import Arc, network

THIN_PX = 4.0
"""Masks are thinned at a size at which the tube's half width is about this."""
MOSTLY = 100
"""The level above which a pixel counts that is robot in part."""
SPUR = 2.5
"""A free branch shorter than so many half widths is a corner of the silhouette."""
TURN = 3.0
"""To turn by a right angle at a junction is as unlikely as to leave out so many half widths of the silhouette."""
BEYOND = 5.0
"""The silhouette ends at most so many half widths after its thin line does."""
SMOOTHED = 5
MOST_ARCS = 8
MOST_MIDLINES = 3
PLAUSIBLE = 8.0
"""Walks that leave out or turn by so much more than the likeliest are no midlines."""

Walk = tuple[Arc, ...]


def midlines(mask: Mask, base_pixel: FloatArray) -> tuple[FloatArray, ...]:
    """Lines (n, 2) as (x, y) px along the middle of a mask (h, w), from the base to the end: the likeliest first.

    There is none in a mask without pixels, nor in one as long as it is wide, which thins to a dot.
    """
    x0, y0, width, height = cv2.boundingRect(mask)
    if width == 0:
        return ()
    box = mask[y0 : y0 + height, x0 : x0 + width]
    grid = Grid((width, height), max(int(half_width(box) / THIN_PX), 1))
    small = np.pad(np.where(grid.reduced(box) > MOSTLY, np.uint8(255), np.uint8(0)), 1)
    depth = np.asarray(cv2.distanceTransform(small, cv2.DIST_L2, 5), dtype=np.float64)
    thin = thinned(small)
    thick = float(np.median(depth[thin])) if thin.any() else 1.0
    base = grid.coarse(base_pixel - (x0, y0)) + 1
    arcs = _leading(network(thin, thick), thick)
    if not arcs:
        return ()
    walks = {walk: _unlikeliness(walk, arcs, thick) for walk in _walks(arcs, base, thick)}
    chosen: list[Walk] = []
    for walk in sorted(walks, key=lambda walk: walks[walk]):
        if chosen and (len(chosen) == MOST_MIDLINES or walks[walk] > walks[chosen[0]] + PLAUSIBLE):
            break
        if not any(_alike(walk, other, thick) for other in chosen):
            chosen.append(walk)
    lines = [_line(walk, base, depth, BEYOND * thick) for walk in chosen]
    return tuple(grid.fine(line - 1) + np.array([x0, y0]) for line in lines)


def half_width(mask: Mask) -> float:
    """The silhouette's typical half width in px: the median depth of the mask's ridge."""
    depth = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, 5)
    ridge = depth[(depth >= cv2.dilate(depth, np.ones((3, 3), np.uint8))) & (depth > 1)]
    return float(np.median(ridge)) if ridge.size else 1.0


def _leading(arcs: tuple[Arc, ...], thick: float) -> tuple[Arc, ...]:
    """The arcs that are more than corners of the silhouette, or the longest when none is; the longest of too many."""
    by_length = sorted(arcs, key=lambda arc: arc.length_px, reverse=True)
    long = [arc for arc in by_length if not arc.leads_nowhere or arc.length_px > SPUR * thick]
    return tuple((long or by_length)[:MOST_ARCS])


def _walks(arcs: tuple[Arc, ...], base: FloatArray, thick: float) -> Iterator[Walk]:
    """Every walk that begins nearest the base and takes no arc twice."""
    begun = list(_beginnings(arcs, base, thick))
    while begun:
        walk, left = begun.pop()
        yield walk
        begun.extend((((*walk, arc)), rest) for arc, rest in _onwards(walk[-1].end, left))


def _beginnings(
    arcs: tuple[Arc, ...], base: FloatArray, thick: float
) -> Iterator[tuple[Walk, tuple[Arc, ...]]]:
    """First arcs, each with those that are left: from the place nearest the base both ways, or from a junction there."""
    nearest = min(arcs, key=lambda arc: float(np.linalg.norm(arc.pixels - base, axis=1).min()))
    at = int(np.linalg.norm(nearest.pixels - base, axis=1).argmin())
    left = tuple(arc for arc in arcs if arc is not nearest)
    ways = [
        Arc(nearest.pixels[at:], None, nearest.end),
        Arc(nearest.pixels[at::-1], None, nearest.start),
    ]
    long = max(arc.length_px for arc in ways)
    taken = [way for way in ways if way.length_px >= min(2 * thick, long)]
    yield from (((way,), left) for way in taken)
    for way in ways:
        if way not in taken:
            yield from (((arc,), rest) for arc, rest in _onwards(way.end, left))


def _onwards(junction: int | None, left: tuple[Arc, ...]) -> Iterator[tuple[Arc, tuple[Arc, ...]]]:
    """Arcs that begin at a junction, each with those that are left."""
    for taken in left:
        rest = tuple(arc for arc in left if arc is not taken)
        for arc in (taken, taken.reversed()):
            if junction is not None and arc.start == junction:
                yield arc, rest


def _alike(walk: Walk, other: Walk, thick: float) -> bool:
    """Whether one of two walks merely goes on a little where the other ends."""
    shared = all(
        np.array_equal(one.pixels, another.pixels) for one, another in zip(walk, other, strict=False)
    )
    return shared and abs(_length(walk) - _length(other)) < SPUR * thick


def _length(walk: Walk) -> float:
    return sum(arc.length_px for arc in walk)


def _unlikeliness(walk: Walk, arcs: tuple[Arc, ...], thick: float) -> float:
    """What a walk leaves out, in half widths, and how much it turns at junctions, each as long as the tube is thick."""
    missed = _junctions(arcs) - _junctions(walk)
    omitted = _length(arcs) - _length(walk) + 2 * thick * len(missed)
    steps = max(round(2 * thick), 2)
    turns = 0.0
    for before, after in pairwise(walk):
        came = before.pixels[-1] - before.pixels[-steps:][0]
        goes = after.pixels[:steps][-1] - after.pixels[0]
        size = float(np.linalg.norm(came) * np.linalg.norm(goes))
        # 0 straight on, 1 at a right angle, 2 back
        turns += 1.0 - float(came @ goes) / size if size else 1.0
    return omitted / thick + TURN * turns


def _junctions(walk: Walk) -> set[int]:
    return {end for arc in walk for end in (arc.start, arc.end) if end is not None}


def _line(walk: Walk, base: FloatArray, depth: FloatArray, reach_px: float) -> FloatArray:
    """The walk as a smooth line (n, 2) from the base to the silhouette's end, if that is within reach."""
    path = np.vstack([base, *(arc.pixels for arc in walk)])
    padded = np.pad(path, ((SMOOTHED // 2, SMOOTHED // 2), (0, 0)), mode="reflect", reflect_type="odd")
    smooth = np.lib.stride_tricks.sliding_window_view(padded, SMOOTHED, axis=0).mean(axis=2)
    ahead = smooth[-1] - smooth[-min(2 * SMOOTHED, len(smooth))]
    onwards = smooth[-1] + np.arange(1.0, reach_px)[:, None] * ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    columns, rows = np.clip(onwards.round().astype(int), 0, np.array(depth.shape[::-1]) - 1).T
    outside = depth[rows, columns] == 0
    return np.vstack([smooth, onwards[: outside.argmax() if outside.any() else 0]])
