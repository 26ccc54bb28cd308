"""Selection ranges, from the cursor to the whole program, step by step."""

from __future__ import annotations

from improv_core.ide.selection_range import selections
from tests.ide.cursor import at_cursor


def check(program: str, *texts: str) -> None:
    """Check that a selection grows from the cursor to these texts, and then to the whole program."""
    analysis, offset = at_cursor(program)
    spans = selections(analysis, offset)
    assert [analysis.text[slice(*span)] for span in spans] == [*texts, analysis.text]


def test_a_selection_grows_to_whole_parts() -> None:
    check(
        "x = up\nr $ left [up reverse do|>wn] || x",
        "down",
        "reverse down",
        "up reverse down",
        "[up reverse down]",
        "left [up reverse down]",
        "left [up reverse down] || x",
        "r $ left [up reverse down] || x",
    )
    check("beat 30\nx = repeat |>4 left", "4", "repeat 4 left", "x = repeat 4 left")
    check("beat |>30\nr $ up", "30", "beat 30")
    check("beat 30\nr s| $ up".replace("|", "|>"), "s", "r s", "r s $ up")
    check("beat 30\nmy-ro|>bot s $ up", "robot", "my-robot", "my-robot s", "my-robot s $ up")
    check("beat 30\nr $ (left|>)", "left", "(left)", "r $ (left)")
    check("beat 30\nr $ (left)|>", ")", "(left)", "r $ (left)")
    check("# to the |>left\nr $ up", "left", "# to the left")
    check("beat 30\nr $ up # hig|>her", "higher", "# higher", "r $ up # higher")
    check("r $ left\n|>\nr $ up")
    check("|>")
    check("beat 30\nr $ (left re|>peat", "repeat", "left repeat", "(left repeat", "r $ (left repeat")
