"""One question from the command line to a process of the bench."""

import sys

from messaging.control import Reply
from messaging.message import Message
from messaging.session import open_session
from messaging.topics import Service
from nodal.bench_file import load_bench

REFUSED = 3


def ask(config: str, service: Service, request: Message, timeout_s: float) -> int:
    """Ask, say the answer, and return the exit status: 0 accepted, 3 refused. Raises UnansweredError."""
    settings = load_bench(config).settings
    with open_session(settings.zenoh, settings.name, "operator") as session:
        reply = session.ask(service, request, timeout_s)
    if not isinstance(reply, Reply):
        raise TypeError(f"{service.key} answers with {type(reply).__name__}, not with a Reply")
    if not reply.accepted:
        print(f"nodal: refused: {reply.reason} (state: {reply.state})", file=sys.stderr)
        return REFUSED
    print(f"{reply.state}: {reply.reason}" if reply.reason else reply.state)
    return 0
