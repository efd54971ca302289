"""What a metadata record says can be checked."""

from hypothesis import given
from hypothesis import strategies as st

from recordings.metadata import CHECKSUM, sealed, unbroken

facts = st.dictionaries(st.text(max_size=5), st.text(max_size=5), max_size=5)


@given(facts)
def test_what_is_sealed_is_unbroken(said):
    record = sealed(said)
    assert unbroken(record)
    assert {**record, CHECKSUM: ""} == {**said, CHECKSUM: ""}


@given(facts, st.text(max_size=5), st.text(max_size=5))
def test_a_changed_fact_is_noticed(said, key, value):
    record = sealed(said)
    changed = {**record, key: value}
    assert unbroken(changed) == (changed == record)


@given(st.dictionaries(st.text(max_size=5), st.text(max_size=5), min_size=2), st.data())
def test_facts_that_change_places_are_noticed(said, data):
    record = sealed(said)
    key = data.draw(st.sampled_from([name for name in said if name != CHECKSUM]))
    del record[key]
    assert not unbroken(record)


@given(facts)
def test_the_order_of_the_facts_does_not_matter(said):
    assert sealed(dict(reversed(said.items()))) == sealed(said)


def test_another_producers_metadata_is_taken_as_it_is():
    assert unbroken({"anything": "at all"})
