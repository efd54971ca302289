"""What `nodal` exits with, beside 0 for what was done."""

ERROR = 2
REFUSED = 3
"""It was understood, and the answer is no: a refusal, or something that is not as it should be."""
INTERRUPTED = 130
