"""The structure of an improv.toml: its outline, the lines that fold into the first one, and selections that grow."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from improv_core.ide.robots_file.structure import folds, outline, selections
from improv_core.text import LineIndex
from tests.ide.robots_file.test_completion import TEXTS
from tests.ide.test_document_symbol import drawn


def check_outline(text: str, *lines: str) -> None:
    assert [line for entry in outline(text) for line in drawn(entry, "")] == list(lines)


def test_the_outline_has_sections_with_their_keys() -> None:
    check_outline(
        "[profiles.rover] # mine\nstep = 0.5\n\n[robots.anna]\nprofile = 'rover'\nstart = { x = 1,\ty = 2 }\n[world]\n",
        "profiles.rover: profile",
        "  step: key 0.5",
        "robots.anna: robot",
        "  profile: key 'rover'",
        "  start: key { x = 1, y = 2 }",
        "world: section",
    )


def test_the_outline_has_keys_above_all_sections_and_keys_with_dots() -> None:
    check_outline(
        "world.size = [\n  6,\n  4,\n]\n[robots]\nanna.profile = 'husky'\n",
        "world.size: key [ 6, 4, ]",
        "robots: section",
        "  anna.profile: key 'husky'",
    )


def test_tables_of_an_array_and_a_long_value() -> None:
    check_outline(
        "[[world.circles]]\nx = 1\n[[world.circles]]\nx = 2\n[ros]\nstop = '/" + "a" * 60 + "'\n",
        "world.circles: section",
        "  x: key 1",
        "world.circles: section",
        "  x: key 2",
        "ros: section",
        "  stop: key '/" + "a" * 37 + "…",
    )


def check_folds(text: str, *expected: str) -> None:
    assert [f"{fold.first}-{fold.last} {fold.kind}" for fold in folds(LineIndex(text))] == list(expected)


def test_sections_values_and_comments_fold() -> None:
    check_folds(
        "[robots.a]\nprofile = 'husky'\n\n# about b\n[robots.b]\n\n[world]\nsize = [6, 4]", "0-1 code", "6-7 code"
    )
    check_folds("[world]\nwalls = [\n  [0, 0, 1, 1],\n]\nsize = [6,\n  4]\n", "0-5 code", "1-2 code", "4-5 code")
    check_folds("# one\n# two\n[ros]\n", "0-1 comment")
    check_folds("[ros]\nnode = '''\n# one\n# two\n'''\n", "0-4 code", "1-4 code")


def check_selections(marked: str, *texts: str) -> None:
    """Check that a selection grows from the cursor, `|`, to these texts, and then to the whole file."""
    text = marked.replace("|", "")
    assert [text[slice(*span)] for span in selections(text, marked.index("|"))] == [*texts, text]


def test_a_selection_grows_to_whole_parts() -> None:
    section = "[robots.anna]\nstart = { x = 1.5, y = 2 }"
    inside = " x = 1.5, y = 2 "
    check_selections(
        "[ros]\n[robots.anna]\nstart = { x = 1.|5, y = 2 }\n",
        *("5", "1.5", "x = 1.5", inside, f"{{{inside}}}", f"start = {{{inside}}}", section),
    )
    check_selections("[ros]\n[robots.an|na] # me\n", "anna", "[robots.anna]")
    check_selections(
        "[ros]\nstop = '/e stop|' # now", "stop", "/e stop", "'/e stop'", "stop = '/e stop'", "[ros]\nstop = '/e stop'"
    )
    check_selections("[ros]\n\n# left o|ver", "over", "# left over")
    check_selections("[ros]\n[robots.anna]\nstart = { x = |1\n", "1", "x = 1", "[robots.anna]\nstart = { x = 1")


@given(TEXTS, st.integers(0, 60))
def test_no_text_raises(text: str, offset: int) -> None:
    found = selections(text, min(offset, len(text)))
    assert found[-1] == (0, len(text))
    assert all(out.start <= span.start <= span.end <= out.end for span, out in pairwise(found))
