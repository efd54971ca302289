"""Started by the tests as a process of its own: the controller on real servos' packets and a real bus of messages.

Arguments: the Zenoh rendezvous and the servos' serial device.
"""

import json
import logging
import resource
import signal
import sys
import threading

from controller.process import run
from controller.settings import ControllerSettings, HomingSettings
from drivers.dynamixel.actuators import TendonActuators
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from messaging.session import open_session
from messaging.settings import RobotSettings, ZenohSettings


def axis(name, servo, mm_per_rad, low_mm, high_mm):
    """One servo of the bench."""
    return AxisSettings(
        name=name, id=servo, mm_per_rad=mm_per_rad, min_mm=low_mm, max_mm=high_mm, max_current_ma=1500.0
    )


def main(rendezvous, port):
    """Run until SIGTERM, then say on stdout what it cost."""
    logging.basicConfig(level=logging.INFO, stream=sys.stderr)
    servos = ServoSettings(
        port=port,
        tendons=tuple(axis(f"pair {n}", 10 + n, 8.0, -7.0, 7.0) for n in range(1, 5)),
        stage=axis("stage", 30, 5.0, -1.0, 42.0),
        watchdog_ms=200,
    )
    stop, healthy = threading.Event(), 0

    def count():
        nonlocal healthy
        healthy += 1

    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    with open_session(ZenohSettings(rendezvous=rendezvous), "test", "controller") as session:
        run(
            ControllerSettings(homing=HomingSettings(find_slack=False)),
            RobotSettings(section_length_mm=(40.0, 40.0)),
            TendonActuators(servos),
            session,
            stop,
            count,
        )
    used = resource.getrusage(resource.RUSAGE_SELF)
    print(json.dumps({"healthy": healthy, "cpu_s": used.ru_utime + used.ru_stime}))


if __name__ == "__main__":
    main(*sys.argv[1:])
