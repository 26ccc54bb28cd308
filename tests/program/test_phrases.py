"""Phrases with parameters: a use is its body with the arguments written in."""

from __future__ import annotations

import re
from fractions import Fraction
from itertools import islice

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.diagnostics import Severity
from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled
from improv_core.score.performance import SenseSpan
from improv_core.score.walk import walk
from tests.program.drawing import check, check_all

NUMBERS = ["1", "2", "3", "0.5", "1.5", "2*3/4"]
WORDS = ["forward", "left", "halfright", "up", "rest", "()", "choose (left right)", "[up left]"]
PLAIN = ["reverse", "retrograde", "ease", "accumulate", "shuffle", "choose", "reflect YZ", "repeat 2", "chance 1/3"]
PLAIN += ["until near", "pause near", "until not near", "if near left else", "if not bump (up left) else"]
WITH_NUMBER = ["fast", "slow", "scale", "fit", "repeat", "seed", "ramp 0"]

SENSED = [
    SenseSpan("near", None, Fraction(3, 4), Fraction(5, 2)),
    SenseSpan("near", "r", 5, 9),
    SenseSpan("bump", None, 3),
]

Pair = tuple[str, str]
"""A movement as it is written, and with the arguments of phrases written in."""


def movements(leaves: st.SearchStrategy[Pair], numbers: list[str]) -> st.SearchStrategy[Pair]:
    def combined(inner: st.SearchStrategy[Pair]) -> st.SearchStrategy[Pair]:
        def around(before: str, between: str, after: str) -> st.SearchStrategy[Pair]:
            return st.lists(inner, min_size=1, max_size=3).map(
                lambda pairs: (
                    before + between.join(pair[0] for pair in pairs) + after,
                    before + between.join(pair[1] for pair in pairs) + after,
                )
            )

        applied = st.sampled_from(PLAIN) | st.builds(
            "{} {}".format, st.sampled_from(WITH_NUMBER), st.sampled_from(numbers)
        )
        return (
            st.builds(lambda word, pair: (f"{word} {pair[0]}", f"{word} {pair[1]}"), applied, inner)
            | around("(", " ", ")")
            | around("(", " || ", ")")
            | around("[", " ", "]")
        )

    return st.recursive(leaves | st.sampled_from(WORDS).map(lambda word: (word, word)), combined, max_leaves=6)


def as_term(pair: Pair) -> Pair:
    return f"({pair[0]})", f"({pair[1]})"


def use_f(in_f: Pair, first: str, second: str, one: Pair, other: Pair) -> Pair:
    arguments = {"a": first, "b": second, "p": f"({one[1]})", "q": f"({other[1]})"}
    expanded = re.sub(r"\b[abpq]\b", lambda name: arguments[name[0]], in_f[0])
    return f"f {first} {second} {as_term(one)[0]} {as_term(other)[0]}", f"({expanded})"


def use_g(in_g: Pair, one: Pair) -> Pair:
    expanded = re.sub(r"\bp\b", lambda name: f"({one[1]})", in_g[1])
    return f"g {as_term(one)[0]}", f"({expanded})"


def with_and_without(in_f: Pair, in_g: Pair, played: Pair) -> Pair:
    """Return a program with two phrases, and one without."""
    definitions = f"f a b (p) (q) = {in_f[0]}\ng (p) = {in_g[0]}\n"
    return f"{definitions}r s $ {played[0]}\nr $ choose (left right)", f"r s $ {played[1]}\nr $ choose (left right)"


P, LEFT = st.just(("p", "p")), st.just(("left", "left"))
ANY_NUMBER = st.sampled_from(NUMBERS[:-1])
IN_F = st.shared(movements(st.sampled_from([("p", "p"), ("q", "q")]), [*NUMBERS, "a", "b*2", "3/a"]), key="f")
IN_G = st.shared(movements(st.builds(use_f, IN_F, ANY_NUMBER, ANY_NUMBER, P, P) | P, NUMBERS), key="g")
USE_F = st.builds(use_f, IN_F, ANY_NUMBER, ANY_NUMBER, LEFT, LEFT)
USE = USE_F | st.builds(use_g, IN_G, LEFT) | st.builds(use_g, IN_G, USE_F)
PROGRAMS = st.builds(with_and_without, IN_F, IN_G, movements(USE, NUMBERS))


