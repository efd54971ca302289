"""Which topics a live replay says, and who may not be alive meanwhile."""

import dataclasses
from collections.abc import Iterable, Mapping

from messaging import topics
from messaging.topics import TOPICS, Topic
from nodal.errors import CommandError
from recordings.reader import topic_of

PROCESS_OF = {"sensing": "sensing", "controller": "controller", "simulated bench": "simulation"}
"""The process behind who says a topic; what all say is nobody's own."""
DEFAULT = ("sensing", "simulation")
"""Everything that a new controller hears, and what a viewer shows beside it."""
ALL = "all"


def chosen(words: Iterable[str]) -> tuple[Topic, ...]:
    """The topics that these words name: a key, a process, or all; raises CommandError."""
    return tuple(topic for word in words for topic in _named(word))


def speakers(of_topics: Iterable[Topic]) -> Mapping[str, list[str]]:
    """The processes that say these topics when they are alive, each with the keys that are its own."""
    found: dict[str, list[str]] = {}
    for topic in of_topics:
        if process := PROCESS_OF.get(topic.said_by):
            found.setdefault(process, []).append(topic.key)
    return found


def moves_a_robot(topic: Topic) -> bool:
    """Whether a controller acts on this topic."""
    return topic.key == topics.SHAPE.key


def _named(word: str) -> tuple[Topic, ...]:
    logged = tuple(topic for topic in TOPICS if topic.logged)
    if word == ALL:
        return logged
    if said := tuple(topic for topic in logged if PROCESS_OF.get(topic.said_by) == word):
        return said
    topic = topic_of(word)
    if topic not in logged:
        raise CommandError(
            f"--topics {word!r}: neither a key that is recorded ({', '.join(topic.key for topic in logged)}) "
            f"nor one of {', '.join(PROCESS_OF.values())}, {ALL}"
        )
    return (dataclasses.replace(topic, key=word),)
