"""What an operator is told of the loop's latency."""

from types import SimpleNamespace

from messaging.control import TendonCommand
from nodal.timeliness import KEPT, Timeliness, heard_within


class Session:
    """Hands out commands as a subscription would."""

    def __init__(self, ages_ns):
        self.waiting = [
            TendonCommand(
                time_ns=0,
                displacement_mm=[0.0],
                insertion_mm=0.0,
                shape_sequence=1,
                capture_to_command_ns=age_ns,
            ).to_bytes()
            for age_ns in ages_ns
        ]

    def every(self, topic, depth):
        assert topic.type is TendonCommand
        assert depth > KEPT

        return self

    def take(self):
        return SimpleNamespace(payload=self.waiting.pop(0)) if self.waiting else None


def test_only_commands_that_a_new_shape_led_to_count():
    session = Session([17_000_000, -1, -1, -1, 19_000_000, -1])
    timeliness = Timeliness(session)
    assert timeliness.words == ""

    timeliness.take()
    assert timeliness.words == "p50 18 ms, p99 19 ms from capture to command"


def test_what_was_long_ago_is_forgotten():
    timeliness = Timeliness(Session([90_000_000] * 50 + [10_000_000] * KEPT))

    timeliness.take()
    assert timeliness.words == "p50 10 ms, p99 10 ms from capture to command"


def test_nothing_is_said_where_nothing_is_commanded():
    assert heard_within(Session([]), 0.01) == ""
