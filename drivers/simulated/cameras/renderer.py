"""One simulated camera: from two poses of what it sees, at the opening and the closing of the shutter, to JPEG bytes."""

import numpy as np

from drivers.simulated.cameras.arrays import Array, Index, Pixels
from drivers.simulated.cameras.backdrop import Noise, paint_backdrop
from drivers.simulated.cameras.board_view import BoardView
from drivers.simulated.cameras.canvas import Canvas, Window
from drivers.simulated.cameras.curve import Curve, see_curve
from drivers.simulated.cameras.disks import Disks
from drivers.simulated.cameras.holder import Holder
from drivers.simulated.cameras.jpeg import Raster, Stretches, splice
from drivers.simulated.cameras.light import Light, bgr
from drivers.simulated.cameras.printed_board import REFERENCE_BOARD, printed_board
from drivers.simulated.cameras.projection import Projection
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from drivers.simulated.cameras.tube import Tube
from drivers.simulated.cameras.vectors import lengths
from messaging.board import BoardSettings
from messaging.frames import CameraCalibration

_PICTURES = 6  # that lie ready without robot; the noise outside of the robot's window repeats after that many
_MARGIN_PX = 6


class Renderer:
    """Renders what one camera sees. Everything that does not depend on the pose is done once, here."""

    def __init__(
        self,
        calibration: CameraCalibration,
        section_end_mm: Array,
        settings: SimulatedCamerasSettings,
        seed: int,
        board: BoardSettings = REFERENCE_BOARD,
    ) -> None:
        """`section_end_mm` (sections,) are distances from the base along the centreline, the last one the tip's."""
        self._settings = settings
        self._section_end_mm = section_end_mm
        self._projection = Projection(calibration)
        self._light = Light.seen_by(self._projection, settings.light)
        self._raster = Raster.of(calibration.width_px, calibration.height_px)
        self._rng = np.random.default_rng(seed)
        whole = Window(0, 0, calibration.width_px, calibration.height_px)
        middle_mm = np.array([0.0, 0.0, section_end_mm[-1] / 2])
        shadow_px = self._projection.to_pixels(self._projection.to_camera(middle_mm))
        backdrop = paint_backdrop(
            calibration.width_px,
            calibration.height_px,
            settings.light,
            shadow_px + 0.07 * calibration.width_px,
        )
        self._holder = Holder(settings.body, self._projection, self._light, backdrop)
        self._board = BoardView(
            printed_board(board),
            self._projection,
            self._light,
            gradient=settings.light.gradient,
            lens_blur_px=settings.sensor.lens_blur_px,
        )
        self._board_seen: tuple[bytes, ...] = ()
        self._noise = Noise(
            calibration.width_px, calibration.height_px, settings.sensor.noise_levels, self._rng
        )
        self._empty = [self._encode(self._noise.on(backdrop, whole)) for _ in range(_PICTURES)]

    def render(self, opened_mm: Array, closed_mm: Array) -> bytes:
        """The picture of the robot whose centreline (N, 3), evenly spaced in arc length, moved from one to the other."""
        robot = self.draw(opened_mm, closed_mm)
        window = self._raster.widen(robot.window.around(self._holder.window))
        pixels = self._holder.picture[window.slices].copy()
        pixels[robot.window.within(window).slices] = robot.pixels
        return self._take(pixels, window)

    def render_empty(self, base_mm: Array) -> bytes:
        """The picture of the holder alone, below a base at (3,) in the robot frame."""
        self._holder.stand_below(base_mm)
        window = self._raster.widen(self._holder.window)
        return self._take(self._holder.picture[window.slices], window)

    def render_board(self, base_mm: Array, opened: Array, closed: Array) -> bytes:
        """The picture of the board before the holder, whose `robot_from_board` (4, 4) went from one to the other."""
        seen = (opened.tobytes(), closed.tobytes(), np.round(base_mm, 2).tobytes())
        if seen != self._board_seen:
            self._holder.stand_below(base_mm)
            picture = self._holder.picture.copy()
            changed = self._board.paint(picture, opened, closed) or self._holder.window
            self._board_window = self._raster.widen(changed.around(self._holder.window))
            self._board_pixels = picture[self._board_window.slices].copy()
            self._board_seen = seen
        return self._take(self._board_pixels, self._board_window)

    def draw(self, opened_mm: Array, closed_mm: Array) -> Canvas:
        """The part of the picture that shows the robot, before noise and coding."""
        body, blur_px = self._settings.body, self._settings.sensor.lens_blur_px
        base_mm = (opened_mm[0] + closed_mm[0]) / 2
        curve = see_curve(opened_mm, closed_mm, max(body.diameter_mm), self._projection)
        self._holder.stand_below(base_mm)
        canvas = Canvas(self._holder.picture, self._window(curve))
        for fragments in self._tube(curve).fragments(self._projection, canvas.window, self._light, blur_px):
            canvas.paint(fragments)
        canvas.paint(self._disks(curve).fragments(self._projection, canvas.window, self._light, blur_px))
        return canvas

    def _window(self, curve: Curve) -> Window:
        body = self._settings.body
        radius_mm = max(body.diameter_mm) / 2 + body.disk_proud_mm
        motion_mm = float(lengths(curve.motion_mm).max())
        nearest_mm = float(curve.points_mm[:, 2].min()) - radius_mm
        reach_px = (radius_mm + motion_mm) * self._projection.focal_px / nearest_mm + _MARGIN_PX
        robot_px = self._projection.to_pixels(curve.points_mm)
        left, top = (robot_px.min(axis=0) - reach_px).astype(int).tolist()
        right, bottom = (robot_px.max(axis=0) + reach_px + 1).astype(int).tolist()
        return self._raster.widen(Window(left, top, right, bottom))

    def _tube(self, curve: Curve) -> Tube:
        section = self._section(curve.arc_mm)
        body = self._settings.body
        colours = np.array([bgr(colour) for colour in body.tube_colour])
        return Tube(curve, np.array(body.diameter_mm)[section] / 2, colours[section])

    def _disks(self, curve: Curve) -> Disks:
        body = self._settings.body
        last_mm = curve.length_mm - body.disk_thickness_mm
        arc_mm = np.arange(body.disk_spacing_mm, last_mm, body.disk_spacing_mm)
        centre_mm, axis = curve.at(arc_mm)
        nearest = np.searchsorted(curve.arc_mm, arc_mm)
        return Disks(
            centre_mm=centre_mm,
            axis=axis,
            motion_mm=curve.motion_mm[nearest],
            radius_mm=np.array(body.diameter_mm)[self._section(arc_mm)] / 2 + body.disk_proud_mm,
            half_thickness_mm=body.disk_thickness_mm / 2,
            colour=bgr(body.disk_colour),
        )

    def _section(self, arc_mm: Array) -> Index:
        """Which section the robot is of at these distances from the base."""
        return np.minimum(np.searchsorted(self._section_end_mm, arc_mm), len(self._section_end_mm) - 1)

    def _take(self, pixels: Pixels, window: Window) -> bytes:
        """A picture in whose window these pixels are seen."""
        patch = self._encode(self._noise.on(pixels, window))
        empty = self._empty[self._rng.integers(_PICTURES)]
        return splice(empty, patch, window, self._raster)

    def _encode(self, pixels: Pixels) -> Stretches:
        return self._raster.encode(pixels, self._settings.sensor.jpeg_quality)
