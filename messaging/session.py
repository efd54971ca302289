"""The Zenoh session of one process: publishers, subscribers, services and liveness that follow the table of topics.

Processes find one another through a router-mode session (the rendezvous) and then talk directly; multicast scouting is
off. Sessions may be opened in any order: links are retried in the background for ever, every second. Nothing here
blocks a loop: publications that cannot leave at once are dropped, and the gap in their sequence numbers counts them.
"""

import json
import os
import struct
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

import zenoh

from messaging.errors import CodecError, EndpointError, UnansweredError
from messaging.message import Message
from messaging.settings import ZenohSettings
from messaging.topics import Service, Signal, Topic

M = TypeVar("M", bound=Message)

ENVELOPE = struct.Struct("<QQI")
"""Rides beside every publication: sequence number, Unix publish time in ns, and a number drawn at each start of a publisher."""

RETRY_MS = {"period_init_ms": 250, "period_max_ms": 1000, "period_increase_factor": 2}


@dataclass(frozen=True, kw_only=True)
class Received:
    """A publication as it arrived. `sequence` counts within one `epoch`, the life of its publisher."""

    key: str
    payload: bytes
    sequence: int
    publish_time_ns: int
    epoch: int


class Publisher(Generic[M]):
    """Says one topic. Messages are numbered from 0 unless the caller numbers them."""

    def __init__(self, session: zenoh.Session, topic: Topic) -> None:
        self._publisher = session.declare_publisher(
            topic.key,
            congestion_control=zenoh.CongestionControl.DROP,
            reliability=zenoh.Reliability.RELIABLE,
        )
        self._epoch = int.from_bytes(os.urandom(4), "little")
        self._next = 0

    def put(self, message: M, sequence: int | None = None) -> int:
        """Send it; never waits for a receiver. Returns its number."""
        return self.put_bytes(message.to_bytes(), sequence)

    def put_bytes(self, payload: bytes, sequence: int | None = None) -> int:
        """Send a message that is bytes already, as those out of a recording are. Returns its number."""
        number = self._next if sequence is None else sequence
        self._next = number + 1
        self._publisher.put(payload, attachment=ENVELOPE.pack(number, time.time_ns(), self._epoch))
        return number


class Subscription:
    """Hears a topic (or a pattern of keys) into a ring that keeps the newest `depth` publications."""

    def __init__(self, session: zenoh.Session, key: str, depth: int) -> None:
        self._subscriber = session.declare_subscriber(key, zenoh.handlers.RingChannel(depth))

    def take(self) -> Received | None:
        """The oldest publication in the ring, or None; never waits."""
        sample = self._subscriber.handler.try_recv()
        return None if sample is None else _received(sample)


class SignalSender:
    """Gives one signal."""

    def __init__(self, session: zenoh.Session, signal: Signal) -> None:
        self._publisher = session.declare_publisher(
            signal.key,
            congestion_control=zenoh.CongestionControl.DROP,
            reliability=zenoh.Reliability.RELIABLE,
            express=True,
        )

    def give(self) -> None:
        """Once; never waits for a receiver."""
        self._publisher.put(b"")


class SignalReceiver:
    """Hears one signal, from whoever gives it."""

    def __init__(self, session: zenoh.Session, signal: Signal) -> None:
        self._subscriber = session.declare_subscriber(signal.key, zenoh.handlers.RingChannel(1))

    def heard(self) -> bool:
        """True when it was given since the last time this was asked; never waits."""
        return self._subscriber.handler.try_recv() is not None


class Query:
    """A question that waits for its answer."""

    def __init__(self, query: zenoh.Query, service: Service) -> None:
        self._query = query
        self._service = service

    @property
    def service(self) -> Service:
        """What is asked."""
        return self._service

    @property
    def payload(self) -> bytes:
        """The request as it came."""
        payload = self._query.payload
        return b"" if payload is None else payload.to_bytes()

    def request(self) -> Message:
        """What was asked; raises CodecError or InvalidMessageError when it is not a request of this service."""
        return self._service.request.from_bytes(self.payload)

    def reply(self, answer: Message) -> None:
        """Answer, once."""
        self._query.reply(self._query.key_expr, answer.to_bytes())
        self._query.drop()  # type: ignore[no-untyped-call]


class Answers:
    """The answering end of a service, polled by the loop that owns it."""

    def __init__(self, session: zenoh.Session, service: Service) -> None:
        self._service = service
        self._queryable = session.declare_queryable(service.key, zenoh.handlers.RingChannel(16))

    def take(self) -> Query | None:
        """The next question, or None; never waits."""
        query = self._queryable.handler.try_recv()
        return None if query is None else Query(query, self._service)


class Presence:
    """Which processes are alive, as far as word of it has come; for a loop that cannot wait for `Session.alive`."""

    def __init__(self, session: zenoh.Session) -> None:
        self._alive: set[str] = set()
        self._subscriber = session.liveliness().declare_subscriber(
            "health/*", zenoh.handlers.FifoChannel(256), history=True
        )

    def alive(self) -> frozenset[str]:
        """Their names; never waits."""
        while (sample := self._subscriber.handler.try_recv()) is not None:
            name = _process(sample.key_expr)
            if sample.kind == zenoh.SampleKind.PUT:
                self._alive.add(name)
            else:
                self._alive.discard(name)
        return frozenset(self._alive)


