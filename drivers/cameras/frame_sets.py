"""Frame sets as they come, for whoever does nothing else meanwhile; sensing has a loop of its own."""

import time
from collections.abc import Iterator, Sequence

from drivers.cameras.camera import Camera
from drivers.cameras.pairing import FrameSet, FrameSetPairing
from drivers.cameras.pairing_report import PairingReport
from drivers.cameras.silence import SilenceWatch

POLL_S = 0.002


def frame_sets(
    cameras: Sequence[Camera], maximum_skew_s: float, silence_s: float
) -> Iterator[FrameSet | None]:
    """Every set, oldest first, and None each time there is nothing to read yet; ends when every camera has ended.

    Raises CameraSilentError naming the cameras that gave nothing for `silence_s`.
    """
    names = [camera.name for camera in cameras]
    pairing = FrameSetPairing(names, maximum_skew_s)
    report = PairingReport(pairing, time.monotonic())
    silence = SilenceWatch(names, silence_s, time.monotonic())
    while True:
        frames = [frame for camera in cameras if (frame := camera.read()) is not None]
        for frame in frames:
            silence.heard(frame.name, time.monotonic())
            if (complete := pairing.feed(frame)) is not None:
                report.add(complete)
                yield complete
        report.tell(time.monotonic())
        if frames:
            continue
        if all(camera.ended for camera in cameras):
            return
        for camera in cameras:
            if camera.ended:
                silence.heard(camera.name, time.monotonic())
        silence.check(time.monotonic())
        yield None
        time.sleep(POLL_S)
