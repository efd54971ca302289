"""What happens to a picture before the sensor: blur, light, shadows, dust, and things that stand in the way.

Each takes a picture (h, w, 3) and the sight it shows, and gives the changed picture.
"""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import ArrayLike

from benchmarks.degradations.scenery import Image, Sight
from benchmarks.poses import Array

Optics = Callable[[Image, Sight], Image]

GAMMA = 2.2


def untouched(picture: Image, _: Sight) -> Image:
    """The picture as it is."""
    return picture


def blurred(sigma_px: float) -> Optics:
    """Out of focus."""
    return lambda picture, _: _bytes(cv2.GaussianBlur(picture, (0, 0), sigma_px))


def shifted(by_px: float) -> Optics:
    """Everything lies further right."""
    move = np.array([[1.0, 0, by_px], [0, 1, 0]])
    return lambda picture, _: _bytes(
        cv2.warpAffine(picture, move, picture.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)
    )


def exposed(stops: float) -> Optics:
    """More light, or less: each stop doubles it."""
    light = (np.arange(256) / 255) ** GAMMA * 2.0**stops
    table = np.rint(255 * np.clip(light, 0, 1) ** (1 / GAMMA)).astype(np.uint8)
    return lambda picture, _: _bytes(cv2.LUT(picture, table))


def uneven(darkest: float) -> Optics:
    """A lamp at one side: from full brightness down to this share at the other, on robot and backdrop alike."""

    def _apply(picture: Image, _: Sight) -> Image:
        ramp = np.linspace(1, darkest, picture.shape[1], dtype=np.float32)
        return _scaled(picture, np.broadcast_to(ramp, picture.shape[:2]))

    return _apply


def shadow(depth: float) -> Optics:
    """The robot's own shadow, rather sharp, on the backdrop beside it."""

    def _apply(picture: Image, sight: Sight) -> Image:
        robot = _robot(picture, sight)
        shift = 9 * sight.px_per_mm(sight.points_mm[0])
        cast = cv2.warpAffine(robot, np.array([[1.0, 0, shift], [0, 1, 0.5 * shift]]), robot.shape[::-1])
        cast = cv2.GaussianBlur(cast, (0, 0), 4.0)
        return _scaled(picture, 1 - depth * cast * (1 - robot))

    return _apply


def dusty(specks: int) -> Optics:
    """Dark and bright specks of up to 4 px, anywhere."""

    def _apply(picture: Image, sight: Sight) -> Image:
        picture = picture.copy()
        height, width = picture.shape[:2]
        for x, y, radius, level in sight.random.uniform((0, 0, 0.5, 0), (width, height, 4, 255), (specks, 4)):
            _disc(picture, (x, y), radius, (level, level, level))
        return picture

    return _apply


def glare(arc_mm: float, off_mm: float = 0.0) -> Optics:
    """A bright reflection, to white in its middle, over the robot at this distance from the base or beside it."""

    def _apply(picture: Image, sight: Sight) -> Image:
        point = sight.points_mm[round(arc_mm)]
        scale = sight.px_per_mm(point)
        x, y = sight.pixels(point[None])[0] + [off_mm * scale, 0]
        rows, columns = np.ogrid[: picture.shape[0], : picture.shape[1]]
        square = ((columns - x) / (2 * scale)) ** 2 + ((rows - y) / (4 * scale)) ** 2
        bright = 400 * np.exp(-0.5 * square).astype(np.float32)
        return _rounded(picture + bright[..., None])

    return _apply


def covered(camera: str, arc_mm: float, size_mm: float, colour_bgr: tuple[int, int, int] | None) -> Optics:
    """A plate before the robot in one view, centred on it at this distance from the base.

    Without a colour it looks like the backdrop.
    """

    def _apply(picture: Image, sight: Sight) -> Image:
        if sight.camera.camera != camera:
            return picture
        point = sight.points_mm[round(arc_mm)]
        half = size_mm / 2 * sight.px_per_mm(point) * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        share = _polygon(picture, sight.pixels(point[None]) + half)
        return _over(picture, sight.empty if colour_bgr is None else _plain(picture, colour_bgr), share)

    return _apply


def with_stick(
    place: Callable[[Array], tuple[Array, Array]],
    radius_mm: float = 2.5,
    colour_bgr: tuple[int, int, int] = (94, 86, 86),
) -> Optics:
    """A second object: a straight stick between two points, which `place` gives for a centreline (81, 3)."""

    def _apply(picture: Image, sight: Sight) -> Image:
        ends = np.stack(place(sight.points_mm))
        pixels = sight.pixels(ends)
        along = pixels[1] - pixels[0]
        across = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-9)
        wide = [radius_mm * sight.px_per_mm(end) * across for end in ends]
        outline = np.array(
            [pixels[0] + wide[0], pixels[1] + wide[1], pixels[1] - wide[1], pixels[0] - wide[0]]
        )
        return _over(picture, _plain(picture, colour_bgr), _polygon(picture, outline))

    return _apply


def _robot(picture: Image, sight: Sight) -> Array:
    """How much of each pixel (h, w) the robot is, 0 to 1, by how far it stands out from the empty scene."""
    apart = cv2.absdiff(picture, sight.empty).max(axis=2).astype(np.float32)
    return np.asarray(np.clip((apart - 4) / 20, 0, 1))


def _polygon(picture: Image, corners: Array) -> Array:
    """How much of each pixel (h, w) a convex polygon (n, 2) covers, its edges as soft as the lens makes them."""
    share = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillConvexPoly(share, np.rint(16 * corners).astype(np.int32), 255, cv2.LINE_AA, shift=4)
    return np.asarray(cv2.GaussianBlur(share, (0, 0), 0.8) / 255.0)


def _disc(
    picture: Image, centre: tuple[float, float], radius: float, colour: tuple[float, float, float]
) -> None:
    place = round(16 * centre[0]), round(16 * centre[1])
    cv2.circle(picture, place, round(16 * radius), colour, cv2.FILLED, cv2.LINE_AA, shift=4)


def _plain(picture: Image, colour_bgr: tuple[int, int, int]) -> Image:
    return np.broadcast_to(np.array(colour_bgr, np.uint8), picture.shape)


def _over(picture: Image, above: Image, share: Array) -> Image:
    rows, columns = (np.flatnonzero(share.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return picture
    part = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    weight = share[part][..., None]
    changed = picture.copy()
    changed[part] = _rounded(picture[part] + weight * (above[part].astype(np.float32) - picture[part]))
    return changed


def _scaled(picture: Image, factor: Array) -> Image:
    return _rounded(picture * np.asarray(factor, np.float32)[..., None])


def _rounded(levels: ArrayLike) -> Image:
    return _bytes(np.clip(np.rint(levels), 0, 255))


def _bytes(picture: ArrayLike) -> Image:
    return np.asarray(picture, dtype=np.uint8)
