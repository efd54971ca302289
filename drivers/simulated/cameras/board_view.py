"""The board before one camera: every pixel's share of paper and ink, found along exact rays."""

import math

import cv2
import numpy as np

from drivers.simulated.cameras.arrays import Array, Flat, Pixels
from drivers.simulated.cameras.canvas import Window
from drivers.simulated.cameras.light import Light
from drivers.simulated.cameras.printed_board import PrintedBoard
from drivers.simulated.cameras.projection import Projection

_FINER = 3  # rays along a pixel's side: within two levels of ever more rays, which noise hides
_COARSER, _MOMENTS = 3, 6  # pixels along the side of a block that has one ray while the board moves
_STRIP_PX = 64
_MARGIN_PX = 3
_NEAREST_MM = 1.0
_PIXEL_VARIANCE = 1 / 12


class BoardView:
    """Paints the board into one camera's picture."""

    def __init__(
        self,
        board: PrintedBoard,
        projection: Projection,
        light: Light,
        *,
        gradient: float,
        lens_blur_px: float,
    ) -> None:
        """`gradient` is how much brighter the board's end towards the lamp is than its other end."""
        self._board = board
        self._projection = projection
        self._light = light
        self._gradient = gradient
        self._blur_px = lens_blur_px * math.sqrt(_PIXEL_VARIANCE)
        paper = np.full_like(board.levels, 255)
        self._front = cv2.merge([board.levels, paper])
        self._back = cv2.merge([np.full_like(paper, board.levels.max()), paper])

    def paint(self, picture: Pixels, opened: Array, closed: Array) -> Window | None:
        """Over everything in the picture, where `robot_from_board` (4, 4) went from one to the other while the shutter
        was open; returns the window that changed, if the camera sees the board.
        """
        places = [self._in_camera(robot_from_board) for robot_from_board in (opened, closed)]
        window = self._window(places)
        if window is None:
            return None
        sheet = (
            self._held(window, places[0]) if np.array_equal(opened, closed) else self._moved(window, places)
        )
        if self._blur_px:
            sheet = np.asarray(cv2.GaussianBlur(sheet, (0, 0), self._blur_px))
        paper = cv2.convertScaleAbs(sheet[:, :, 0] * self._shade(window, places[0]))
        uncovered = cv2.convertScaleAbs(255 - sheet[:, :, 1])
        behind = cv2.multiply(picture[window.slices], cv2.merge([uncovered] * 3), scale=1 / 255)
        picture[window.slices] = cv2.add(behind, cv2.merge([paper] * 3))
        return window

    def _in_camera(self, robot_from_board: Array) -> Array:
        """(3, 3) from the board's (x mm, y mm, 1) to the camera frame."""
        axes = self._projection.rotation @ robot_from_board[:3, :2]
        return np.column_stack([axes, self._projection.to_camera(robot_from_board[:3, 3])])

    def _points_mm(self, place: Array, board_mm: Array) -> Array:
        """Points (n, 2) of the board in the camera frame."""
        points: Array = np.column_stack([board_mm, np.ones(len(board_mm))]) @ place.T
        return points

    def _window(self, places: list[Array]) -> Window | None:
        outline_mm = np.concatenate([self._points_mm(place, self._board.outline_mm) for place in places])
        from_plane_mm = min(abs(np.linalg.det(place)) for place in places)
        if outline_mm[:, 2].min() < _NEAREST_MM or from_plane_mm < _NEAREST_MM:
            return None
        pixels = self._projection.to_pixels(outline_mm)
        limit = [self._projection.width_px, self._projection.height_px]
        corners = np.clip([pixels.min(axis=0) - _MARGIN_PX, pixels.max(axis=0) + _MARGIN_PX + 1], 0, limit)
        window = Window(*corners.astype(int).ravel().tolist())
        return window if min(window.shape) > 0 else None

    def _held(self, window: Window, place: Array) -> Flat:
        """(rows, columns, 2) level times cover, and cover, both 0 to 255, of a board at rest."""
        strips = []
        for top in range(window.top, window.bottom, _STRIP_PX):
            strip = Window(window.left, top, window.right, min(top + _STRIP_PX, window.bottom))
            finer = self._on_rays(place, self._finer_rays(strip))
            strips.append(cv2.resize(finer, strip.shape[::-1], interpolation=cv2.INTER_AREA))
        return np.concatenate(strips)

    def _moved(self, window: Window, places: list[Array]) -> Flat:
        """The same of a board that goes from one place to another; coarse, for nothing can be measured on it."""
        size = [-(-side // _COARSER) for side in window.shape[::-1]]
        rays = [
            np.asarray(cv2.resize(rays, size, interpolation=cv2.INTER_AREA), np.float32)
            for rays in self._projection.rays_in(window)
        ]
        moments = [(1 - share) * places[0] + share * places[1] for share in np.linspace(0, 1, _MOMENTS)]
        coarse = np.stack([self._on_rays(place, rays) for place in moments]).mean(axis=0)
        return np.asarray(cv2.resize(coarse, window.shape[::-1]), np.float32)

    def _on_rays(self, place: Array, rays: list[Flat]) -> Flat:
        """(rows, columns, 2) what of the sheet is seen along rays (x, y, 1) in the camera frame."""
        sheet = self._front if np.linalg.det(place) > 0 else self._back
        sheet_from_ray = (self._board.pixels_from_board @ np.linalg.inv(place)).astype(np.float32)
        across, down, depth = (row[0] * rays[0] + row[1] * rays[1] + row[2] for row in sheet_from_ray)
        seen = cv2.remap(sheet, across / depth, down / depth, cv2.INTER_LINEAR, borderValue=(0, 0))
        return seen.astype(np.float32)

    def _finer_rays(self, window: Window) -> list[Flat]:
        """X and y of rays through even parts of the window's pixels."""
        around = Window(
            max(window.left - 1, 0),
            max(window.top - 1, 0),
            min(window.right + 1, self._projection.width_px),
            min(window.bottom + 1, self._projection.height_px),
        )
        size = [_FINER * side for side in around.shape[::-1]]
        inner = window.within(around)
        rows, columns = (slice(_FINER * part.start, _FINER * part.stop) for part in inner.slices)
        return [
            np.asarray(cv2.resize(rays, size, interpolation=cv2.INTER_LINEAR)[rows, columns], np.float32)
            for rays in self._projection.rays_in(around)
        ]

    def _shade(self, window: Window, place: Array) -> Flat:
        """(rows, columns) how bright white paper is: a plane over the picture, brighter towards the lamp."""
        normal = -np.cross(place[:, 0], place[:, 1])
        even = self._light.brightness(np.array(normal @ self._light.direction))
        width_mm, height_mm = self._board.squares_mm
        corners_mm = self._points_mm(place, np.array([[0, 0], [width_mm, 0], [0, height_mm]]))
        middle_mm = place @ [width_mm / 2, height_mm / 2, 1]
        ahead = (corners_mm - middle_mm) @ self._light.direction / math.hypot(width_mm, height_mm)
        values = even * (1 + self._gradient * ahead)
        pixels = self._projection.to_pixels(corners_mm)
        slopes = np.linalg.solve(pixels[1:] - pixels[0], values[1:] - values[0])
        columns = np.arange(window.left, window.right) - pixels[0, 0]
        rows = np.arange(window.top, window.bottom) - pixels[0, 1]
        shade = values[0] + slopes[0] * columns[None, :] + slopes[1] * rows[:, None]
        return np.asarray(shade, dtype=np.float32)
