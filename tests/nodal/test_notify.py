"""Signs of life on a real datagram socket."""

import socket

import pytest

from nodal.notify import Health


@pytest.fixture
def listener():
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind("")
        listener.setblocking(False)
        yield listener


def environment(listener, **more):
    return {"NOTIFY_SOCKET": "@" + listener.getsockname()[1:].decode(), **more}


def heard(listener):
    words = []
    while True:
        try:
            words.append(listener.recv(100))
        except BlockingIOError:
            return words


def test_the_first_healthy_cycle_says_ready_and_no_more_does(listener):
    healthy = Health(environment(listener))
    assert heard(listener) == []

    healthy()
    healthy()

    assert heard(listener) == [b"READY=1"]


def test_pings_are_rate_limited(listener):
    healthy = Health(environment(listener, WATCHDOG_USEC="60000000"))

    for _ in range(1000):
        healthy()

    assert heard(listener) == [b"READY=1", b"WATCHDOG=1"]


def test_pings_go_on_as_time_does(listener):
    healthy = Health(environment(listener, WATCHDOG_USEC="4"))

    for _ in range(3):
        healthy()

    assert heard(listener) == [b"READY=1", b"WATCHDOG=1", b"WATCHDOG=1", b"WATCHDOG=1"]


def test_an_end_on_purpose_is_said(listener):
    Health(environment(listener)).stopping()

    assert heard(listener) == [b"STOPPING=1"]


def test_a_socket_in_the_file_system_is_reached(tmp_path):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(str(tmp_path / "notify"))
        Health({"NOTIFY_SOCKET": str(tmp_path / "notify")})()

        assert listener.recv(100) == b"READY=1"


def test_a_listener_that_is_gone_harms_nobody(listener):
    healthy = Health(environment(listener, WATCHDOG_USEC="4"))
    healthy()
    listener.close()

    healthy()
    healthy.stopping()


def test_a_listener_that_does_not_listen_is_not_waited_for(listener):
    healthy = Health(environment(listener, WATCHDOG_USEC="4"))

    for _ in range(10_000):
        healthy()


def test_without_a_listener_nothing_is_said():
    healthy = Health({})
    healthy()
    healthy.stopping()
