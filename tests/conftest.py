import socket
import time

import hypothesis
import pytest

from messaging.settings import ZenohSettings
from nodal.arithmetic import pin

# before any test imports NumPy or OpenCV: golden recordings have the same bytes on every CPU
pin()

# the same examples on every run: what is tried does not depend on luck
hypothesis.settings.register_profile("repeatable", derandomize=True)
hypothesis.settings.load_profile("repeatable")


@pytest.fixture
def zenoh_settings():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return ZenohSettings(rendezvous=f"tcp/127.0.0.1:{port}")


@pytest.fixture
def eventually():
    """Call something until it returns a true value; fail after a deadline."""

    def call(condition, within_s=15.0):
        deadline = time.monotonic() + within_s
        while not (value := condition()):
            assert time.monotonic() < deadline, f"nothing came of it within {within_s} s"
            time.sleep(0.005)
        return value

    return call
