"""Signature help: the usage of the transformer at the cursor, with the argument being typed in brackets."""

from __future__ import annotations

from improv_core.ide.signature_help import signature
from tests.ide.cursor import at_cursor


def check(program: str, shown: str) -> None:
    found = signature(*at_cursor(program))
    assert found
    start, end = found.parameters[found.active]
    assert f"{found.label[:start]}<{found.label[start:end]}>{found.label[end:]}" == shown
    assert found.about


def check_nothing(program: str) -> None:
    assert signature(*at_cursor(program)) is None


def test_a_signature_marks_the_argument_at_the_cursor() -> None:
    check("r $ repeat |>", "repeat <n> movement")
    check("r $ repeat 4|>", "repeat <n> movement")
    check("r $ reflect |>", "reflect <PLANE> movement")
    check("r $ fast |> left", "fast <k> movement")
    check("r $ repeat 4 |>", "repeat n <movement>")
    check("r $ repeat fo|>", "repeat n <movement>")
    check("r $ repeat (|>", "repeat n <movement>")
    check("r $ slow 3/2 le|>ft", "slow k <movement>")
    check("r $ reflect YZ (left |> )", "reflect PLANE <movement>")
    check("r $ reverse |>", "reverse <movement>")
    check("x = repeat 4 (\n  left\n  |>\n)", "repeat n <movement>")
    check("r $ repeat 4 (reverse |>", "reverse <movement>")
    check("r $ repeat 4 (reverse left |>", "repeat n <movement>")
    check("r $ repeat 2 fast |>", "fast <k> movement")
    check("r $ repeat 2 (left) slow 2 [up |>", "slow k <movement>")


def test_measures_are_parameters_of_movements() -> None:
    check("r $ forward 1.5|>", "forward <length>")
    check("r $ scale 2 left 90|>", "left <angle> radius length")
    check("r $ left 90deg radius |>", "left angle radius <length>")


def test_there_is_no_signature_outside_arguments() -> None:
    for program in ("r $ |>", "r $ repeat 4 left |>", "repeat |>", "r $ repeat 4 (left) |>", "r $ repeat # |>", "|>"):
        check_nothing(program)
    check_nothing("r $ repeat 4 left || |>")
    check_nothing("r $ repeat|>")


def test_words_of_senses() -> None:
    check("r $ until |>", "until <sense> movement")
    check("r $ until not |>", "until <sense> movement")
    check("r $ pause ne|>ar left", "pause <sense> movement")
    check("r $ until near repeat |>", "repeat <n> movement")
    check("r $ if |>", "if <sense> movement else movement")
    check("r $ if near |>", "if sense <movement> else movement")
    check("r $ if not near (left right) else |>", "if sense movement else <movement>")
    check_nothing("r $ if near left else right |>")
    check_nothing("r $ until near left |>")


PHRASES = "# A polygon.\npoly n = repeat n (forward scale 4/n left)\ntimes n (m) = repeat n m\nboth (a) (b) = a || b\n"


def test_phrases_show_their_heads() -> None:
    check(f"{PHRASES}r $ poly |>", "poly <n>")
    check(f"{PHRASES}r $ poly 5|>", "poly <n>")
    check(f"{PHRASES}r $ poly 5/|>", "poly <n>")
    check(f"{PHRASES}r $ times |>", "times <n> (m)")
    check(f"{PHRASES}r $ times 3 |>", "times n <(m)>")
    check(f"{PHRASES}r $ times 3/2 fo|>", "times n <(m)>")
    check(f"{PHRASES}r $ both left |>", "both (a) <(b)>")
    check(f"{PHRASES}r $ both (left right) (|>", "both (a) <(b)>")
    check(f"{PHRASES}r $ both poly 3 |>", "both (a) <(b)>")
    check(f"{PHRASES}r $ reverse both times 2 left |>", "both (a) <(b)>")
    check(f"{PHRASES}f n (m) = both m times n*2 |>", "times n <(m)>")
    check_nothing(f"{PHRASES}r $ poly 5 |>")
    check_nothing(f"{PHRASES}r $ both times 2 left right |>")
    check_nothing(f"{PHRASES}f (poly) = poly |>")
    found = signature(*at_cursor(f"{PHRASES}r $ poly |>"))
    assert found
    assert found.about == "A polygon."
