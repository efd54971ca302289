"""A background picture with what was found in it drawn over it, for people and for the report."""

import cv2
import numpy as np

from nodal.calibrate.background.judging import CameraBackground
from sensing.pictures.light import Image

AREA, SPOT = (60, 220, 250), (60, 60, 250)
"""B, G, R."""
DIM = 0.55


def drawn(picture: Image, found: CameraBackground) -> Image:
    """The picture (h, w, 3): outside of the work area darkened, spots in boxes."""
    seen = picture.copy()
    thickness = max(picture.shape[1] // 640, 1)
    if found.work_area is not None:
        corners = np.rint(np.array(found.work_area)).astype(np.int32)
        inside = np.zeros(picture.shape[:2], dtype=np.uint8)
        cv2.fillPoly(inside, [corners], 255)
        seen[inside == 0] = (DIM * seen[inside == 0]).astype(np.uint8)
        cv2.polylines(seen, [corners], isClosed=True, color=AREA, thickness=thickness, lineType=cv2.LINE_AA)
    for spot in found.spots:
        x, y, width, height = spot.box_px
        cv2.rectangle(seen, (x, y), (x + width, y + height), SPOT, thickness)
    return seen