@pytest.mark.slow("tries many programs")
@given(PROGRAMS)
def test_a_use_is_its_body_with_the_arguments_written_in(pair: Pair) -> None:
    short, long = (analyze(text) for text in pair)
    played = compiled(short, 80, SENSED)
    wrong = [each for each in short.diagnostics if each.severity is Severity.ERROR]
    if not wrong:
        assert long.ok
        assert played["robots"] == compiled(long, 80, SENSED)["robots"]
    elif all(short.lines.position(each.span.start).line > 1 for each in wrong) and uses_all(short.text):
        assert not long.ok


def uses_all(text: str) -> bool:
    """Return whether both phrases use all movements that they get: otherwise, an argument may be wrong but not used."""
    in_f, in_g = (set(re.findall(r"\w+", line.partition("=")[2])) for line in text.splitlines()[:2])
    return in_f >= {"p", "q"} and "p" in in_g


@given(movements(st.nothing(), NUMBERS))
def test_two_robots_on_a_line_are_in_unison(pair: Pair) -> None:
    analysis = analyze(f"r $ choose (up down)\nr s $ {pair[0]}")
    after_the_first_line = islice(walk(analysis.robots["r"], 1), 100)
    alone = islice(walk(analysis.robots["s"]), 100)
    assert [moment[1:3] for moment in after_the_first_line] == [moment[1:3] for moment in alone]


def test_parameters_hide_names_and_names_keep_their_meaning() -> None:
    analysis = analyze("x = rest rest\nf (x) = x\ng (m) = m x\nx = left\nr $ f up\ns $ g up\n")
    assert (analysis.robots["r"].duration, analysis.robots["s"].duration) == (1, 3)


def test_arguments_must_match_the_head() -> None:
    analysis = check("""
        poly n = repeat n left
        times n (m) = repeat n m
        x = left
        r $ poly
            ^^^^ arguments: `poly` takes 1 number: write `poly n`
        r $ poly 2 3 x
            ^^^^ arguments: `poly` takes 1 number, not 2 numbers: write `poly n`
        r $ (times 3)
             ^^^^^ arguments: `times` takes 1 number and 1 movement, not 1 number: write `times n (m)`
        r $ times left
            ^^^^^ arguments: `times` takes 1 number and 1 movement, not 1 movement: write `times n (m)`
        r $ x 3
              ^ arguments: `x` takes no number: write `repeat 3 x` or `scale 3 x`: the number comes first
        f (m) = m 2
                  ^ arguments: `m` takes no number: write `repeat 2 m` or `scale 2 m`: the number comes first
        r $ f x
    """)
    related = [other for each in analysis.diagnostics for other in each.related]
    assert [analysis.text[slice(*other.span)] for other in related] == ["poly", "poly", "times", "times"]
    assert related[0].message == "`poly n` is defined here"


def test_an_error_is_at_the_argument_that_causes_it() -> None:
    check("""
        poly n = repeat n scale 4/n left
        r $ poly 1.5
                 ^^^ bad-number: in `poly`: write the number after `repeat` as a whole number: 0, 1, 2, …
        r $ poly 0
                 ^ bad-number: in `poly`: write the number after `scale` without dividing by 0
        back (m) = rest reverse m
        both n (a) (b) = poly n a back b
        r $ both 3 (repeat left) repeat up
                                 ^^^^^^^^^ endless-reverse: in `back`: `reverse` needs a movement that ends: give the `repeat` in it a number
        r $ both 1/2 left up
                 ^^^ bad-number: in `poly`: write the number after `repeat` as a whole number: 0, 1, 2, …
        calm (m) = ease m
        r $ calm (left repeat up)
                 ^^^^^^^^^^^^^^^^ open-length: in `calm`: `ease` needs a movement that ends: `m` never ends
        one (m) (n) = choose (m n)
        r $ one left slow 2 up
                ^^^^ uneven-choice: in `one`: the items of `choose` differ in length (1 beat, 2 beats): give them one length with `fit`
    """)


def test_errors_that_do_not_depend_on_arguments_are_reported_once_in_the_phrase() -> None:
    check("""
        f n (m) = repeat n m fast 0 m reverse repeat left foo
                                  ^ bad-number: write the number after `fast` as a number above 0
                                      ^^^^^^^ endless-reverse: `reverse` needs a movement that ends: give the `repeat` in it a number
                                                          ^^^ unknown-name: `foo` is not defined: write `foo = …` above this line
        r $ f 2 left f 3 up
    """)


