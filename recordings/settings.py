"""Settings of the recorder, as they stand in the bench file."""

from typing import Annotated, Literal

import msgspec

Bytes = Annotated[int, msgspec.Meta(ge=0)]
Seconds = Annotated[float, msgspec.Meta(ge=0, le=86400)]


class RecorderSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where recordings go, when they begin and how they are written; docs/recording.md explains all of it.

    `begin` says whether a recording begins with the process or with `nodal record start`. A recording goes on in its next
    part after `rotate_bytes` or `rotate_s` (0: never), and ends when less than `least_free_bytes` is left on the disk.

    `rolling_s` seconds are kept in memory while nothing is recorded (0: nothing is), and saved on request or when the
    controller's state becomes `fault`, with the `rolling_follow_s` that follow. `memory_bytes` bounds what is kept in this
    way, and what waits for a disk that stalls; beyond it the oldest goes first.

    `flush_period_s` bounds what a power cut can take. `ring_depth` is how many publications of one topic may wait to be
    heard. Camera frames are JPEG and do not compress any further, so `compression` is worth its time only on benches that
    log little else than small messages.
    """

    folder: str = "recordings"
    begin: Literal["at once", "on request"] = "at once"
    rotate_bytes: Bytes = 4 * 2**30
    rotate_s: Seconds = 0.0
    least_free_bytes: Bytes = 2**30
    rolling_s: Seconds = 0.0
    rolling_follow_s: Seconds = 5.0
    memory_bytes: Annotated[int, msgspec.Meta(ge=2**20)] = 512 * 2**20
    chunk_bytes: Annotated[int, msgspec.Meta(ge=4096, le=64 * 2**20)] = 2**20
    compression: Literal["none", "lz4"] = "none"
    flush_period_s: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.5
    ring_depth: Annotated[int, msgspec.Meta(ge=16, le=65536)] = 1024
