"""What stands above the lines that robots play and above definitions, `text → command robot`."""

from __future__ import annotations

from improv_core.ide.code_lens import MOST_LINES, lenses
from improv_core.program.analysis import analyze


def check(program: str, *lines: tuple[str, list[str]], muted: str = "", soloed: str = "") -> None:
    """The lenses above each line, named by its robots or by what it defines. Each has a column of its own."""
    found: dict[str, list[str]] = {}
    columns: dict[int, str] = {}
    for lens in lenses(analyze(program), muted.split(), soloed.split()):
        told = f"{lens.text} → {lens.command}{' this' * lens.only_this}{f' {lens.robot}' if lens.robot else ''}"
        line = program.count("\n", 0, lens.span.start)
        found.setdefault(program.splitlines()[line].split(" $")[0].split(" =")[0].strip(), []).append(told)
        columns[lens.span.start] = told
    assert found == dict(lines)
    assert list(columns) == sorted(columns)
    assert len(columns) == sum(map(len, found.values()))


HUSH = "■ hush → hush"


def test_each_line_that_plays_can_be_played_and_says_how_long_it_takes() -> None:
    check("beat 30\n# x = up\nr $ repeat 4 up left # 🐢", ("r", ["▶ play · 5 beats, 10.0 s → play", HUSH]))
    check("r $ repeat up", ("r", ["▶ play · ∞ → play", HUSH]))
    check("r $ lft", ("r", ["▶ play → play", HUSH]))
    check("$ up\n# r $ up")


def test_a_name_can_be_tried_and_a_phrase_once_something_uses_it() -> None:
    play = ["▶ play · 8 beats, 8.0 s → play", HUSH]
    check(
        "x = repeat 2 up\npoly n = repeat n x\nr $ poly 4",
        ("x", ["▶ try · 2 beats, 2.0 s → play this"]),
        ("poly n", ["▶ try → play this"]),
        ("r", play),
    )
    check("poly n = repeat n up")
    check("poly n = repeat n up\nmore n = poly n")
    check("poly n = repeat n up\nmore = poly", ("more", ["▶ try → play this"]))
    check("x = lft", ("x", ["▶ try → play this"]))


def test_where_several_play_each_can_be_muted_and_soloed() -> None:
    up = ["▶ this line · 1 beat, 1.0 s → play this", "▶ play all → play", HUSH]
    check(
        "r $ up\r\n  s t $ up",
        ("r", [*up, "mute → mute r", "solo → solo r"]),
        ("s t", [*up, "mute s → mute s", "solo s → solo s", "mute t → mute t", "solo t → solo t"]),
    )
    check(
        "r $ up\ns $ up",
        ("r", [*up, "unmute → mute r", "solo → solo r"]),
        ("s", [*up, "mute → mute s", "unsolo → solo s"]),
        muted="r",
        soloed="s",
    )
    assert len(lenses(analyze("a b c d e $ up"))) == 2 + 3 * 2


def test_a_huge_program_has_them_only_so_far() -> None:
    assert len(lenses(analyze("r $ up\n" * 3 * MOST_LINES))) == 3 * MOST_LINES
