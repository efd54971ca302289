"""The units say nothing that systemd does not understand, and leave the services little to break."""

import ctypes
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SYSTEMD = Path(__file__).parents[2] / "systemd"
SERVICES = sorted(path.name for path in SYSTEMD.glob("*.service"))
LARGEST_EXPOSURE = 2.5
PR_SET_MDWE, PR_GET_MDWE = 65, 66
"""prctl(2), Linux 6.3: what MemoryDenyWriteExecute= asks of the kernel, for this process and its children."""


@pytest.fixture(scope="module")
def analyze():
    """Run systemd-analyze; its exit code and all that it said."""
    if shutil.which("systemd-analyze") is None:
        absent = "systemd-analyze is missing; tools/install_debian_packages.sh installs it"
        if os.environ.get("CI") == "true":
            pytest.fail(absent)
        pytest.skip(absent)

    def run(folder, *arguments):
        # the trailing colon keeps systemd's own folders in the search path
        environment = {**os.environ, "SYSTEMD_UNIT_PATH": f"{folder}:", "LC_ALL": "C"}
        done = subprocess.run(
            ["systemd-analyze", "--no-pager", *arguments],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout

    return run


@pytest.fixture
def installed(tmp_path):
    """The units as they would be installed, with a program that exists in the place of `nodal`."""
    shutil.copytree(SYSTEMD, tmp_path / "system")
    for service in SERVICES:
        unit = tmp_path / "system" / service
        unit.write_text(unit.read_text().replace("/opt/nodal/.venv/bin/nodal", sys.executable))
    return tmp_path / "system"


def test_every_process_has_a_unit():
    processes = {"rendezvous", "sense", "control", "record", "simulate"}
    assert set(SERVICES) == {f"nodal-{process}.service" for process in processes}


@pytest.mark.parametrize("service", SERVICES)
def test_a_unit_starts_its_own_process(service):
    process = service.removeprefix("nodal-").removesuffix(".service")
    text = (SYSTEMD / service).read_text()
    assert f"ExecStart=/opt/nodal/.venv/bin/nodal {process} --config ${{NODAL_BENCH}}\n" in text
    assert "WatchdogSec=" in text
    assert "PartOf=nodal.target" in text
    assert "WantedBy=nodal.target" in text


def test_services_tell_of_their_start_and_come_back_after_a_failure():
    common = (SYSTEMD / "nodal-.service.d" / "common.conf").read_text()
    assert {"Type=notify", "Restart=on-failure", "MemoryDenyWriteExecute=yes"} <= set(common.splitlines())


@pytest.mark.parametrize("unit", [*SERVICES, "nodal.target"])
def test_systemd_has_nothing_to_say_about_a_unit(analyze, installed, unit):
    assert analyze(installed, "verify", str(installed / unit)) == (0, "")


def test_a_misspelt_key_would_be_heard_of(analyze, installed):
    with (installed / "nodal-.service.d" / "common.conf").open("a") as common:
        common.write("ProtectHoem=yes\n")
    assert "ProtectHoem" in analyze(installed, "verify", str(installed / "nodal-sense.service"))[1]


@pytest.mark.parametrize("service", SERVICES)
def test_a_service_is_confined(analyze, installed, service):
    threshold = f"--threshold={10 * LARGEST_EXPOSURE:.0f}"
    code, said = analyze(installed, "security", "--offline=yes", threshold, str(installed / service))
    assert code == 0, said
    assert float(re.search(r"exposure level for .*: ([\d.]+)", said)[1]) <= LARGEST_EXPOSURE


def test_an_open_service_would_be_heard_of(analyze, installed):
    shutil.rmtree(installed / "nodal-.service.d")
    unit = installed / "nodal-sense.service"
    assert analyze(installed, "security", "--offline=yes", "--threshold=25", str(unit))[0] != 0


def test_the_libraries_run_without_memory_that_is_writable_and_executable():
    libc = ctypes.CDLL(None)
    if libc.prctl(PR_GET_MDWE, 0, 0, 0, 0) < 0:
        pytest.skip("this kernel is older than 6.3 and cannot confine a process so")
    work = (
        "import cv2, linuxpy.video.device, numpy, scipy.optimize, serial, zenoh\n"
        "from mcap.writer import Writer\n"
        "cv2.imdecode(cv2.imencode('.jpg', numpy.zeros((64, 64, 3), 'u1'))[1], 1)\n"
        "scipy.optimize.least_squares(lambda x: x - 1, [0.0])\n"
        'config = \'{mode: "peer", listen: {endpoints: ["tcp/127.0.0.1:0"]}, scouting: {multicast: {enabled: false}}}\'\n'
        "with zenoh.open(zenoh.Config.from_json5(config)) as session: session.put('key', b'value')\n"
    )
    confined = subprocess.run(
        [sys.executable, "-c", work],
        preexec_fn=lambda: libc.prctl(PR_SET_MDWE, 1, 0, 0, 0),
        capture_output=True,
        text=True,
        check=False,
    )
    assert confined.returncode == 0, confined.stderr


def test_cameras_are_for_sensing_alone():
    reaching = {
        service for service in SERVICES if "DeviceAllow=char-video4linux" in (SYSTEMD / service).read_text()
    }
    assert reaching == {"nodal-sense.service"}
    assert "SupplementaryGroups=video\n" in (SYSTEMD / "nodal-sense.service").read_text()


def test_only_the_controller_may_ask_for_real_time(analyze, installed):
    def restricted(service):
        _, said = analyze(installed, "security", "--offline=yes", "--json=short", str(installed / service))
        return next(row["set"] for row in json.loads(said) if row["json_field"] == "RestrictRealtime")

    assert {service: restricted(service) for service in SERVICES} == {
        service: service != "nodal-control.service" for service in SERVICES
    }


def test_what_the_controller_may_ask_for_is_granted_by_its_unit():
    granted = (SYSTEMD / "nodal-control.service.d" / "real-time.conf").read_text().splitlines()
    assert {"RestrictRealtime=no", "LimitRTPRIO=50", "LimitMEMLOCK=infinity"} <= set(granted)