class Session:
    """One process on the bench's bus. Make it with `open_session`."""

    def __init__(self, session: zenoh.Session, process: str) -> None:
        self._session = session
        self._token = session.liveliness().declare_token(f"health/{process}")

    def publisher(self, topic: Topic) -> Publisher[Message]:
        """A publisher of this topic."""
        return Publisher(self._session, topic)

    def newest(self, topic: Topic) -> "Newest":
        """The newest message of this topic, and nothing older."""
        return Newest(Subscription(self._session, topic.key, 1), topic)

    def every(self, topic: Topic, depth: int) -> Subscription:
        """Every publication of this topic, undecoded, as long as no more than `depth` wait to be taken."""
        return Subscription(self._session, topic.key, depth)

    def gives(self, signal: Signal) -> SignalSender:
        """The giving end of this signal."""
        return SignalSender(self._session, signal)

    def hears(self, signal: Signal) -> SignalReceiver:
        """The hearing end of this signal."""
        return SignalReceiver(self._session, signal)

    def answers(self, service: Service) -> Answers:
        """The answering end of this service."""
        return Answers(self._session, service)

    def ask(self, service: Service, request: Message, timeout_s: float) -> Message:
        """Ask and wait for the answer; raises UnansweredError when nobody answers in time."""
        deadline = time.monotonic() + timeout_s
        while (remaining_s := deadline - time.monotonic()) > 0:
            # without a queryable in sight `get` returns at once, so a process that is just starting is asked again
            for reply in self._session.get(
                service.key, payload=request.to_bytes(), timeout=max(remaining_s, 0.05)
            ):
                if reply.ok is not None:
                    return service.reply.from_bytes(reply.ok.payload.to_bytes())
            time.sleep(0.05)
        raise UnansweredError(
            f"nobody answered {service.key} within {timeout_s:g} s; is the {service.answered_by} running on this bench?"
        )

    def alive(self) -> frozenset[str]:
        """Names of the processes that are alive on this bench."""
        replies = self._session.liveliness().get("health/*", timeout=1.0)
        return frozenset(_process(reply.ok.key_expr) for reply in replies if reply.ok is not None)

    def presence(self) -> Presence:
        """The same, kept up to date from now on."""
        return Presence(self._session)


class Newest:
    """The newest message of a topic."""

    def __init__(self, subscription: Subscription, topic: Topic) -> None:
        self._subscription = subscription
        self._type = topic.type

    def take(self) -> tuple[Message, Received] | None:
        """The newest message that was not taken yet, with its envelope, or None; raises CodecError on a bad payload."""
        received = self._subscription.take()
        return None if received is None else (self._type.from_bytes(received.payload), received)


@contextmanager
def open_session(settings: ZenohSettings, bench: str, process: str) -> Iterator[Session]:
    """A peer on the bench's bus, which need not have a rendezvous yet; raises EndpointError."""
    config = {
        "mode": "peer",
        "connect": {
            "endpoints": [settings.rendezvous],
            "timeout_ms": -1,
            "exit_on_failure": False,
            "retry": RETRY_MS,
        },
        "listen": {"endpoints": [settings.listen], "exit_on_failure": True},
    }
    with _opened(config, settings.listen, bench) as zenoh_session:
        # held here, because a process stays alive to others only as long as its token does
        session = Session(zenoh_session, process)
        yield session


@contextmanager
def open_rendezvous(settings: ZenohSettings, bench: str) -> Iterator[Session]:
    """The router through which a bench's processes find one another; raises EndpointError when its endpoint is in use."""
    config = {"mode": "router", "listen": {"endpoints": [settings.rendezvous], "exit_on_failure": True}}
    with _opened(config, settings.rendezvous, bench) as zenoh_session:
        session = Session(zenoh_session, "rendezvous")
        yield session


@contextmanager
def _opened(config: Mapping[str, object], endpoint: str, bench: str) -> Iterator[zenoh.Session]:
    common = {
        "namespace": f"nodal/{bench}",
        "scouting": {"delay": 100, "multicast": {"enabled": False}, "gossip": {"enabled": True}},
        "transport": {
            # a pair of frames is 10 batches: with the 2 of the default, what is said right behind them is dropped
            "link": {"tx": {"queue": {"size": {"data": 16}}}},
            # implicit shared memory stalls its first put by 100 ms and leaves segments behind after kill -9
            "shared_memory": {"enabled": False},
        },
    }
    try:
        session = zenoh.open(zenoh.Config.from_json5(json.dumps({**config, **common})))
    except zenoh.ZError as error:
        raise EndpointError(f"Zenoh endpoint {endpoint} cannot be opened: {_reason(error)}") from error
    with session:
        yield session


def _reason(error: Exception) -> str:
    text = str(error)
    return "the address is already in use" if "in use" in text else text.splitlines()[0]


def _process(token: zenoh.KeyExpr) -> str:
    return str(token).rpartition("/")[2]


def _received(sample: zenoh.Sample) -> Received:
    if sample.attachment is None:
        raise CodecError(
            f"a publication on {sample.key_expr} has no envelope; its publisher is not part of nodal"
        )
    try:
        sequence, publish_time_ns, epoch = ENVELOPE.unpack(sample.attachment.to_bytes())
    except struct.error as error:
        raise CodecError(f"the envelope of a publication on {sample.key_expr} is damaged: {error}") from error
    return Received(
        key=str(sample.key_expr),
        payload=sample.payload.to_bytes(),
        sequence=sequence,
        publish_time_ns=publish_time_ns,
        epoch=epoch,
    )
