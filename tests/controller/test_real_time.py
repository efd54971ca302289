"""Real time is asked of the real kernel, in processes of their own; what it refuses is said, and what allows it."""

import ctypes
import json
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from controller.errors import RealTimeRefusedError
from controller.process import run
from controller.settings import ControllerSettings, RealTimeSettings
from messaging.settings import RobotSettings

ROOT = Path(__file__).parents[2]
PR_CAPBSET_READ, PR_CAPBSET_DROP = 23, 24
CAP_IPC_LOCK, CAP_SYS_NICE, CAP_SYS_RESOURCE = 14, 23, 24

PROGRAM = """
import json, os, sys, threading
from pathlib import Path
import msgspec
from controller.errors import RealTimeRefusedError
from controller.real_time import enter
from controller.settings import RealTimeSettings

def neighbour():
    started, end = threading.Event(), threading.Event()
    thread = threading.Thread(target=lambda: (started.set(), end.wait()), daemon=True)
    thread.start()
    started.wait()
    return thread.native_id

before = neighbour()
try:
    enter(msgspec.json.decode(sys.argv[1], type=RealTimeSettings))
except RealTimeRefusedError as error:
    print(json.dumps({"refusal": str(error)}))
    sys.exit()
if "wild" in sys.argv:
    while True:
        pass
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
print(json.dumps({
    "policy": os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK,
    "priority": os.sched_getparam(0).sched_priority,
    "neighbours": [os.sched_getscheduler(before), os.sched_getscheduler(neighbour())],
    "cpus": sorted(os.sched_getaffinity(0)),
    "neighbour_cpus": sorted(os.sched_getaffinity(before)),
    "locked_kb": int(status["VmLck"].split()[0]),
    "fifo": os.SCHED_FIFO,
    "other": os.SCHED_OTHER,
}))
"""


def unprivileged():
    """Between fork and exec: what a service without any grant may do, whoever runs the tests."""
    libc = ctypes.CDLL(None)
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
    for capability in (CAP_IPC_LOCK, CAP_SYS_NICE, CAP_SYS_RESOURCE):
        if libc.prctl(PR_CAPBSET_READ, capability, 0, 0, 0) == 1:
            libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)


def entered(*words, settings="{}", before=None):
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, settings, *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=30,
        preexec_fn=before,
    )


def told(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def granted(done):
    """What the process said; the test is left out where this machine does not grant it."""
    said = told(done)
    if "refusal" in said:
        pytest.skip(said["refusal"])
    return said


def test_nothing_is_asked_for_unless_the_bench_file_does():
    said = told(entered(before=unprivileged))
    assert (said["policy"], said["locked_kb"]) == (said["other"], 0)
    assert said["cpus"] == said["neighbour_cpus"]


def test_only_the_loops_own_thread_is_first_in_line():
    said = granted(entered(settings='{"fifo_priority": 7}'))
    assert (said["policy"], said["priority"]) == (said["fifo"], 7)
    assert said["neighbours"] == [said["other"]] * 2, "one that ran before, and one started since"


def test_memory_is_locked():
    assert granted(entered(settings='{"lock_memory": true}'))["locked_kb"] > 10_000


def test_the_loops_thread_keeps_to_its_cores():
    all_cpus = told(entered())["cpus"]
    said = told(entered(settings=json.dumps({"cpus": all_cpus[-1:]})))
    assert said["cpus"] == all_cpus[-1:]
    assert said["neighbour_cpus"] == all_cpus


def test_a_loop_that_runs_wild_is_ended_before_it_starves_the_machine():
    granted(entered(settings='{"fifo_priority": 1}'))
    assert entered("wild", settings='{"fifo_priority": 1}').returncode == -signal.SIGXCPU


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            '{"fifo_priority": 42}',
            ["real_time.fifo_priority = 42", "up to 0", "LimitRTPRIO=42", "CAP_SYS_NICE"],
        ),
        ('{"lock_memory": true}', ["real_time.lock_memory = true", "65536 bytes", "LimitMEMLOCK=infinity"]),
        ('{"cpus": [4095]}', ["real_time.cpus = [4095]", "may run on [0", "AllowedCPUs="]),
    ],
)
def test_what_is_refused_is_named_with_what_would_allow_it(settings, words):
    refusal = told(entered(settings=settings, before=unprivileged))["refusal"]
    assert [word for word in words if word not in refusal] == []


def test_a_refusal_ends_the_controller_before_it_touches_anything():
    settings = ControllerSettings(real_time=RealTimeSettings(cpus=(4095,)))
    untouched = object()
    with pytest.raises(RealTimeRefusedError, match="4095"):
        run(
            settings,
            RobotSettings(section_length_mm=(40.0, 40.0)),
            untouched,
            untouched,
            untouched,
            untouched,
        )
