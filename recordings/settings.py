"""Settings of the recorder, as they stand in the bench file."""

from typing import Annotated, Literal

import msgspec


class RecorderSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where recordings go and how they are written.

    `flush_period_s` bounds what a power cut can take. `ring_depth` is how many publications of one topic may wait
    while the disk stalls; memory is used only then. Camera frames are JPEG and do not compress any further, so
    `compression` is worth its time only on benches that log little else than small messages.
    """

    folder: str = "recordings"
    chunk_bytes: Annotated[int, msgspec.Meta(ge=4096, le=64 * 2**20)] = 2**20
    compression: Literal["none", "lz4"] = "none"
    flush_period_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.5
    ring_depth: Annotated[int, msgspec.Meta(ge=16, le=65536)] = 1024
