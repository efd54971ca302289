"""A picture with what was measured drawn into it."""

from collections.abc import Sequence

import cv2
import numpy as np

from nodal.cameras.judging.light import PLACES
from nodal.cameras.judging.measuring import Look
from nodal.cameras.judging.sharpness import RISE
from nodal.cameras.judging.verdicts import BLURRED_PX, SHARP_PX, Finding, Verdict
from sensing.pictures.light import Image

GREEN, ORANGE, RED, MAGENTA, CYAN, WHITE = (
    (90, 200, 60),
    (0, 165, 255),
    (60, 60, 235),
    (255, 0, 255),
    (230, 200, 60),
    (245, 245, 245),
)
"""B, G, R."""
COLOURS = {Verdict.GOOD: GREEN, Verdict.FAIR: ORANGE, Verdict.POOR: RED}
FONT = cv2.FONT_HERSHEY_SIMPLEX
LINES_A_WIDTH = 58
"""The picture's width over the height of a line of text."""


def annotated(look: Look, findings: Sequence[Finding]) -> Image:
    """BGR, as wide as the picture: the picture with edges coloured by their width, outlines of what stands out, clipped pixels in
    magenta and the backdrop's light in percent of its brightest place; below it the findings.
    """
    picture = look.picture.copy()
    _outline(picture, look)
    picture[look.lighting.clipped] = MAGENTA
    _edges(picture, look)
    line_px = max(picture.shape[1] // LINES_A_WIDTH, 12)
    _light(picture, look, line_px)
    return np.vstack([picture, _words(findings, picture.shape[1], line_px)])


def _outline(picture: Image, look: Look) -> None:
    without_specks = cv2.medianBlur(look.lighting.standing_out.view(np.uint8), 5)
    mask = cv2.resize(without_specks, look.size_px, interpolation=cv2.INTER_NEAREST)
    contours, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    cv2.drawContours(picture, contours, -1, CYAN, 1)


def _edges(picture: Image, look: Look) -> None:
    width_px = RISE * look.edges.blur_px
    for least, most, colour in (
        (BLURRED_PX, np.inf, RED),
        (SHARP_PX, BLURRED_PX, ORANGE),
        (0.0, SHARP_PX, GREEN),
    ):
        columns, rows = look.edges.places[(width_px >= least) & (width_px < most)].T
        for down, across in ((0, 0), (0, 1), (1, 0), (1, 1)):
            picture[
                np.minimum(rows + down, picture.shape[0] - 1),
                np.minimum(columns + across, picture.shape[1] - 1),
            ] = colour


def _light(picture: Image, look: Look, line_px: int) -> None:
    height, width = picture.shape[:2]
    for row, column in np.ndindex(look.lighting.places.shape):
        x, y = int((column + 0.5) * width / PLACES[0]), int((row + 0.5) * height / PLACES[1])
        _text(picture, f"{100 * look.lighting.places[row, column]:.0f} %", (x - line_px, y), WHITE, line_px)


def _words(findings: Sequence[Finding], width: int, line_px: int) -> Image:
    strip = np.full((line_px * (len(findings) + 3), width, 3), 30, dtype=np.uint8)
    for number, finding in enumerate(findings):
        y = line_px * (number + 1) + line_px // 3
        _text(strip, finding.verdict.value, (line_px, y), COLOURS[finding.verdict], line_px)
        _text(strip, f"{finding.subject}: {finding.words}", (5 * line_px, y), WHITE, line_px)
    legend = (
        f"edges: green up to {SHARP_PX:g} px wide, orange up to {BLURRED_PX:g}, red beyond; blue: what stands out; "
        "magenta: clipped; %: light on the backdrop"
    )
    _text(strip, legend, (line_px, line_px * (len(findings) + 2)), (170, 170, 170), line_px)
    return strip


def _text(picture: Image, text: str, at: tuple[int, int], colour: tuple[int, int, int], line_px: int) -> None:
    scale = line_px / 45
    for thickness, ink in ((4, (30, 30, 30)), (1, colour)):
        cv2.putText(picture, text, at, FONT, scale, ink, thickness, cv2.LINE_AA)
