"""One camera's picture, decoded only as far as it is needed.

Measuring a known shape anew needs brightness alone, which costs half of what colour costs; only finding the robot
without a prior needs colour.
"""

from functools import cached_property

import cv2
import numpy as np

from sensing.errors import ImageSizeError, UnreadableImageError
from sensing.pictures.backdrop import Image, luma
from sensing.pictures.jpeg_crop import Box, crop

JPEG_START, JPEG_END = b"\xff\xd8", b"\xff\xd9"


class Picture:
    """The coded picture (JPEG, PNG, whatever OpenCV reads) of one camera. Decoding raises UnreadableImageError.

    A JPEG that stops in the middle is refused: decoders fill the rest with grey and say nothing. A size that differs from
    `size_px` (width, height) raises ImageSizeError.
    """

    def __init__(self, camera: str, data: bytes, size_px: tuple[int, int]) -> None:
        if not data:
            raise UnreadableImageError(f"camera {camera}: the picture is empty (0 bytes)")
        if data.startswith(JPEG_START) and JPEG_END not in data[-64:]:
            raise UnreadableImageError(
                f"camera {camera}: the JPEG of {len(data)} bytes is cut off before its end"
            )
        self.camera = camera
        self._bytes = data
        self._size_px = size_px

    @cached_property
    def colour(self) -> Image:
        """BGR (h, w, 3)."""
        return self._decoded(cv2.IMREAD_COLOR)

    @cached_property
    def luma(self) -> Image:
        """Brightness (h, w); taken from the colours when those are decoded already."""
        if "colour" in self.__dict__:
            return luma(self.colour)
        return self._decoded(cv2.IMREAD_GRAYSCALE)

    def luma_around(self, box: Box) -> tuple[Image, Box]:
        """Brightness of a part that covers `box` as far as it lies in the picture, and which part that is.

        Only that part is decoded where the camera's JPEG allows it; otherwise it is the whole picture.
        """
        part = None if "luma" in self.__dict__ else crop(self._bytes, self._size_px, box)
        if part is None:
            return self.luma, (0, 0, *self._size_px)
        data, shown = part
        return self._read(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE), shown

    def _decoded(self, mode: int) -> Image:
        picture = self._read(np.frombuffer(self._bytes, np.uint8), mode)
        size = picture.shape[1], picture.shape[0]
        if size != self._size_px:
            raise ImageSizeError(
                f"camera {self.camera}: the picture is {size[0]}x{size[1]} px, "
                f"its calibration is for {self._size_px[0]}x{self._size_px[1]} px"
            )
        return picture

    def _read(self, data: Image, mode: int) -> Image:
        try:
            picture = cv2.imdecode(data, mode | cv2.IMREAD_IGNORE_ORIENTATION)
        except cv2.error as error:
            raise UnreadableImageError(
                f"camera {self.camera}: the picture cannot be decoded ({error.err})"
            ) from error
        if picture is None:
            raise UnreadableImageError(
                f"camera {self.camera}: {data.size} bytes are not a picture in a known format, or it is cut off"
            )
        return np.asarray(picture, dtype=np.uint8)
