"""Which topics a user means by their keys. Pure."""

import dataclasses
from collections.abc import Sequence

from messaging.topics import TOPICS, Topic
from messaging.views import View
from nodal.errors import CommandError
from nodal.exports.tables import TABULAR
from recordings.reader import topic_of


def chosen(keys: Sequence[str]) -> list[Topic]:
    """The topics of these keys, all that tables are made of when there is none; raises CommandError.

    A key is one of the table of topics, or a camera's own: `camera/*`, `camera/left`.
    """
    return [_chosen(key) for key in keys] if keys else list(TABULAR)


def _chosen(key: str) -> Topic:
    known = next((topic for topic in TOPICS if topic.key == key), None) or topic_of(key)
    tabular = ", ".join(topic.key for topic in TABULAR)
    if known is None:
        raise CommandError(f"--topics {key}: there is no such topic; tables are made of {tabular}")
    if known not in TABULAR:
        what = "is drawn by viewers" if issubclass(known.type, View) else "is not recorded"
        raise CommandError(f"--topics {key}: it {what}; tables are made of {tabular}")
    return dataclasses.replace(known, key=key)
