"""A camera on V4L2 that outlives its cable: a thread of its own reads it, and opens it again when it was lost."""

import logging
import threading
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path

from drivers.cameras.camera import CameraFrame
from drivers.cameras.errors import CameraDeviceError, CameraLostError
from drivers.cameras.v4l2.controls import in_settings
from drivers.cameras.v4l2.device_files import lasting_names
from drivers.cameras.v4l2.inspection import FaultReport, Inspection, PictureFault
from drivers.cameras.v4l2.settings import V4l2CameraSettings
from drivers.cameras.v4l2.stream import Stream

logger = logging.getLogger(__name__)

WAITING_AT_MOST = 2
POLL_S = 0.1
RETRY_S = 0.5
START_S = 5.0
"""Cameras take their time for the first picture."""
STILL_S = 2.0
STILL_PICTURES = 10
"""A stream that has given nothing new for as long as so many pictures take, and at least STILL_S, is started anew."""


class V4l2Camera:
    """Frames of one camera, the newest few. `faults` counts the pictures that were not handed on."""

    def __init__(self, name: str, settings: V4l2CameraSettings) -> None:
        """Raises CameraDeviceError naming the camera, if it is not there or does not do what is asked."""
        self._name = name
        self._settings = settings
        self._inspection = Inspection()
        self._report = FaultReport(self._inspection.faults)
        self._frames: deque[CameraFrame] = deque(maxlen=WAITING_AT_MOST)
        self._stop = threading.Event()
        self._told = ""
        try:
            stream = Stream(settings)
        except CameraDeviceError as error:
            raise type(error)(f"camera {name}: {error}") from error
        self._held = stream.held
        self._tell_of(stream)
        if not Path(settings.device).is_symlink() and (lasting := lasting_names(Path(settings.device))):
            logger.warning(
                "camera %s: %s may be another camera after a restart; %s stays",
                name,
                settings.device,
                lasting[0],
            )
        self._thread = threading.Thread(target=self._run, args=(stream,), name=f"camera {name}", daemon=True)
        self._thread.start()

    @property
    def name(self) -> str:
        """Its name on the bench."""
        return self._name

    @property
    def ended(self) -> bool:
        """Never: a camera that is lost is waited for."""
        return False

    @property
    def faults(self) -> Mapping[PictureFault, int]:
        """How many pictures were not handed on since the start, and why."""
        return self._inspection.faults

    def read(self) -> CameraFrame | None:
        """The next frame that was not read yet, or None; returns at once."""
        return self._frames.popleft() if self._frames else None

    def close(self) -> None:
        """Let the device go."""
        self._stop.set()
        self._thread.join()

    def _run(self, stream: Stream | None) -> None:
        while stream is not None:
            try:
                self._hand_on(stream)
            except CameraDeviceError as error:
                self._complain(f"{error}; it is started anew as soon as it can be")
            finally:
                stream.close()
            stream = self._stream_anew()

    def _stream_anew(self) -> Stream | None:
        """The camera, as soon as it is there again and does what is asked; None when it is no longer wanted."""
        while not self._stop.wait(RETRY_S):
            try:
                return Stream(self._settings, self._held)
            except CameraDeviceError as error:
                self._complain(str(error))
        return None

    def _hand_on(self, stream: Stream) -> None:
        """Every good picture, until the camera is no longer wanted; raises CameraDeviceError when it is lost."""
        self._inspection.begin()
        patience_s, good_s = START_S, time.monotonic()
        while not self._stop.is_set():
            captured = stream.read(POLL_S)
            number = None if captured is None else self._inspection.number_of(captured)
            now_s = time.monotonic()
            if captured is not None and number is not None:
                self._frames.append(
                    CameraFrame(
                        name=self._name,
                        jpeg=captured.jpeg,
                        capture_monotonic_ns=captured.capture_monotonic_ns,
                        number=number,
                    )
                )
                patience_s, good_s = max(STILL_S, STILL_PICTURES / self._settings.rate_hz), now_s
                if self._told:
                    self._told = ""
                    self._tell_of(stream)
            elif now_s - good_s > patience_s:
                only = ", ".join(sorted(self._inspection.since_good))
                raise CameraLostError(
                    f"no good picture for {patience_s:g} s{f', only such as were {only}' if only else ''}"
                )
            if (text := self._report.due(now_s)) is not None:
                logger.warning("camera %s: %s", self._name, text)

    def _complain(self, problem: str) -> None:
        """Once for each problem, until pictures come again."""
        if problem != self._told:
            logger.warning("camera %s: %s", self._name, problem)
            self._told = problem

    def _tell_of(self, stream: Stream) -> None:
        held = ", ".join(f"{key} {value:g}" for key, value in in_settings(stream.held).items())
        logger.info(
            "camera %s: %s, locked at %s", self._name, stream.card, held or "nothing, as it has no controls"
        )
