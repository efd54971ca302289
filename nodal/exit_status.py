"""What `nodal` exits with, beside 0 for what was done."""

import sys

ERROR = 2
REFUSED = 3
"""It was understood, and the answer is no: a refusal, or something that is not as it should be."""
INTERRUPTED = 130


def refused(reason: object, advice: str = "") -> int:
    """Say why the answer is no, and what to do about it; returns the exit status."""
    print(f"nodal: refused: {reason}", file=sys.stderr)
    if advice:
        print(f"what to do: {advice}", file=sys.stderr)
    return REFUSED
