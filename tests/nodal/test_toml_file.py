"""Settings out of TOML: complaints name the file, the key, its value and what is allowed."""

from typing import Annotated

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodal.errors import BenchFileError
from nodal.toml_file import read_table, settings_from, written


class Servo(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    id: Annotated[int, msgspec.Meta(ge=0, le=252)]
    gain: Annotated[float, msgspec.Meta(gt=0)] = 1.0

    def __post_init__(self):
        if self.id == 13:
            raise ValueError("id 13 brings bad luck")


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    name: str
    servos: tuple[Servo, ...] = ()
    axes: dict[str, Servo] = {}
    spare: Servo | None = None


def settings(tmp_path, text):
    file = tmp_path / "bench.toml"
    file.write_text(text, encoding="utf-8")
    return settings_from(read_table(file), Settings, str(file))


def test_settings_are_read(tmp_path):
    read = settings(tmp_path, 'name = "a"\nservos = [{ id = 1 }]\n[axes.x]\nid = 2\ngain = 3\n')

    assert read == Settings(name="a", servos=(Servo(id=1),), axes={"x": Servo(id=2, gain=3.0)})


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "name is missing; the file takes name, servos, axes, spare"),
        ('name = "a"\nnmae = 1', "nmae is unknown; the file takes name, servos, axes, spare"),
        ("name = 3", "name = 3: expected `str`, got `int`"),
        ('name = "a"\nservos = [{ id = 1 }, { id = 253 }]', "servos[1].id = 253: expected `int` <= 252"),
        ('name = "a"\n[axes.x]\nid = 1\n[axes.y]\nid = 1.5', "axes.y.id = 1.5: expected `int`, got `float`"),
        ('name = "a"\n[axes.x]\nid = 1\n[axes.y]\ngain = 1', "axes.y.id is missing; [axes.y] takes id, gain"),
        ('name = "a"\n[axes.y]\nid = 1\nmass = 1', "axes.y.mass is unknown; [axes.y] takes id, gain"),
        ('name = "a"\n[spare]\nid = 1\nmass = 1', "spare.mass is unknown; [spare] takes id, gain"),
        ('name = "a"\n[spare]\nid = 13', "spare: id 13 brings bad luck"),
        ('name = "a"\n[spare]\nid = 1\ngain = nan', "spare.gain = nan: it must be a finite number"),
        ('name = "a"\n[spare]\nid = 1\ngain = inf', "spare.gain = inf: it must be a finite number"),
        ('name = "a"\n[spare', "not TOML:"),
    ],
)
def test_a_complaint_names_the_key_its_value_and_what_is_allowed(tmp_path, text, complaint):
    with pytest.raises(BenchFileError) as raised:
        settings(tmp_path, text)

    assert str(raised.value).startswith(f"{tmp_path / 'bench.toml'}: {complaint}")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BenchFileError, match=r"nowhere.toml: no such file"):
        read_table(tmp_path / "nowhere.toml")


def test_a_file_that_is_not_text_is_refused(tmp_path):
    file = tmp_path / "bench.toml"
    file.write_bytes(b"\xff\xfe\x00")

    with pytest.raises(BenchFileError, match="not TOML"):
        read_table(file)


texts = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\x7f"), min_size=1)
values = st.one_of(
    texts, st.booleans(), st.integers(-(2**62), 2**62), st.floats(allow_nan=False, allow_infinity=False)
)
tables = st.dictionaries(
    texts,
    st.one_of(
        values, st.lists(values), st.lists(st.dictionaries(texts, values)), st.dictionaries(texts, values)
    ),
)


@given(tables)
def test_written_tables_are_read_back(tmp_path_factory, table):
    file = tmp_path_factory.mktemp("toml") / "bench.toml"
    file.write_text(written(table), encoding="utf-8")

    assert read_table(file) == table


def test_none_is_left_out_when_written():
    assert written({"a": 1, "b": None, "c": {"d": None}}) == "a = 1\n\n[c]\n"
