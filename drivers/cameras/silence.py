"""Which cameras have fallen silent. Pure: the time is handed in."""

from collections.abc import Iterable

from drivers.cameras.errors import CameraSilentError, UnknownCameraError


class SilenceWatch:
    """Remembers when each camera was heard last."""

    def __init__(self, names: Iterable[str], maximum_silence_s: float, now_s: float) -> None:
        """From `now_s` on, every camera may be silent for so long."""
        self._maximum_silence_s = maximum_silence_s
        self._heard_s = dict.fromkeys(names, now_s)

    def heard(self, name: str, now_s: float) -> None:
        """A frame of this camera has come; raises UnknownCameraError."""
        if name not in self._heard_s:
            raise UnknownCameraError(f"camera {name} is not one of {', '.join(self._heard_s)}")
        self._heard_s[name] = now_s

    def check(self, now_s: float) -> None:
        """Raises CameraSilentError naming every camera that has been silent for too long."""
        silent = {
            name: now_s - heard_s
            for name, heard_s in self._heard_s.items()
            if now_s - heard_s > self._maximum_silence_s
        }
        if silent:
            spans = ", ".join(f"{name} for {silence_s:.2f} s" for name, silence_s in silent.items())
            raise CameraSilentError(
                f"no frame from camera {spans}; allowed are {self._maximum_silence_s:g} s"
            )
