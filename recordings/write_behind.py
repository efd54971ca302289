"""A disk may stall for seconds: a thread of its own writes and syncs the file, and whoever fills it never waits."""

import threading
from queue import SimpleQueue

from recordings.errors import UnwritableError
from recordings.output import Output

_SYNC, _END = object(), object()


class WriteBehind:
    """Hands blocks to an Output in another thread, in order. After a failure nothing more is written.

    What waits stands in memory: `waiting_bytes` says how much, and whoever writes shall keep it small. `write` and `sync`
    raise the UnwritableError that the other thread met.
    """

    def __init__(self, output: Output) -> None:
        self._output = output
        self._accepted = 0
        self._jobs: SimpleQueue[object] = SimpleQueue()
        self._syncing = False
        self._failure: UnwritableError | None = None
        self._thread = threading.Thread(target=self._work, name=output.path.name, daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> int:
        """Accept a block, which is written as a whole or not at all."""
        self.check()
        self._accepted += len(data)
        self._jobs.put(data)
        return len(data)

    def tell(self) -> int:
        """Bytes accepted so far."""
        return self._accepted

    def sync(self) -> None:
        """Ask for everything accepted so far to be kept by the device; does nothing while that is being done already."""
        self.check()
        if not self._syncing:
            self._syncing = True
            self._jobs.put(_SYNC)

    def end(self) -> None:
        """Close the file, once all that was accepted is kept."""
        self._jobs.put(_END)

    def wait(self, timeout_s: float | None = None) -> bool:
        """True once the file is closed."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def check(self) -> None:
        """Raise the UnwritableError that stopped the writing, if any."""
        if self._failure is not None:
            raise self._failure

    @property
    def written_bytes(self) -> int:
        """Bytes that the kernel has."""
        return self._output.tell()

    @property
    def waiting_bytes(self) -> int:
        """Bytes that wait in memory."""
        return self._accepted - self._output.tell()

    def _work(self) -> None:
        try:
            with self._output as output:
                while (job := self._jobs.get()) is not _END:
                    if isinstance(job, bytes):
                        output.write(job)
                    else:
                        self._syncing = False
                        output.sync()
                output.sync()
        except UnwritableError as error:
            self._failure = error
