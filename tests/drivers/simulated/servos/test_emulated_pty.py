"""The serial device of the emulated servos: clients come and go, the link is kept honest, nothing stays behind."""

import os
import select
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import serial

from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.errors import EmulatedServosError, LinkError, ServoStepError
from drivers.simulated.servos.settings import EmulatedServosSettings

PING = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
DEADLINE_S = 5.0


def ping(link):
    """Open the device as any program would, ask, and return the answer."""
    with serial.Serial(str(link), 1_000_000, timeout=DEADLINE_S, exclusive=True) as port:
        port.write(PING)
        return port.read(14)


def test_clients_come_and_go(servos, settings):
    for _ in range(3):
        assert ping(settings.link)[4] == 1


def test_a_client_that_leaves_in_the_middle_of_a_packet_does_no_harm(servos, settings):
    with serial.Serial(settings.link) as port:
        port.write(PING[:6])
    with serial.Serial(settings.link) as port:
        port.write(os.urandom(3000))
    assert ping(settings.link)[4] == 1


def test_a_client_that_never_reads_stops_nobody(servos, settings):
    with serial.Serial(settings.link, write_timeout=DEADLINE_S) as port:
        for _ in range(200):
            port.write(PING * 40)
        port.reset_input_buffer()
    assert servos.step(0.01, np.zeros(3)).shape == (3,)
    deadline_s = time.monotonic() + DEADLINE_S
    while ping(settings.link)[:5] != b"\xff\xff\xfd\x00\x01":
        assert time.monotonic() < deadline_s


def test_the_link_goes_away_with_the_device(settings, tmp_path):
    with EmulatedServos(settings):
        assert str(Path(settings.link).readlink()).startswith("/dev/pts/")
    assert list(tmp_path.iterdir()) == []


def test_a_stale_link_is_replaced(settings):
    Path(settings.link).symlink_to("/dev/pts/no-longer-there")
    with EmulatedServos(settings):
        assert ping(settings.link)[4] == 1


@pytest.mark.parametrize("make", [lambda path: path.write_text("precious"), lambda path: path.mkdir()])
def test_anything_else_at_the_links_place_is_left_alone(settings, tmp_path, make):
    make(tmp_path / "servos")
    with pytest.raises(LinkError, match="is taken"):
        EmulatedServos(settings).open()
    assert (tmp_path / "servos").exists()


def test_a_link_that_cannot_be_made_is_named(tmp_path):
    with pytest.raises(LinkError, match="No such file or directory"):
        EmulatedServos(EmulatedServosSettings(link=str(tmp_path / "no" / "where"), ids=(1,))).open()


def test_a_link_that_leads_elsewhere_by_now_is_left_alone(settings):
    first = EmulatedServos(settings)
    first.open()
    with EmulatedServos(settings):
        first.close()
        assert ping(settings.link)[4] == 1


def test_kill_9_leaves_only_a_stale_link_that_the_next_start_replaces(settings):
    program = (
        "import sys, time; from drivers.simulated.servos.emulated import EmulatedServos;"
        "from drivers.simulated.servos.settings import EmulatedServosSettings;"
        f"EmulatedServos(EmulatedServosSettings(link={settings.link!r}, ids=(1,))).open();"
        "print('open', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE) as process:
        ready, _, _ = select.select([process.stdout], [], [], 30)
        assert ready
        assert process.stdout.readline() == b"open\n"
        assert ping(settings.link)[4] == 1
        process.send_signal(signal.SIGKILL)
    assert Path(settings.link).is_symlink()
    with EmulatedServos(settings):
        assert ping(settings.link)[4] == 1


def test_nothing_stays_open(settings):
    def descriptors():
        return len(list(Path("/proc/self/fd").iterdir()))

    before, threads = descriptors(), threading.active_count()
    for _ in range(5):
        with EmulatedServos(settings):
            ping(settings.link)
    assert descriptors() == before
    assert threading.active_count() == threads


def test_stepping_and_asking_go_on_side_by_side(servos, settings):
    stop = threading.Event()

    def step():
        while not stop.is_set():
            servos.step(0.005, np.zeros(3))

    stepping = threading.Thread(target=step)
    stepping.start()
    try:
        assert all(ping(settings.link)[4] == 1 for _ in range(50))
    finally:
        stop.set()
        stepping.join()


@pytest.mark.parametrize(
    ("dt_s", "load_Nm"), [(0.0, [0, 0, 0]), (np.nan, [0, 0, 0]), (0.01, [0, 0]), (0.01, [0, np.nan, 0])]
)
def test_impossible_steps_are_refused(servos, dt_s, load_Nm):
    with pytest.raises(ServoStepError):
        servos.step(dt_s, np.array(load_Nm, float))


def test_stepping_servos_that_nobody_serves_is_an_error(settings):
    with pytest.raises(EmulatedServosError, match="nobody serves"):
        EmulatedServos(settings).step(0.01, np.zeros(3))
