"""The recorder: everything that the table of topics wants logged goes into an MCAP file, and so does what was lost.

Beside the publications each part of a recording holds the attached files and three metadata records, all with a checksum:
VERSIONS and PART (which part of which recording, why it was begun, how many of its first messages repeat older ones) at its
beginning and, at its end, SUMMARY with `messages/<topic>`, `lost/<topic>`, `refused`, `duration_s` and either `goes_on_in`,
the name of the next part, or `ended_because`. A recorder that was killed leaves no SUMMARY.
"""

import logging
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from messaging.session import Session
from recordings.answering import Desk
from recordings.backlog import Backlog, Heard
from recordings.deck import Deck
from recordings.errors import DiskFullError, RecordingError
from recordings.fault_watch import FaultWatch
from recordings.hearing import SWEEP, Hearing
from recordings.part import Summary
from recordings.settings import RecorderSettings

logger = logging.getLogger(__name__)

IDLE_S = 0.01
CLOSING_S = 0.5


def run(
    settings: RecorderSettings,
    path: Path | None,
    attachments: Mapping[str, bytes],
    session: Session,
    stop: threading.Event,
    healthy: Callable[[], None],
) -> Summary | None:
    """Record the bench, and do what is asked, until `stop` is set; then finish the file. Returns what was recorded last.

    Recording begins at once when the settings say so, or when a path is given; a recording that was cut off goes on in its
    next part. That it cannot begin raises RecordingInUseError, RecordingExistsError or UnwritableError; a disk without room,
    and whatever happens later, ends the recording but not the recorder.
    """
    now_ns = _steady_unix_clock()
    backlog = Backlog(settings.memory_bytes)
    deck = Deck(settings, attachments, backlog)
    hearing = Hearing(session, settings.ring_depth)
    desk = Desk(settings, deck, session)
    faults = FaultWatch()
    if path is not None or settings.begin == "at once":
        try:
            deck.start(path, now_ns(), "the recorder started")
        except DiskFullError as error:
            logger.warning("%s", error)
    while not stop.is_set():
        heard = hearing.take(now_ns(), deck.refuse)
        for one in heard:
            backlog.append(one)
            _save_when_a_fault_begins(settings, faults, deck, one)
        desk.answer(now_ns())
        more = deck.step(now_ns())
        healthy()
        if not more and len(heard) < SWEEP:
            # not stop.wait: a signal handler that sets an Event its own thread waits on can lock up
            time.sleep(IDLE_S)
    for _ in range(settings.ring_depth // SWEEP + 1):
        for one in hearing.take(now_ns(), deck.refuse):
            backlog.append(one)
    deck.stop("the recorder was told to end")
    while not deck.closed(CLOSING_S):
        healthy()
    return deck.last


def _save_when_a_fault_begins(
    settings: RecorderSettings, faults: FaultWatch, deck: Deck, heard: Heard
) -> None:
    reason = faults.begins(heard)
    if reason is None or not settings.rolling_s or deck.state == "recording":
        return
    try:
        deck.save(None, heard.log_time_ns, f"the controller's state became fault: {reason}", "fault")
    except RecordingError as error:
        logger.warning("the last seconds cannot be saved: %s", error)


def _steady_unix_clock() -> Callable[[], int]:
    """Unix time that a step of the host's clock cannot turn back, so that a recording stays in order."""
    offset_ns = time.time_ns() - time.monotonic_ns()
    return lambda: time.monotonic_ns() + offset_ns
