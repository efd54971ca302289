"""What the first bytes of a coded picture say of it. What can be refused without decoding is refused here."""

from dataclasses import dataclass

from sensing.errors import UnreadableImageError
from sensing.pictures import jpeg
from sensing.pictures.jpeg import Jpeg

PNG_START, BMP_START = b"\x89PNG\r\n\x1a\n", b"BM"
PNG_HEADER_BYTES, BMP_HEADER_BYTES = 33, 30
PNG_GREY_KINDS = (0, 4)


@dataclass(frozen=True)
class Coding:
    """Size (width, height), whether there is brightness alone, and the JPEG if it is one."""

    size_px: tuple[int, int]
    grey: bool
    jpeg: Jpeg | None


def coding_of(camera: str, data: bytes) -> Coding:
    """How this picture is coded; raises UnreadableImageError for what is not a whole JPEG, PNG or BMP."""
    if not data:
        raise UnreadableImageError(camera, "the picture is empty (0 bytes)")
    if data.startswith(jpeg.START):
        read = Jpeg.read(camera, data)
        return Coding((read.width, read.height), read.grey, read)
    if data.startswith(PNG_START) and len(data) >= PNG_HEADER_BYTES:
        width, height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))
        return Coding((width, height), data[25] in PNG_GREY_KINDS, None)
    if data.startswith(BMP_START) and len(data) >= BMP_HEADER_BYTES:
        if (promised := int.from_bytes(data[2:6], "little")) > len(data):
            raise UnreadableImageError(
                camera, f"the BMP is cut off: {len(data)} of {promised} bytes are there"
            )
        width, height = (int.from_bytes(data[at : at + 4], "little", signed=True) for at in (18, 22))
        return Coding((width, abs(height)), False, None)
    raise UnreadableImageError(
        camera,
        f"{len(data)} bytes are not a picture in a known format, or it is cut off; "
        "allowed are JPEG, PNG and BMP",
    )
