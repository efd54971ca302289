"""Errors that a user may read. The rooms add their own branches to this tree.

NodalError                  every error whose text is written for the user
|-- InvalidMessageError     a message whose fields do not fit its type
|-- CodecError              bytes that are not the message they claim to be
|-- EndpointError           a Zenoh endpoint that cannot be opened or reached
`-- UnansweredError         nobody answered a query in time
"""


class NodalError(Exception):
    """An error whose text names the thing, its value and what is allowed, ready to be shown to the user."""


class InvalidMessageError(NodalError):
    """A field of a message has the wrong shape, is not finite, or is out of range."""


class CodecError(NodalError):
    """Received bytes cannot be read as the message type of their topic."""


class EndpointError(NodalError):
    """A Zenoh endpoint is in use, malformed or out of reach."""


class UnansweredError(NodalError):
    """No process answered a query before its deadline."""
