"""The message reference says what the table of topics says."""

from pathlib import Path

from nodal.message_reference import reference

DOCUMENT = Path(__file__).parents[2] / "docs" / "messages.md"


def test_the_document_is_in_step_with_the_table():
    assert DOCUMENT.read_text(encoding="utf-8") == reference(), "make docs"
