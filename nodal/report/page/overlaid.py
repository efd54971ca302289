"""A picture of a camera in the page, with something drawn over it."""

from base64 import b64encode
from collections.abc import Sequence
from xml.etree.ElementTree import Element

import cv2
import numpy as np
from numpy.typing import NDArray

from nodal.report.page.markup import element

HIGHEST_PX = 640
QUALITY = 82


def picture_svg(
    picture: NDArray[np.uint8],
    words: str,
    overlay: Sequence[Element] = (),
    part: tuple[int, int, int, int] | None = None,
    highest_px: int = HIGHEST_PX,
) -> Element:
    """The part (x0, y0, x1, y1) of an RGB picture (H, W, 3), or all of it, scaled down where it is higher than `highest_px`.

    The drawing's units are pixels of the whole picture, so that what is drawn over it needs no other scale.
    """
    x0, y0, x1, y1 = part or (0, 0, picture.shape[1], picture.shape[0])
    share = min(highest_px / (y1 - y0), 1.0)
    small = cv2.resize(picture[y0:y1, x0:x1], None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    _, coded = cv2.imencode(
        ".jpg", cv2.cvtColor(small, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    )
    data = f"data:image/jpeg;base64,{b64encode(coded.tobytes()).decode()}"
    box = {"x": f"{x0 - 0.5}", "y": f"{y0 - 0.5}", "width": f"{x1 - x0}", "height": f"{y1 - y0}"}
    return element(
        "svg",
        element("image", href=data, **box),
        overlay,
        viewBox=" ".join(box.values()),
        class_="frame",
        role="img",
        aria_label=words,
    )
