"""The part of a picture that is drawn anew: its pixels, and how far away what they show is."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Flat, Index, Pixels

_STEP_VARIANCE = 20 / 12  # of a box over that of the slope of a smooth step


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels: columns `left` to `right` and rows `top` to `bottom`, ends excluded."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.bottom - self.top, self.right - self.left

    @property
    def slices(self) -> tuple[slice, slice]:
        """Rows and columns of the whole picture."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    def around(self, other: "Window") -> "Window":
        """The smallest window that holds both."""
        return Window(
            min(self.left, other.left),
            min(self.top, other.top),
            max(self.right, other.right),
            max(self.bottom, other.bottom),
        )

    def within(self, other: "Window") -> "Window":
        """The same rectangle, counted from another's corner."""
        left, top = other.corner
        return Window(self.left - left, self.top - top, self.right - left, self.bottom - top)

    @property
    def corner(self) -> tuple[int, int]:
        """Column and row of the first pixel."""
        return self.left, self.top


@dataclass(frozen=True)
class Fragments:
    """What one body contributes to m pixels."""

    index: Index
    """(m,) places in the window, row by row."""
    cover: Flat
    """(m,) share of the pixel that is covered, 0 to 1."""
    colour: Flat
    """(3, m) blue, green, red."""
    depth_mm: Flat
    """(m,) along the view."""


class Canvas:
    """A window of a picture, on which bodies are painted."""

    def __init__(self, behind: Pixels, window: Window) -> None:
        """`behind` is the whole picture without the robot; it is left as it is."""
        self.window = window
        self._planes = cv2.split(behind[window.slices])
        self._depth_mm = np.full(window.shape[0] * window.shape[1], np.inf, np.float32)

    @property
    def pixels(self) -> Pixels:
        """(rows, columns, 3) blue, green, red."""
        return np.asarray(cv2.merge(self._planes), dtype=np.uint8)

    def paint(self, body: Fragments) -> None:
        """Put a body over what is there, except where something nearer hides it."""
        behind_mm = self._depth_mm.take(body.index, mode="clip")
        cover = body.cover * (body.depth_mm <= behind_mm)
        for plane, colour in zip(self._planes, body.colour, strict=True):
            flat = plane.reshape(-1)
            under = flat.take(body.index, mode="clip").astype(np.float32)
            flat[body.index] = (under + cover * (colour - under) + np.float32(0.5)).astype(np.uint8)
        self._depth_mm[body.index] = np.where(cover > 0.5, body.depth_mm, behind_mm)


def covered(inside_px: Flat, motion_px: Flat, lens_blur_px: float) -> Flat:
    """Share of pixels whose centres lie inside an edge that moves across itself while the shutter is open.

    A smooth step of the width whose variance is that of a pixel, the lens and the motion together; at the edge it is
    1/2. Arrays of any shapes that broadcast.
    """
    variance_px2 = motion_px * motion_px + np.float32(1 + lens_blur_px**2)
    step = inside_px / np.sqrt(variance_px2 * np.float32(_STEP_VARIANCE)) + np.float32(0.5)
    np.clip(step, 0, 1, out=step)
    return step * step * (3 - 2 * step)


def edge_reach_px(motion_px: float, lens_blur_px: float) -> float:
    """How far outside an edge pixels are still covered in part."""
    return math.sqrt((1 + lens_blur_px**2 + motion_px**2) * _STEP_VARIANCE) / 2
