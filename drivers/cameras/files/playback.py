"""Cameras that are files, kept in step with one another."""

import logging
import time
from collections import deque
from collections.abc import Iterator, Mapping

from drivers.cameras.camera import CameraFrame
from drivers.cameras.errors import CameraError
from drivers.cameras.files.picture import FilePicture

logger = logging.getLogger(__name__)

WAITING_AT_MOST = 2
"""As of a device, only the newest frames wait to be read: a reader that is late misses the others."""


class Playback:
    """Plays the pictures of every camera in `tracks`, which begins with the earliest of them now.

    With `paced`, a picture can be read when its time has come, as though its camera were there; without, as soon as no other
    camera has an earlier one, so that none runs ahead and all are read.
    """

    def __init__(self, tracks: Mapping[str, Iterator[FilePicture]], *, paced: bool) -> None:
        self.cameras = [FileCamera(name, track, self) for name, track in tracks.items()]
        self.paced = paced
        self._started_ns = time.monotonic_ns()
        self._zero_ns = self._earliest_ns() or 0

    def capture_monotonic_ns(self, picture: FilePicture) -> int:
        """When it is taken, on this playback's clock."""
        return self._started_ns + picture.offset_ns - self._zero_ns

    def is_due(self, picture: FilePicture) -> bool:
        """True when its time has come."""
        if self.paced:
            return self.capture_monotonic_ns(picture) <= time.monotonic_ns()
        earliest_ns = self._earliest_ns()
        return earliest_ns is None or picture.offset_ns <= earliest_ns

    def _earliest_ns(self) -> int | None:
        offsets_ns = (camera.next.offset_ns for camera in self.cameras if camera.next is not None)
        return min(offsets_ns, default=None)


class FileCamera:
    """One camera of a playback. A picture that cannot be read is logged and left out."""

    def __init__(self, name: str, track: Iterator[FilePicture], playback: Playback) -> None:
        self._name = name
        self._track = track
        self._playback = playback
        self._waiting: deque[FilePicture] = deque(maxlen=WAITING_AT_MOST)
        self.next = next(track, None)
        """The picture whose time comes next."""

    @property
    def name(self) -> str:
        """Its name on the bench."""
        return self._name

    @property
    def ended(self) -> bool:
        """True once its last picture was read."""
        return self.next is None and not self._waiting

    def read(self) -> CameraFrame | None:
        """The next frame that was not read yet and whose time has come, or None."""
        while self.next is not None and self._playback.is_due(self.next):
            self._waiting.append(self.next)
            self.next = next(self._track, None)
            if not self._playback.paced:
                break
        if not self._waiting:
            return None
        picture = self._waiting.popleft()
        try:
            jpeg = picture.jpeg()
        except CameraError as error:
            logger.warning("camera %s: %s", self._name, error)
            return None
        return CameraFrame(
            name=self._name,
            jpeg=jpeg,
            capture_monotonic_ns=self._playback.capture_monotonic_ns(picture),
            number=picture.number,
        )

    def close(self) -> None:
        """Let the file go."""
        self.next = None
        self._waiting.clear()
        self._track = iter(())
