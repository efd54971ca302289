"""Metadata records that can be trusted: MCAP keeps no checksum of them, so they carry one as an entry of their own."""

import json
import zlib
from collections.abc import Mapping

CHECKSUM = "crc32"


def sealed(facts: Mapping[str, str]) -> dict[str, str]:
    """The facts and their checksum, which takes the place of any fact of that name."""
    return {**facts, CHECKSUM: _checksum(facts)}


def unbroken(record: Mapping[str, str]) -> bool:
    """False when a metadata record does not agree with its checksum; one without a checksum is another producer's."""
    return record.get(CHECKSUM, _checksum(record)) == _checksum(record)


def _checksum(facts: Mapping[str, str]) -> str:
    items = sorted((key, value) for key, value in facts.items() if key != CHECKSUM)
    return f"{zlib.crc32(json.dumps(items).encode()):08x}"