def test_an_error_names_its_cause_in_a_phrase() -> None:
    check("""
        spin = repeat left
        turn n = repeat fast n left
        f n = fit 2 (fast n up spin)
        g n = fit 2 (fast n up turn 3)
        r $ f 2 g 2
              ^ open-length: in `f`: `fit` needs a movement that ends: `spin` never ends
                  ^ open-length: in `g`: `fit` needs a movement that ends: `turn` never ends
    """)


def test_errors_in_heads_are_marked() -> None:
    check("""
        f n n (n) = fast n left
            ^ duplicate-parameter: another parameter is called `n` too: choose another name
               ^ duplicate-parameter: another parameter is called `n` too: choose another name
        g left (YZ) = up
          ^^^^ reserved-name: `left` is a reserved word: choose another name
                ^^ reserved-name: `YZ` is a reserved word: choose another name
        i (a) b = a
              ^ syntax: write `b` before `(a)`: numbers come first
        j (a b) = a
             ^ syntax: write one parameter in each pair of brackets: `(a) (b)`
        k () = up
           ^ syntax: write the name of a parameter in the brackets
        l [m] = up
          ^ syntax: write a parameter that is a movement in parentheses: `(m)`
        n (m = m
          ^ unclosed-bracket: close this bracket with `)`
        o n = n left
              ^ parameter-kind: `n` is a number here: write `(n)` in the head to make it a movement
        p (m) = fast m left
                     ^ parameter-kind: `m` is a movement here: write it without brackets in the head to make it a number
    """)


def test_unused_parameters_are_reported() -> None:
    check_all("""
        h a (b) (c) = up c
          ^ unused-name: the movement does not use `a`: use it or remove it here
             ^ unused-name: the movement does not use `b`: use it or remove it here
        r $ h 2 (left left) right
                ^^^^^^^^^^^ never-performed: this is never reached: make the movement alongside longer
    """)


def test_arguments_that_no_use_reaches_are_never_performed() -> None:
    check_all("""
        short (m) = m || rest
        both (m) = short m (m || rest rest)
        one (m) = choose m
        grown (m) = rest || reverse accumulate m
        r $ one (up left) grown (up left)
        r $ short (up left)
                      ^^^^ never-performed: 1 of these 2 beats is never performed: make the movement alongside longer
        r $ both (up left right)
                          ^^^^^ never-performed: 1 of these 3 beats is never performed: make the movement alongside longer
    """)


@pytest.mark.slow("reads the largest phrases there may be")
@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("a (m) = m m\nr $ " + "a " * 200 + "left", None),
        ("a (m) = m m\nr $ " + "a " * 201 + "left", "too-deep"),
        ("a (m) = " + "(" * 99 + "m" + ")" * 99 + "\nr $ a a left", None),
        ("a (m) = " + "(" * 100 + "m" + ")" * 100 + "\nr $ a a left", "too-deep"),
        ("a n = accumulate ((left fast n left))\nr $ " + "(" * 198 + "a 2" + ")" * 198, "too-deep"),
        ("p0 (m) = m m\n" + "".join(f"p{k + 1} (m) = p{k} p{k} m\n" for k in range(30)) + "r $ p30 left", "too-deep"),
        (
            "p0 a = scale a left\n" + "".join(f"p{k + 1} a = p{k} a p{k} a*2\n" for k in range(20)) + "r $ p20 1",
            None,
        ),
        (
            "p0 a = scale a left\n" + "".join(f"p{k + 1} a = p{k} a p{k} a*{k + 2}\n" for k in range(20)) + "r $ p20 1",
            "too-large",
        ),
        ("p0 (m) = m m\n" + "".join(f"p{k + 1} (m) = p{k} m p{k} m\n" for k in range(30)) + "r $ p30 left", None),
        ("p n = " + "scale n left " * 500 + "\nr $ " + "".join(f"p {k} " for k in range(1, 1_000)), "too-large"),
        ("s0 n = scale n left\n" + "".join(f"s{k + 1} n = s{k} n*n\n" for k in range(20)) + "r $ s20 3", "bad-number"),
    ],
    ids=lambda text: f"{str(text)[:30]!r}…",
)
def test_phrases_within_phrases_are_bounded(text: str, code: str | None) -> None:
    lines = text.count("\n")
    analysis = analyze(text)
    found = [each for each in analysis.diagnostics if analysis.lines.position(each.span.start).line == lines]
    assert [each.code for each in found] == ([code] if code else [])
