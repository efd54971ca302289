"""The edge to the kernel's real time: first in line, no waiting for memory, cores of its own.

Everything here concerns the thread that calls, or what it owns; other threads of the process (Zenoh's) stay as they are,
and threads that are started later begin as ordinary ones (SCHED_RESET_ON_FORK, sched(7)).
"""

import ctypes
import os
import resource
from pathlib import Path

from controller.errors import RealTimeRefusedError
from controller.settings import RealTimeSettings

_MCL_CURRENT, _MCL_FUTURE = 1, 2
"""mlockall(2)."""
_CAP_IPC_LOCK = 14
"""capabilities(7)."""
_UNBROKEN_US = 500_000
"""So long may a FIFO thread compute without a pause, unless a limit is set already: a loop that has run wild is ended by
SIGXCPU (setrlimit(2), RLIMIT_RTTIME) rather than keep its core from everything else, and the servos' watchdog stops the robot."""


def enter(settings: RealTimeSettings) -> None:
    """Make the calling thread what the settings ask for; raises RealTimeRefusedError naming what would have allowed it."""
    if settings.cpus:
        _choose_cpus(settings.cpus)
    if settings.lock_memory:
        _lock_memory()
    if settings.fifo_priority:
        _be_first(settings.fifo_priority)


def _choose_cpus(cpus: tuple[int, ...]) -> None:
    before = os.sched_getaffinity(0)
    if not before.issuperset(cpus):
        raise RealTimeRefusedError(
            f"controller.real_time.cpus = {list(cpus)}: this process may run on {sorted(before)}; "
            "systemd's AllowedCPUs= and CPUAffinity= say which cores a service has"
        )
    os.sched_setaffinity(0, cpus)


def _lock_memory() -> None:
    """Without a limit, or not at all: where a limit is met later, an allocation fails and the process dies of it."""
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if limit != resource.RLIM_INFINITY and not _is_capable_of(_CAP_IPC_LOCK):
        raise RealTimeRefusedError(
            f"controller.real_time.lock_memory = true: this process may lock no more than {limit} bytes (RLIMIT_MEMLOCK); "
            "it must be unlimited: LimitMEMLOCK=infinity in the systemd unit, memlock in limits.conf(5), or CAP_IPC_LOCK"
        )
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) != 0:
        raise RealTimeRefusedError(
            f"controller.real_time.lock_memory = true: mlockall refused ({os.strerror(ctypes.get_errno())}); the process must "
            "be let (systemd: SystemCallFilter=@memlock), and all that it has mapped must fit into RAM"
        )


def _is_capable_of(capability: int) -> bool:
    """Whether this is among the thread's effective capabilities (proc(5), status, CapEff)."""
    status = Path("/proc/thread-self/status").read_text(encoding="ascii", errors="replace")
    effective = next(line for line in status.splitlines() if line.startswith("CapEff:")).split()[1]
    return bool(int(effective, 16) >> capability & 1)


def _be_first(priority: int) -> None:
    before_us, most_us = resource.getrlimit(resource.RLIMIT_RTTIME)
    if before_us == resource.RLIM_INFINITY:
        resource.setrlimit(resource.RLIMIT_RTTIME, (_UNBROKEN_US, most_us))
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except OSError as error:
        allowed = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
        raise RealTimeRefusedError(
            f"controller.real_time.fifo_priority = {priority}: the kernel refused ({error.strerror}); "
            f"this process may ask for up to {allowed} (RLIMIT_RTPRIO). LimitRTPRIO={priority} and RestrictRealtime=no in the "
            "systemd unit allow it, or rtprio in limits.conf(5), or CAP_SYS_NICE"
        ) from error
