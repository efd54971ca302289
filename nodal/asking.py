"""One question from the command line to a process of the bench."""

from collections.abc import Callable

from messaging.control import Reply
from messaging.message import Message
from messaging.session import Session, open_session
from messaging.topics import Service
from nodal.bench_file import read_bench
from nodal.exit_status import refused


def ask(
    config: str,
    service: Service,
    request: Message,
    timeout_s: float,
    and_tell: Callable[[Session, Reply], str] = lambda *_: "",
) -> int:
    """Ask, say the answer, and return the exit status: 0 accepted, 3 refused. Raises UnansweredError.

    `and_tell` may find out more that is to be said on a line of its own.
    """
    settings = read_bench(config).settings
    with open_session(settings.zenoh, settings.name, "operator") as session:
        reply = answer(session, service, request, timeout_s)
        more = and_tell(session, reply)
    return tell(reply, more)


def answer(session: Session, service: Service, request: Message, timeout_s: float) -> Reply:
    """What comes back; raises UnansweredError."""
    reply = session.ask(service, request, timeout_s)
    if not isinstance(reply, Reply):
        raise TypeError(f"{service.key} answers with {type(reply).__name__}, not with a Reply")
    return reply


def tell(reply: Reply, more: str = "") -> int:
    """Say an answer, and what else was found out, and return the exit status."""
    if not reply.accepted:
        return refused(f"{reply.reason} (state: {reply.state})", reply.advice)
    print(f"{reply.state}: {reply.reason}" if reply.reason else reply.state)
    if reply.advice:
        print(f"what to do: {reply.advice}")
    if more:
        print(more)
    return 0
