"""One camera's picture, decoded only as far as it is needed.

Measuring a known shape anew needs brightness alone, which costs half of what colour costs, and of a part where the
camera's JPEG allows it; only finding the robot without a prior needs colour, and a coarse one at first.
"""

from functools import cached_property

import cv2
import numpy as np

from sensing.errors import ImageSizeError, UnreadableImageError
from sensing.pictures.coding import coding_of
from sensing.pictures.grid import Grid
from sensing.pictures.jpeg import Jpeg
from sensing.pictures.jpeg_crop import Box, crop
from sensing.pictures.jpeg_gaps import data_left, data_missing
from sensing.pictures.light import Image, luma

REDUCED = {
    2: cv2.IMREAD_REDUCED_COLOR_2,
    4: cv2.IMREAD_REDUCED_COLOR_4,
    8: cv2.IMREAD_REDUCED_COLOR_8,
}
"""How a JPEG is decoded at once to a size that many times smaller."""
ONE_OF_16_BITS = 1 / 257
"""65535 becomes 255."""


class Picture:
    """The coded picture (JPEG, PNG or BMP) of one camera, with 8 or 16 bits a level, in colour or grey.

    Orientation in EXIF and transparency are not looked at. Raises UnreadableImageError for bytes that are not a whole
    picture, and ImageSizeError for a size that differs from `size_px` (width, height): before anything is decoded,
    as far as headers tell. Decoding raises UnreadableImageError too. JPEGs whose data end early are refused, although
    decoders fill the rest with grey and say nothing (`jpeg_gaps.py`). What was decoded is kept.

    CPU time of one 1920x1080 JPEG of the simulated cameras (72 kB), in ms: the header 0.1, `luma_around` 0.9 with restart
    markers, `luma` 2.6, `reduced` by 2, 4, 8 2.7, 2.1, 1.8, `colour` 4.9. Data are read at the same cost at every size,
    which is why an eighth is no cheaper.
    """

    def __init__(self, camera: str, data: bytes, size_px: tuple[int, int]) -> None:
        self._coding = coding_of(camera, data)
        if self._coding.size_px != size_px:
            (width, height), (known_width, known_height) = self._coding.size_px, size_px
            raise ImageSizeError(
                camera,
                f"the picture is {width}x{height} px, its calibration is for {known_width}x{known_height} px",
            )
        self.camera = camera
        self._bytes = data
        self.size_px = size_px
        self._reduced: dict[int, Image] = {}

    @property
    def grey(self) -> bool:
        """Whether it was coded without colours."""
        return self._coding.grey

    @cached_property
    def colour(self) -> Image:
        """BGR (h, w, 3); all alike in a grey picture."""
        return self._whole(cv2.IMREAD_COLOR)

    @cached_property
    def luma(self) -> Image:
        """Brightness (h, w); taken from the colours when those are decoded already."""
        if "colour" in self.__dict__:
            return luma(self.colour)
        return self._whole(cv2.IMREAD_GRAYSCALE)

    def reduced(self, factor: int) -> Image:
        """BGR (ceil(h / factor), ceil(w / factor), 3), `factor` times smaller, each pixel standing for a square of
        factor x factor: its centre is at (place + 0.5) * factor - 0.5 in full-size px.

        A JPEG is decoded to a half, a quarter or an eighth at once; anything else is decoded whole and averaged.
        """
        if factor not in self._reduced:
            if factor not in REDUCED or self._coding.jpeg is None or "colour" in self.__dict__:
                self._reduced[factor] = Grid(self.size_px, factor).reduced(self.colour)
            else:
                self._reduced[factor] = self._whole(REDUCED[factor], factor)
        return self._reduced[factor]

    def luma_around(self, box: Box) -> tuple[Image, Box]:
        """Brightness of a part that covers `box` as far as it lies in the picture, and which part that is.

        Only that part is decoded where the camera's JPEG allows it; otherwise it is the whole picture.
        """
        jpeg = self._coding.jpeg
        part = None if jpeg is None or "luma" in self.__dict__ else crop(jpeg, box)
        if part is None:
            return self.luma, (0, 0, *self.size_px)
        cropped, shown = part
        return self._of_jpeg(cropped, cv2.IMREAD_GRAYSCALE), shown

    def _whole(self, mode: int, factor: int = 1) -> Image:
        if self._coding.jpeg is not None:
            return self._of_jpeg(self._coding.jpeg, mode, factor)
        picture = _decoded(self._bytes, mode | cv2.IMREAD_ANYDEPTH)
        if picture is None:
            raise UnreadableImageError(
                self.camera,
                f"the picture of {len(self._bytes)} bytes cannot be decoded: it is cut off or damaged",
            )
        if picture.dtype == np.uint16:
            return np.asarray(cv2.convertScaleAbs(picture, alpha=ONE_OF_16_BITS), dtype=np.uint8)
        return picture

    def _of_jpeg(self, jpeg: Jpeg, mode: int, factor: int = 1) -> Image:
        def decode(data: bytes) -> Image | None:
            return _decoded(data, mode)

        picture = decode(jpeg.data)
        if picture is None or picture.shape[:2] != (-(-jpeg.height // factor), -(-jpeg.width // factor)):
            raise UnreadableImageError(
                self.camera, f"the JPEG of {len(self._bytes)} bytes cannot be decoded: it is damaged"
            )
        if data_missing(jpeg, picture, factor, decode) or data_left(jpeg, factor, decode):
            raise UnreadableImageError(
                self.camera,
                f"the JPEG of {len(self._bytes)} bytes is damaged: its data are not those of all its pixels",
            )
        return picture


def _decoded(data: bytes, mode: int) -> Image | None:
    """What OpenCV makes of these bytes; None when it cannot."""
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), mode | cv2.IMREAD_IGNORE_ORIENTATION)  # type: ignore[return-value]
    except cv2.error:
        return None
