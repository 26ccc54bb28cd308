"""Selection ranges in an improv.toml, step by step."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from improv_core.ide.robots_file.structure import selections
from tests.ide.robots_file.test_completion import TEXTS


def check(marked: str, *texts: str) -> None:
    """Check that a selection grows from the cursor, `|`, to these texts, and then to the whole file."""
    text = marked.replace("|", "")
    assert [text[slice(*span)] for span in selections(text, marked.index("|"))] == [*texts, text]


def test_a_selection_grows_to_whole_parts() -> None:
    section = "[robots.anna]\nstart = { x = 1.5, y = 2 }"
    inside = " x = 1.5, y = 2 "
    check(
        "[ros]\n[robots.anna]\nstart = { x = 1.|5, y = 2 }\n",
        *("5", "1.5", "x = 1.5", inside, f"{{{inside}}}", f"start = {{{inside}}}", section),
    )
    check("[ros]\n[robots.an|na] # me\n", "anna", "[robots.anna]")
    check(
        "[ros]\nstop = '/e stop|' # now", "stop", "/e stop", "'/e stop'", "stop = '/e stop'", "[ros]\nstop = '/e stop'"
    )
    check("[ros]\n\n# left o|ver", "over", "# left over")
    check("[ros]\n[robots.anna]\nstart = { x = |1\n", "1", "x = 1", "[robots.anna]\nstart = { x = 1")


@given(TEXTS, st.integers(0, 60))
def test_no_text_raises(text: str, offset: int) -> None:
    found = selections(text, min(offset, len(text)))
    assert found[-1] == (0, len(text))
    assert all(out.start <= span.start <= span.end <= out.end for span, out in pairwise(found))
