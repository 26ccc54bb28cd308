"""Inlay hints, drawn into the program as `⟨…⟩` at the places where an editor shows them."""

from __future__ import annotations

from improv_core.ide.inlay_hint import hints
from improv_core.program.analysis import analyze
from improv_core.text import Span


def check(program: str, shown: str) -> None:
    """Check the whole program with its hints."""
    assert drawn(program, Span(0, len(program))) == shown


def drawn(program: str, seen: Span) -> str:
    text = program
    for hint in sorted(hints(analyze(program), seen), key=lambda hint: hint.offset, reverse=True):
        text = f"{text[: hint.offset]}⟨{hint.text}⟩{text[hint.offset :]}"
    return text


def test_each_statement_shows_its_length() -> None:
    check(
        "beat 30\nsquare = repeat 4 (forward left)  # 🐢\r\nr $ square || repeat up\ns $ slow 1/3 up",
        "beat 30\nsquare = repeat 4 (forward left)⟨8 beats⟩  # 🐢\r\n"
        "r $ square || repeat up⟨8 beats⟩\ns $ slow 1/3 up⟨1/3 beats⟩",
    )
    check("r $ repeat up", "r $ repeat up⟨∞⟩")
    check("r $ (up\n  left\n)", "r $ (up\n  left\n)⟨2 beats⟩")


def test_nested_brackets_show_their_rates() -> None:
    check("r $ [up [left right] up]", "r $ [up [⟨×6⟩left right] up]⟨1 beat⟩")
    check("r $ [up slow 2 [left right || down]]", "r $ [up slow 2 [⟨×2⟩left right || down]]⟨1.5 beats⟩")
    check("r $ [up ([left left left])]", "r $ [up ([⟨×6⟩left left left])]⟨1 beat⟩")
    check("r $ [up left] [[up]]", "r $ [up left] [[up]]⟨2 beats⟩")


def test_wrong_statements_get_no_hint() -> None:
    for program in ("r $ lft up", "r $ (up", "r $ repeat 1/2 up", "beat 60", "# 🐢", "up", "r $", "x = []x"):
        check(program, program)
    check("x = lft\ny = x up\nr $ repeat 4 y", "x = lft\ny = x up\nr $ repeat 4 y")
    check("x = up # unused\nr $ lft\ns $ ()", "x = up⟨1 beat⟩ # unused\nr $ lft\ns $ ()⟨0 beats⟩")


def test_only_what_is_in_sight() -> None:
    program = "r $ up\ns $ up\nt $ up\n"
    assert drawn(program, Span(8, 12)) == "r $ up\ns $ up⟨1 beat⟩\nt $ up\n"
    (hint,) = hints(analyze("beat 30\nr $ up left"), Span(9, 10))
    assert (hint.text, hint.about) == ("2 beats", "4.0 s at beat 30")


def test_arguments_show_their_parameters() -> None:
    phrases = "f n (m) = repeat n m\ng (m) (k) = m k\n"
    check(
        f"{phrases}r $ f 2 (up) g f 4/2 up left",
        f"{phrases}r $ f ⟨n:⟩2 ⟨m:⟩(up) g ⟨m:⟩f ⟨n:⟩4/2 ⟨m:⟩up ⟨k:⟩left⟨5 beats⟩",
    )
