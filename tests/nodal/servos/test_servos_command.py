"""`nodal servos` as it is typed, against the servos of the bench called `simulated` on their serial device."""

import subprocess
import sys
import threading

import pytest

from drivers.dynamixel.port import SerialPort
from drivers.simulated.servos.emulated import EmulatedServos
from drivers.simulated.servos.settings import EmulatedServosSettings
from nodal.__main__ import main
from nodal.servos import findings

BENCH = ("--config", "simulated")
QUICK = ("--baud", "1000000")


@pytest.fixture
def servos(tmp_path, monkeypatch):
    """Where the bench called `simulated` has its port."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(findings, "EVERY_ID", range(10))  # all would take a second each time
    link = tmp_path / "runs" / "simulated" / "servos"
    link.parent.mkdir(parents=True)
    with EmulatedServos(EmulatedServosSettings(link=str(link), ids=(1, 2, 3, 4, 5), reboot_s=0.05)) as servos:
        servos.link = str(link)
        yield servos


def said(capsys):
    return capsys.readouterr().out.splitlines()


def test_list_says_who_answers(servos, capsys):
    assert main(["servos", "list", *BENCH, *QUICK, "--ids", "0-9"]) == 0
    header, *rows = said(capsys)
    assert header.split()[:4] == ["id", "model", "firmware", "baud"]
    assert [row.split()[:4] for row in rows] == [[str(n), "XM430-W350", "48", "1000000"] for n in range(1, 6)]


def test_a_bench_is_checked_set_up_and_found_well(servos, capsys):
    assert main(["servos", "check", *BENCH]) == 3
    differences = said(capsys)
    assert "servo 3 (distal x): Current Limit is 1193 (3209 mA), needed is 372 (1001 mA)" in differences[6]
    assert main(["servos", "setup", *BENCH]) == 0
    assert said(capsys)[-1] == "15 changed"
    assert main(["servos", "check", *BENCH]) == 0
    assert said(capsys) == [f"5 servos at {servos.link}, 1000000 baud: as the bench file says"]


def test_a_dry_run_says_what_would_change(servos, capsys):
    assert main(["servos", "setup", *BENCH, "--axis", "stage", "--dry-run"]) == 0
    assert said(capsys)[-1] == "3 to change, nothing written"
    assert servos.registers(5, "current_limit") == (1193,)


def test_setup_refuses_torque_in_one_line(servos, capsys):
    servos.set_registers(4, torque_enable=1)
    assert main(["servos", "setup", *BENCH, "--axis", "distal y"]) == 3
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith("nodal: refused: servo 4 (distal y): torque is on")
    assert shown.err.count("\n") == 1
    assert servos.registers(4, "torque_enable", "current_limit") == (1, 1193)


def test_identify_blinks_and_reboot_makes_a_servo_usable(servos, capsys):
    servos.fail(2, 0x20)
    assert main(["servos", "identify", "2", "--port", servos.link, *QUICK, "--seconds", "0.5"]) == 0
    assert servos.registers(2, "led") == (0,)
    assert main(["servos", "reboot", "2", *BENCH, *QUICK]) == 0
    assert said(capsys) == ["servo 2 blinks for 0.5 s", "servo 2 restarted; hardware error: none"]
    assert servos.registers(2, "hardware_error_status") == (0,)


def test_two_servos_with_one_id_are_told(servos, capsys):
    servos.set_registers(3, present_position=3000, id=2)
    assert main(["servos", "list", *BENCH, *QUICK, "--ids", "1-3"]) == 0
    assert "two servos with this id" in said(capsys)[2]
    assert main(["servos", "identify", "2", *BENCH, *QUICK]) == 2
    assert "two servos with this id" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["list", "--port", "nowhere"], "serial port nowhere does not exist; is the adapter plugged in?"),
        (["list", *BENCH, "--baud", "500000"], "--baud 500000: servos speak at 9600, 57600"),
        (["list", *BENCH, *QUICK, "--ids", "9"], "nobody answers at 1000000 baud, ids 9 to 9; is the bus powered"),
        (["identify", "9", *BENCH, *QUICK], "servo 9 does not answer at 1000000 baud"),
        (["identify", "300", *BENCH], "id 300: servos have ids 0 to 252"),
        (["identify", "1", *BENCH, "--seconds", "0"], "--seconds 0: allowed is more than 0, up to 3600 s"),
        (["setup", *BENCH, "--from-id", "1"], "--from-id 1: say with --axis which axis this servo becomes"),
        (["setup", *BENCH, "--axis", "z"], "--axis z: the bench has proximal x"),
    ],
)  # fmt: skip
def test_an_error_is_one_line_and_status_2(servos, capsys, words, complaint):
    assert main(["servos", *words]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith("nodal: error: ")
    assert complaint in shown.err
    assert shown.err.count("\n") == 1


@pytest.mark.parametrize("ids", ["9-1", "0-253", "x", "1-"])
def test_ids_that_cannot_be_are_refused(capsys, ids):
    with pytest.raises(SystemExit):
        main(["servos", "list", *BENCH, "--ids", ids])
    assert "is not A-B within 0 to 252" in capsys.readouterr().err


def test_a_port_that_the_controller_has_is_busy(servos):
    port = SerialPort(servos.link)
    port.open()
    command = [sys.executable, "-m", "nodal", "servos", "check", *BENCH]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    port.close()
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr == f"nodal: error: serial port {servos.link} is in use by another program\n"


def test_an_unplugged_port_is_one_line_of_error(servos, capsys):
    unplug = threading.Timer(0.3, servos.unplug)
    unplug.start()
    assert main(["servos", "identify", "1", *BENCH, *QUICK, "--seconds", "30"]) == 2
    unplug.join()
    assert "was lost" in capsys.readouterr().err
