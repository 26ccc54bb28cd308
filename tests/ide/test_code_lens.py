"""What stands above the lines that robots play, `text → command robot`."""

from __future__ import annotations

from improv_core.ide.code_lens import MOST_LINES, lenses
from improv_core.program.analysis import analyze


def check(program: str, *lines: tuple[str, list[str]], muted: str = "", soloed: str = "") -> None:
    """The lenses above each line, named by its robots. Each has a column of its own."""
    found: dict[str, list[str]] = {}
    columns: dict[int, str] = {}
    for lens in lenses(analyze(program), muted.split(), soloed.split()):
        told = f"{lens.text} → {lens.command}{f' {lens.robot}' if lens.robot else ''}"
        line = program.count("\n", 0, lens.span.start)
        found.setdefault(program.splitlines()[line].split(" $")[0].strip(), []).append(told)
        columns[lens.span.start] = told
    assert found == dict(lines)
    assert list(columns) == sorted(columns)
    assert len(columns) == sum(map(len, found.values()))


HUSH = "■ hush → hush"


def test_each_line_that_plays_can_be_played_and_says_how_long_it_takes() -> None:
    check("beat 30\nx = up\nr $ repeat 4 x left # 🐢", ("r", ["▶ play · 5 beats, 10.0 s → play", HUSH]))
    check("r $ repeat up", ("r", ["▶ play · ∞ → play", HUSH]))
    check("r $ lft", ("r", ["▶ play → play", HUSH]))
    check("x = up\n$ up\n# r $ up")


def test_where_several_play_each_can_be_muted_and_soloed() -> None:
    up = "▶ play · 1 beat, 1.0 s → play"
    check(
        "r $ up\r\n  s t $ up",
        ("r", [up, HUSH, "mute → mute r", "solo → solo r"]),
        ("s t", [up, HUSH, "mute s → mute s", "solo s → solo s", "mute t → mute t", "solo t → solo t"]),
    )
    check(
        "r $ up\ns $ up",
        ("r", [up, HUSH, "unmute → mute r", "solo → solo r"]),
        ("s", [up, HUSH, "mute → mute s", "unsolo → solo s"]),
        muted="r",
        soloed="s",
    )
    assert len(lenses(analyze("a b c d e $ up"))) == 2 + 3 * 2


def test_a_huge_program_has_them_only_so_far() -> None:
    assert len(lenses(analyze("r $ up\n" * 3 * MOST_LINES))) == 2 * MOST_LINES
