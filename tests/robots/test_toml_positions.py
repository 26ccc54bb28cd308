"""Positions in a text that somebody is still typing."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.robots.toml_positions import Keys, beginning, find_positions

ANNA: Keys = ("robots", "anna")


@pytest.mark.parametrize(
    ("marked", "expects", "keys", "begun"),
    [
        ("[robots.|\n\n[world]\nsize = [1, 2]", "header", ("robots",), ""),
        ("[robots.anna]\n|", "key", ANNA, ""),
        ("[robots.anna]\nprofile =|", "value", (*ANNA, "profile"), ""),
        ('[robots.anna]\nprofile = "tur|\ntopic = "/a"', "value", (*ANNA, "profile"), '"tur'),
        ("[robots.anna]\nstart = { x = 1, |", "key", (*ANNA, "start"), ""),
        ("[robots.anna]\nstart = { x = 1\ntopic = |", "value", (*ANNA, "topic"), ""),
        ('[profiles.a]\nmotions = ["turn", "fo|', "value", ("profiles", "a", "motions", 1), '"fo'),
        ('[profiles.a]\nmotions = [\n  "turn",\n  |', "value", ("profiles", "a", "motions", 1), ""),
        ("[world]\ncircles = [{ x = 1 }, { |", "key", ("world", "circles", 1), ""),
        ("[[world.circles]]\nx = 1\n[[world.circles]]\n|", "key", ("world", "circles", 1), ""),
        ("[robots.anna]\nstart |", "name", (*ANNA, "start"), ""),
        ("robots.anna.start.|", "key", (*ANNA, "start"), ""),
        ('[robots."anna"]\n|', "key", ANNA, ""),
    ],
)
def test_the_next_word_is_known_at_the_cursor(marked: str, expects: str, keys: Keys, begun: str) -> None:
    """The `|` is the cursor."""
    found = beginning(marked.replace("|", ""), marked.index("|"))
    assert found
    assert (found[0].expects, found[0].keys, found[1]) == (expects, keys, begun)


@pytest.mark.parametrize("marked", ["# a|", '[ros]\nstop = "#/a" # |'])
def test_nothing_comes_in_a_comment(marked: str) -> None:
    assert beginning(marked.replace("|", ""), marked.index("|")) is None


@pytest.mark.parametrize(
    "unfinished",
    ["pro", "profile", "profile =", 'profile = "tur', "profile = tur", "start = {", "start = { x = 1,", "start = [[1"],
)
def test_an_unfinished_line_hides_nothing_below(unfinished: str) -> None:
    text = f'[robots.anna]\n{unfinished}\ntopic = "/a"\n\n[robots.bert]\nprofile = "jackal"\n[world]\nsize = [6, 4]\n'
    found = find_positions(text).entries
    for keys, value in {
        (*ANNA, "topic"): '"/a"',
        ("robots", "bert", "profile"): '"jackal"',
        ("world", "size"): "[6, 4]",
        ("world", "size", 1): "4",
    }.items():
        assert text[slice(*found[keys].value)] == value


@given(st.text(st.sampled_from("ab=\"'[]{}.,#\\\n\r \t\ufeff🐢\x000\ud800")), st.integers(0, 30))
def test_no_text_raises(text: str, offset: int) -> None:
    found = find_positions(text)
    for entry in found.entries.values():
        for span in entry.key, entry.value:
            assert 0 <= span.start <= span.end <= len(text)
    beginning(text, min(offset, len(text)))
