"""Atoms of a TOML text, with tree-sitter's grammar and without it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.robots import toml_atoms
from improv_core.robots.config import read_robots
from improv_core.robots.toml_atoms import atoms, plain_atoms
from improv_core.robots.toml_positions import statements
from improv_core.robots.toml_text import read_toml
from improv_core.text import LineIndex

ROOT = Path(__file__).parents[2]
FILES = [path.read_text(encoding="utf-8") for path in sorted(ROOT.glob("examples/**/improv.toml"))]
assert FILES


@pytest.mark.parametrize(
    "text",
    [
        *FILES,
        "a = 1.5e-3\n",
        "a.'b c'.\"d\" = true # no key = 1\n",
        "[a.\"b\".c]\nd = [[1, 2], [3, 4]]\n",
        "[[a]]\nb = [{ x = 1, y.z = [2, { q = 'r' }] }, {}]\n",
        'a = """one\n[two]\n"three" = 4"""\nb = \'\'\'\n= ] }\'\'\'\n',
        "a = [[{}], [{ b = 1 }]]\nc = {}\nd = [[[1]]]\n",
        "a = [\n  1, # one\n  +2,\n]\nb = inf\n",
        "a = 1979-05-27 07:32:00Z\nb = 1979-05-27\nc = [07:32:00, 1979-05-27T00:32:00.9-07:00]\n",
    ],
)  # fmt: skip
def test_valid_texts_have_the_same_atoms_without_the_grammar(text: str) -> None:
    for _, statement in statements(text):
        assert tuple(plain_atoms(statement)) == atoms(statement)


@given(st.text(st.sampled_from("ab=1\"'[]{}.,#\\\n\r \t\ufeff🐢")))
def test_no_text_raises_and_atoms_do_not_overlap(text: str) -> None:
    end = 0
    for atom in plain_atoms(text):
        assert atom.span.start >= end
        assert text[slice(*atom.span)] == atom.text != ""
        end = atom.span.end


@pytest.fixture
def no_grammar(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As in a browser."""

    def forget() -> None:
        for cached in (atoms, toml_atoms._parser, read_toml):
            cached.cache_clear()

    monkeypatch.setitem(sys.modules, "tree_sitter", None)
    forget()
    yield
    forget()


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('[robots.ada]\nprofile = "nothing"\n', 2),
        ("[world]\nsize = [4, 4]\n\n[robots.ada\n", 4),
        ('[robots.ada]\nstart = { x = 0, y = "b" }\n', 2),
        ("[improv]\nrobot = 1\n", 1),
        ("[world]\nsize = [4, 4]\n[world]\nwalls = true\n", 3),
    ],
)
def test_errors_have_their_line_without_the_grammar(text: str, line: int, no_grammar: None) -> None:
    first, *_ = read_robots(text).diagnostics
    assert LineIndex(text).position(first.span.start).line + 1 == line
