"""How far a camera's picture has moved against an earlier one, from the scenery that stands still. Pure.

Edges of the earlier picture are found again in the later one by least squares on brightness, coarse to fine (Lucas and Kanade 1981;
Baker and Matthews 2004), for a shift and a turn of the whole picture. Brightness is taken as the logarithm of its ratio to that of
the surroundings, so that light that has become stronger, weaker or uneven drops out; what does not fit (what has moved by itself, shadows) loses its say.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.checked import FloatArray
from sensing.pictures.light import Image

Band = NDArray[np.float32]
Mask = NDArray[np.bool_]

STEPS = (8, 4, 2, 1)
"""By how much the picture is reduced, from round to round."""
REACH = 6
"""At the coarsest step the best of all shifts up to so many pixels each way is where the search begins."""
FINE, COARSE = 1.5, 8.0
"""The standard deviations, in pixels, of the Gaussians that brightness and surroundings are smoothed with."""
DARK = 8.0
"""Levels that are added before the ratio, so that the noise of the dark does not grow."""
LEAST_GRADIENT, OVER_NOISE = 0.01, 8.0
"""An edge changes the band by so much per pixel at least, and by so many times what noise does."""
LEAST_EDGES, MOST_EDGES = 300, 30000
ROUNDS = 15
STILL = 1e-5
"""A change that alters the band by less ends the search."""
TUKEY = 4.685
MAD = 1.4826
NOISE_AREA = 4 * np.pi * FINE**2
"""Within so many pixels the band's noise is one and the same."""
REMAP_ROW = 1024


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How a picture lies against the earlier one.

    `shift_px` (2,) is how much further right and down the scenery lies at `about_px` (2,), `turn_rad` by how much it is turned
    (clockwise as one sees it), `sigma_px` the shift's standard deviation in its worst direction. `alike` is the correlation of the
    edges' surroundings, 1 for the same scenery.
    """

    about_px: FloatArray
    shift_px: FloatArray
    turn_rad: float
    sigma_px: float
    alike: float

    def at(self, pixel: FloatArray) -> FloatArray:
        """The shift (2,) at another pixel."""
        x, y = pixel - self.about_px
        return self.shift_px + self.turn_rad * np.array([-y, x])


@dataclass(frozen=True)
class _Level:
    """The earlier picture, reduced: edge pixels (n, 2) of the reduced picture, the band and its gradient (n, 2) there."""

    step: int
    places: FloatArray
    band: FloatArray
    gradient: FloatArray


class Scenery:
    """What stands still before one camera, from an earlier picture (h, w) of brightness."""

    def __init__(self, luma: Image) -> None:
        self._shape = luma.shape
        self._levels = [_level(_reduced(luma, step), step) for step in STEPS]

    def motion(self, luma: Image, hidden: Mask, carried: Mask, by_px: FloatArray) -> Motion | None:
        """How the later picture (h, w) lies; None where too little is to be seen that stands still.

        `hidden` (h, w) is where the robot is or may be; what lies in `carried` (h, w) is known to have moved by `by_px` (2,).
        """
        answer = np.zeros(3)
        centre = (np.array(self._shape[::-1]) - 1) / 2
        for level in self._levels:
            picture = _band(_reduced(luma, level.step))
            pixels = np.minimum(
                np.rint((level.places + 0.5) * level.step).astype(int), np.array(self._shape[::-1]) - 1
            )
            seen = ~hidden[pixels[:, 1], pixels[:, 0]]
            if np.count_nonzero(seen) * level.step < LEAST_EDGES:
                return None
            moved = carried[pixels[:, 1], pixels[:, 0]][:, None] * by_px / level.step
            search = _Search(level, picture, seen, moved, (centre + 0.5) / level.step - 0.5)
            if level.step == STEPS[0]:
                answer[:2] = search.best_start() * level.step
            answer, covariance, alike = search.refined(answer)
        about = search.middle()
        offset = about - centre
        shift = answer[:2] + answer[2] * np.array([-offset[1], offset[0]])
        at_middle = np.array([[1, 0, -offset[1]], [0, 1, offset[0]]])
        spread = np.linalg.eigvalsh(at_middle @ covariance @ at_middle.T)
        return Motion(
            about_px=about,
            shift_px=shift,
            turn_rad=float(answer[2]),
            sigma_px=float(np.sqrt(spread[-1])),
            alike=alike,
        )


class _Search:
    """One step's least squares; its answers (3,) are the shift in full-size px at the picture's centre and the turn in rad."""

    def __init__(
        self, level: _Level, picture: Band, seen: Mask, moved: FloatArray, centre: FloatArray
    ) -> None:
        self._step, self._picture = level.step, picture
        self._places, self._band, self._gradient = level.places[seen], level.band[seen], level.gradient[seen]
        self._moved = moved[seen]
        from_centre = self._places - centre
        self._across = np.column_stack([-from_centre[:, 1], from_centre[:, 0]])

    def middle(self) -> FloatArray:
        """Where the edges are, in full-size px: their mean, weighted by how much they tell."""
        weight = (self._gradient**2).sum(axis=1, keepdims=True)
        return np.asarray((self._places * weight).sum(axis=0) / weight.sum() + 0.5) * self._step - 0.5

    def best_start(self) -> FloatArray:
        """The shift (2,) in whole reduced pixels at which the pictures are most alike."""
        shifts = [
            np.array([x, y], dtype=np.float64)
            for x in range(-REACH, REACH + 1)
            for y in range(-REACH, REACH + 1)
        ]
        return max(shifts, key=lambda shift: _correlation(self._sampled(self._moved + shift), self._band))

    def refined(self, answer: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """A better answer, its covariance (3, 3), and how much alike the pictures are with it."""
        terms = np.column_stack([self._gradient / self._step, (self._gradient * self._across).sum(axis=1)])
        for _ in range(ROUNDS):
            found = self._sampled(self._moved + answer[:2] / self._step + answer[2] * self._across)
            weight = np.ones(len(found))
            for _ in range(2):
                gain = float((weight * found * self._band).sum() / (weight * self._band**2).sum())
                off = found - gain * self._band
                scale = MAD * float(np.median(np.abs(off))) + 1e-9
                weight = np.maximum(1 - (off / (TUKEY * scale)) ** 2, 0.0) ** 2
            jacobian = gain * terms
            normal = (jacobian * weight[:, None]).T @ jacobian
            change = -np.linalg.solve(
                normal + 1e-12 * np.trace(normal) * np.eye(3), jacobian.T @ (weight * off)
            )
            answer = answer + change
            if np.abs(terms @ change).max() < STILL:
                break
        noise = float((weight * off**2).sum() / weight.sum())
        covariance = np.asarray(NOISE_AREA * noise * np.linalg.pinv(normal), dtype=np.float64)
        return answer, covariance, _correlation(found, self._band, weight)

    def _sampled(self, by: FloatArray) -> FloatArray:
        at = (self._places + by).astype(np.float32)
        padded = np.zeros((-(-len(at) // REMAP_ROW) * REMAP_ROW, 2), np.float32)
        padded[: len(at)] = at
        x, y = (np.ascontiguousarray(axis).reshape(-1, REMAP_ROW) for axis in padded.T)
        sampled = cv2.remap(self._picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(sampled.ravel()[: len(at)], dtype=np.float64)


def _level(luma: Image, step: int) -> _Level:
    band = _band(luma)
    gradient = np.dstack(
        [cv2.Sobel(band, cv2.CV_32F, *axis, ksize=3, scale=1 / 8) for axis in ((1, 0), (0, 1))]
    )
    strength = np.linalg.norm(gradient, axis=2)
    least = max(LEAST_GRADIENT, OVER_NOISE * float(np.median(strength)))
    strong = strength > least
    margin = int(np.ceil(2 * COARSE)) if min(luma.shape) > 8 * COARSE else 2
    inside = np.zeros_like(strong)
    inside[margin:-margin, margin:-margin] = True
    rows, columns = np.nonzero(strong & inside)
    stride = max(len(rows) // MOST_EDGES, 1)
    rows, columns = rows[::stride], columns[::stride]
    places = np.column_stack([columns, rows]).astype(np.float64)
    return _Level(
        step, places, band[rows, columns].astype(np.float64), gradient[rows, columns].astype(np.float64)
    )


def _reduced(luma: Image, step: int) -> Image:
    if step == 1:
        return luma
    height, width = luma.shape[0] // step, luma.shape[1] // step
    whole = luma[: height * step, : width * step]
    return np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _band(luma: Image) -> Band:
    levels = luma.astype(np.float32)
    fine, coarse = (cv2.GaussianBlur(levels, (0, 0), size) + np.float32(DARK) for size in (FINE, COARSE))
    return np.asarray(np.log(fine / coarse), dtype=np.float32)


def _correlation(one: FloatArray, other: FloatArray, weight: FloatArray | None = None) -> float:
    weight = np.ones(len(one)) if weight is None else weight
    size = np.sqrt((weight * one**2).sum() * (weight * other**2).sum())
    return float((weight * one * other).sum() / max(size, 1e-12))
