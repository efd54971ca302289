"""The recorder's answering end: requests in, replies out, and every answered request on the bus."""

import time
from pathlib import Path

from messaging.control import Reply
from messaging.errors import NodalError
from messaging.history import Asked
from messaging.recorder import RecorderAction, RecorderRequest
from messaging.session import Query, Session
from messaging.topics import ASKED, RECORDER_DO
from recordings.deck import Deck
from recordings.settings import RecorderSettings

REQUEST = "it was asked for"
CLOSING_S = 1.0
"""An answer waits so long for the disk to have all of a recording that was stopped."""


class Desk:
    """Takes questions to a deck and answers them."""

    def __init__(self, settings: RecorderSettings, deck: Deck, session: Session) -> None:
        self._settings = settings
        self._deck = deck
        self._questions = session.answers(RECORDER_DO)
        self._asked = session.publisher(ASKED)

    def answer(self, now_ns: int) -> None:
        """Answer what waits; never waits for a question."""
        while (question := self._questions.take()) is not None:
            refusal = self._refusal(question, now_ns)
            reply = Reply(
                accepted=not refusal, state=self._deck.state, reason=refusal or self._deck.describe()
            )
            self._asked.put(Asked.of(RECORDER_DO.key, question.payload, reply, time.time_ns()))
            question.reply(reply)

    def _refusal(self, question: Query, now_ns: int) -> str:
        """Do what is asked; why not, or nothing."""
        try:
            request = question.request()
            return self._do(request, now_ns) if isinstance(request, RecorderRequest) else "no such request"
        except NodalError as error:
            return str(error)

    def _do(self, request: RecorderRequest, now_ns: int) -> str:
        deck = self._deck
        path = Path(self._settings.folder, request.file) if request.file else None
        match request.action:
            case RecorderAction.START:
                if deck.state == "recording":
                    return f"a recording is going on: {deck.describe()}"
                deck.start(path, now_ns, REQUEST)
            case RecorderAction.STOP:
                if deck.state == "waiting":
                    return "nothing is being recorded"
                deck.stop(REQUEST)
                deck.closed(CLOSING_S)
            case RecorderAction.SAVE:
                if deck.state == "recording":
                    return f"everything is being recorded already: {deck.describe()}"
                if not self._settings.rolling_s:
                    return "recorder.rolling_s = 0, so nothing is kept that could be saved"
                deck.save(path, now_ns, REQUEST, "saved")
        return ""
