"""Draws scenes: a panel for each camera side by side, the caption below."""

import dataclasses
from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from messaging.control import ControllerState, Target
from messaging.frames import CameraCalibration, Frame
from nodal.exports.video.captions import Caption, Tone, caption
from nodal.exports.video.scenes import Scene
from sensing.geometry.camera import Camera

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

# in OpenCV's order: blue, green, red
CENTRELINE: Colour = (255, 200, 88)
NODE: Colour = (86, 62, 232)
DESIRED: Colour = (112, 224, 140)
PATH: Colour = (236, 236, 236)
WHITE: Colour = (255, 255, 255)
SHADOW: Colour = (24, 22, 20)
TONES: dict[Tone, Colour] = {
    Tone.PLAIN: (232, 230, 226),
    Tone.DOUBT: (80, 190, 250),
    Tone.TROUBLE: (110, 100, 250),
}
LEGEND = (
    ("centreline", CENTRELINE),
    ("nodal points", NODE),
    ("where they should be", DESIRED),
    ("target's path", PATH),
)

SUBPIXEL_BITS = 4
REGULAR, BOLD = 400, 650
SMALLEST_TEXT_PX, TEXT_SHARE = 11, 76
"""The film is this many times wider than text is high, but never too small to read."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Panel:
    """Where one camera's picture stands in the film, and how much smaller than the camera took it."""

    camera: Camera
    left_px: int
    width_px: int
    height_px: int

    def places(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels (N, 2) of the panel for points (N, 3) in the robot frame, lens distortion included."""
        width_px, height_px = self.camera.size_px
        shrunk = self.width_px / width_px, self.height_px / height_px
        return (self.camera.project(np.ascontiguousarray(points_mm)) + 0.5) * shrunk - 0.5


class Stage:
    """Draws scenes of these cameras. `width_px` and `height_px` are the film's, and even, as video asks."""

    def __init__(self, cameras: Sequence[CameraCalibration], width_px: int, beginning_ns: int) -> None:
        """Seconds are counted from `beginning_ns`."""
        each_px = _even(width_px / len(cameras))
        self.width_px = each_px * len(cameras)
        self.panels = tuple(
            Panel(
                camera=Camera(camera),
                left_px=number * each_px,
                width_px=each_px,
                height_px=_even(each_px * camera.height_px / camera.width_px),
            )
            for number, camera in enumerate(cameras)
        )
        self._text_px = max(self.width_px // TEXT_SHARE, SMALLEST_TEXT_PX)
        self._pictures_px = max(panel.height_px for panel in self.panels)
        self.height_px = _even(self._pictures_px + 5.4 * self._text_px)
        self._beginning_ns = beginning_ns
        self._font = cv2.FontFace("sans")

    def drawn(self, scene: Scene) -> Picture:
        """The scene (height, width, 3) in BGR."""
        film = np.full((self.height_px, self.width_px, 3), SHADOW, np.uint8)
        for panel in self.panels:
            name = panel.camera.name
            shown = _decoded(scene.frames.get(name), panel)
            if shown is None:
                shown = np.full((panel.height_px, panel.width_px, 3), SHADOW, np.uint8)
                self._text(shown, "no picture", (self._text_px, 3 * self._text_px), TONES[Tone.TROUBLE])
            else:
                self._draw_robot(shown, panel, scene)
            self._text(shown, name, (self._text_px, round(1.6 * self._text_px)), WHITE, BOLD)
            film[: panel.height_px, panel.left_px : panel.left_px + panel.width_px] = shown
            film[: panel.height_px, panel.left_px] = SHADOW
        self._draw_caption(film, caption(scene, self._beginning_ns))
        return film

    def _draw_robot(self, shown: Picture, panel: Panel, scene: Scene) -> None:
        if scene.target:
            for path_mm in _paths(scene.target):
                _draw_line(shown, panel.places(path_mm), PATH, 1)
        if scene.shape and not scene.shape.refusal:
            thick = max(self._text_px // 8, 1)
            _draw_line(shown, panel.places(scene.shape.centreline_mm), CENTRELINE, thick)
            if scene.acted_on:
                self._draw_desired(shown, panel, scene.state)
            places = panel.places(scene.shape.node_mm)
            for name, place in zip(scene.shape.node_names, places, strict=True):
                _draw_dot(shown, place, 0.28 * self._text_px, NODE)
                beside = round(place[0] + 0.7 * self._text_px), round(place[1] + 0.3 * self._text_px)
                self._text(shown, name, beside, WHITE)

    def _draw_desired(self, shown: Picture, panel: Panel, state: ControllerState | None) -> None:
        if state is None or not state.target_name:
            return
        for place in panel.places(state.desired_mm):
            _draw_ring(shown, place, 0.5 * self._text_px, DESIRED)

    def _draw_caption(self, film: Picture, said: Caption) -> None:
        across = self._text_px
        first, second, third = (self._pictures_px + round(down * self._text_px) for down in (1.5, 3.1, 4.7))
        self._text(film, said.doing, (across, first), TONES[said.doing_tone], BOLD)
        self._text_right(film, said.time, first)
        self._text(film, said.figures, (across, second), TONES[Tone.PLAIN])
        self._text(film, said.remark, (across, third), TONES[said.remark_tone])
        if not said.remark:
            self._draw_legend(film, third)

    def _draw_legend(self, film: Picture, down: int) -> None:
        across = self._text_px
        for words, colour in LEGEND:
            radius = 0.25 * self._text_px
            _draw_dot(film, np.array([across + radius, down - 0.35 * self._text_px]), radius, colour)
            across = self._text(film, words, (across + self._text_px, down), TONES[Tone.PLAIN])
            across += 2 * self._text_px

    def _text(
        self, picture: Picture, words: str, where: tuple[int, int], colour: Colour, weight: int = REGULAR
    ) -> int:
        """Write, and return the column after the last letter. A shadow keeps it readable on any picture."""
        apart = max(self._text_px // 16, 1)
        x, y = where
        cv2.putText(picture, words, (x + apart, y + apart), SHADOW, self._font, self._text_px, weight)
        end, _ = cv2.putText(picture, words, where, colour, self._font, self._text_px, weight)
        return int(end[0])

    def _text_right(self, film: Picture, words: str, down: int) -> None:
        box = cv2.getTextSize((0, 0), words, (0, 0), self._font, self._text_px, REGULAR)
        across = self.width_px - self._text_px - box[2]
        # a long line from the left ends before this one
        film[down - self._text_px : down + self._text_px // 2, across - self._text_px :] = SHADOW
        self._text(film, words, (across, down), TONES[Tone.PLAIN])


def _paths(target: Target) -> Iterator[NDArray[np.float64]]:
    """The path (T, 3) of each nodal point that counts."""
    for number in np.flatnonzero(target.weights > 0):
        yield target.position_mm[:, number]


def _decoded(frame: Frame | None, panel: Panel) -> Picture | None:
    """The picture in the panel's size; None when there is none that can be read."""
    if frame is None:
        return None
    halved = 2 * panel.width_px <= panel.camera.size_px[0]
    how = cv2.IMREAD_REDUCED_COLOR_2 if halved else cv2.IMREAD_COLOR
    picture = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), how)
    if picture is None:
        return None
    size = panel.width_px, panel.height_px
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def _draw_line(picture: Picture, places: NDArray[np.float64], colour: Colour, thick: int) -> None:
    corners = np.rint(places * 2**SUBPIXEL_BITS).astype(np.int32)
    cv2.polylines(picture, [corners], False, colour, thick, cv2.LINE_AA, SUBPIXEL_BITS)


def _draw_dot(picture: Picture, place: NDArray[np.float64], radius: float, colour: Colour) -> None:
    _circle(picture, place, radius + 1, WHITE, cv2.FILLED)
    _circle(picture, place, radius, colour, cv2.FILLED)


def _draw_ring(picture: Picture, place: NDArray[np.float64], radius: float, colour: Colour) -> None:
    _circle(picture, place, radius, colour, max(round(radius / 5), 1))


def _circle(picture: Picture, place: NDArray[np.float64], radius: float, colour: Colour, thick: int) -> None:
    x, y, r = (round(value * 2**SUBPIXEL_BITS) for value in (*place, radius))
    cv2.circle(picture, (x, y), r, colour, thick, cv2.LINE_AA, SUBPIXEL_BITS)


def _even(pixels: float) -> int:
    return 2 * round(pixels / 2)
