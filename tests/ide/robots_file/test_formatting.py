"""An improv.toml before and after it was formatted."""

from __future__ import annotations

import pytest
import tomllib
from hypothesis import given
from hypothesis import strategies as st

from improv_core.diagnostics import applied
from improv_core.ide.robots_file.formatting import format_file, format_span
from improv_core.robots.toml_positions import comments
from improv_core.text import Span
from tests.robots.test_toml_text import documents, is_valid


def check(before: str, after: str) -> None:
    assert applied(before, format_file(before)) == after
    assert format_file(after) == []


def test_spaces_and_empty_lines_are_put_right() -> None:
    check("[ros]\nstop='a=b' # c=d\n", "[ros]\nstop = 'a=b' # c=d\n")
    check("[robots.a]\nstart\t=   {x=1, y =2}\n", "[robots.a]\nstart = {x = 1, y = 2}\n")
    check("\n[ros]\nstop = 'a'\n# b\n  [robots.b]\n\n\n[world]", "[ros]\nstop = 'a'\n\n# b\n  [robots.b]\n\n[world]\n")
    check("# first\n[ros]\r\n[world]\r\n", "# first\n[ros]\r\n\n[world]\r\n")
    check("[ros]\r\n[world]\r\n", "[ros]\r\n\r\n[world]\r\n")
    check("[ros] \t\nstop = 'a'  # b \n\t\n\n", "[ros]\nstop = 'a'  # b\n")
    check("", "")


def test_strings_and_indentation_stay_as_they_are() -> None:
    text = '[ros]\n    node = """ \n\n\n[a]  \n x=1\n# b \n"""\nstop = "a=b  "\n'
    check(text, text)
    check("[world]\nwalls = [\n      [0,0, 1,1], \n\n\n  ]\n", "[world]\nwalls = [\n      [0,0, 1,1],\n\n  ]\n")


@pytest.mark.parametrize("text", ["[ros\nstop=1", "[ros]\n\n\nstop=", "stop=1\nstop=2"])
def test_a_file_with_a_syntax_error_is_left_as_it_is(text: str) -> None:
    check(text, text)


def test_formatting_a_selection_leaves_other_lines_alone() -> None:
    text = "[ros]\nstop=1\nnode=2\n"
    assert applied(text, format_span(text, Span(8, 9))) == "[ros]\nstop = 1\nnode=2\n"


# Also characters that only a multi-line string can hold.
MESSY = st.lists(
    documents() | st.sampled_from(["\n\n", " \n", "\t", 'm = """ \n\n\n[x]\n a=1 # b \n"""\n', "\r\n\r\n"])
)


@given(documents().filter(is_valid) | MESSY.map("".join).filter(is_valid))
def test_formatting_keeps_values_and_comments(text: str) -> None:
    after = applied(text, format_file(text))
    assert repr(tomllib.loads(after)) == repr(tomllib.loads(text))
    assert noted(after) == noted(text)
    assert format_file(after) == []


def noted(text: str) -> list[str]:
    return [text[slice(*span)].rstrip(" \t") for span in comments(text)]
