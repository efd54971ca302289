"""docs/faults.md is made from the faults and the supervisor's table, and is up to date."""

from pathlib import Path

from nodal.fault_reference import reference

DOCUMENT = Path(__file__).parents[2] / "docs" / "faults.md"


def test_the_document_is_up_to_date():
    assert DOCUMENT.read_text() == reference(), "run: python -m nodal.fault_reference > docs/faults.md"
