import contextlib
import os
import resource

import pytest


@pytest.fixture
def small_disk():
    """A limit on the size of files, which the kernel enforces while the context lasts: writes fail as on a full disk."""

    @contextlib.contextmanager
    def limit(size_bytes):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    return limit


@pytest.fixture
def read_only_folder(tmp_path):
    """A folder that this process may not write to, even when the tests run as root."""
    folder = tmp_path / "read-only"
    folder.mkdir(mode=0o555)
    if os.geteuid() != 0:
        yield folder
        return
    os.seteuid(65534)
    try:
        yield folder
    finally:
        os.seteuid(0)
