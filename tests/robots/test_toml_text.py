"""Keys and values are found at their exact places, in every form that TOML allows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import tomllib
from hypothesis import example, given
from hypothesis import strategies as st

from improv_core.diagnostics import applied
from improv_core.robots.toml_positions import Keys, find_positions
from improv_core.robots.toml_text import read_toml

# Texts that look like syntax, to reveal a scanner that they fool.
words = st.sampled_from(["a", "b-1", "2", "x_y"])
strange = st.text(st.sampled_from("ab \t#[]{}=,.\"'\\é🐢"), max_size=6)
names = words | strange
blanks = st.sampled_from(["", " ", "\t "])
breaks = st.sampled_from(["\n", "\r\n", " # ] } \"'''\n", "\n\n#[x]\n"])
spaces = st.sampled_from(["", " ", "\n", " # ], '\n "])
dates = ["1979-05-27", "1979-05-27 07:32:00", "1979-05-27T07:32:00.5Z", "07:32:00"]
plain = st.sampled_from(["true", "0.5", "-1_000", "0xff", "1e3", "-inf", *dates])


def basic(text: str) -> str:
    return '"' + text.replace("\\", r"\\").replace('"', r"\"").replace("\t", r"\t") + '"'


def quoted(text: str) -> st.SearchStrategy[str]:
    """Generate all quoted forms of a text."""
    ways = [basic(text), '""' + basic(text) + '""', '""' + basic(text) + '""""', f'"""\n{basic(text)[1:-1]}\\\n  """']
    if "'" not in text:
        ways += [f"'{text}'", f"'''{text}'''", f"'''\n{text}''''"]
    return st.sampled_from(ways)


def key(name: str) -> str:
    return name if name.replace("-", "").replace("_", "").isascii() and name.isalnum() else basic(name)


@st.composite
def arrays(draw: st.DrawFn, items: st.SearchStrategy[str]) -> str:
    inner = [draw(spaces) + item + draw(spaces) for item in draw(st.lists(items, max_size=3))]
    return "[" + ",".join(inner) + draw(st.sampled_from(["", ","]) if inner else spaces) + "]"


@st.composite
def inline_tables(draw: st.DrawFn, items: st.SearchStrategy[str]) -> str:
    pairs = draw(st.dictionaries(names, items, max_size=3))
    inner = [f"{draw(blanks)}{key(name)}{draw(blanks)}={draw(blanks)}{value} " for name, value in pairs.items()]
    return "{" + ",".join(inner) + "}"


values = st.recursive(plain | strange.flatmap(quoted), lambda items: arrays(items) | inline_tables(items), max_leaves=6)


@st.composite
def documents(draw: st.DrawFn) -> str:
    """Generate random sequences of statements; not all are valid together."""
    text = draw(breaks)
    for _ in range(draw(st.integers(0, 6))):
        dotted = f"{draw(blanks)}.{draw(blanks)}".join(
            key(name) for name in draw(st.lists(names, min_size=1, max_size=3))
        )
        kind = draw(st.sampled_from(["pair", "pair", "[ ]", "[[ ]]"]))
        if kind == "pair":
            text += f"{dotted}{draw(blanks)}={draw(blanks)}{draw(values)}"
        else:
            text += kind.replace(" ", draw(blanks) + dotted + draw(blanks))
        text += draw(breaks)
    return text


def walk(value: Any, keys: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """Yield every path of keys in a document, and its value."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, item in inner:
        yield (*keys, name), item
        yield from walk(item, (*keys, name))


def is_valid(text: str) -> bool:
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return False
    return True


@given(documents().filter(is_valid))
@example("[[a]]\nb.c=1\n[[a.d]]\n[a.d.e]\nf=[{g=1},{g=2}]\n[[a]]\n[[a.d]]\n")
def test_every_key_and_value_is_found_where_it_stands(text: str) -> None:
    toml = read_toml(text)
    expected = dict(walk(tomllib.loads(text)))
    assert toml.data == tomllib.loads(text)
    assert toml.positions.entries.keys() == expected.keys()
    for keys, value in expected.items():
        entry = toml.positions.entries[keys]
        written = text[slice(*entry.value)]
        if isinstance(keys[-1], str):
            assert tomllib.loads(f"{text[slice(*entry.key)]} = 0") == {keys[-1]: 0}
        if entry.value != entry.key or not isinstance(value, dict | list):
            assert written == written.strip()
            assert tomllib.loads(f"value = {written}")["value"] == value


@given(documents() | st.text(st.sampled_from("ab=\"'[]{}.,#\\\n\r \ufeff🐢\x000")))
def test_no_text_raises_and_diagnostics_lie_in_it(text: str) -> None:
    for diagnostic in read_toml(text).diagnostics:
        assert diagnostic.code == "syntax"
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(text)


@pytest.mark.parametrize("text", ["a=" + "[" * 100_000, "a=" + "1" * 5000, "x=" + "{a=" * 2000, "a." * 9_999 + "b=1"])
def test_files_that_python_cannot_read_are_refused(text: str) -> None:
    (diagnostic,) = read_toml(text).diagnostics
    assert diagnostic.message == "this file can't be read: nest brackets less deeply, and use shorter keys and numbers"


@pytest.mark.parametrize("text", ["[x]\n" + "a b\n" * 9_999, "a." * 9_999 + "b=1"])
def test_names_of_keys_are_followed_only_so_far(text: str) -> None:
    assert max(map(len, find_positions(text).entries)) < 200


def test_a_byte_order_mark_moves_nothing() -> None:
    assert read_toml("\ufeffkey = 1").positions.entries["key",].key == (1, 4)


@pytest.mark.parametrize(
    ("text", "fixed"),
    [
        ("profile = turtlesim\n", 'profile = "turtlesim"\n'),
        ("size = [", None),
        ("profile = \n", None),
    ],
)
def test_text_without_quotes_has_a_fix(text: str, fixed: str | None) -> None:
    (diagnostic,) = read_toml(text).diagnostics
    assert [applied(text, fix.edits) for fix in diagnostic.fixes] == ([fixed] if fixed else [])
