"""The standard layout: before → after, and the laws for any program: only spaces and line ends change, and characters
that stand for ours become ours."""

from __future__ import annotations

import re
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from improv_core.diagnostics import Edit
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json
from improv_core.syntax.characters import usual
from improv_core.syntax.formatter import WIDTH, edits, format_text
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.text import LINE_END, Span

ROOT = Path(__file__).parents[2]


def check(before: str, after: str) -> None:
    """Check a program and its layout; formatting the layout changes nothing, and both mean the same."""
    assert format_text(before) == after
    check_laws(before)


def check_laws(text: str) -> None:
    formatted = format_text(text)
    assert format_text(formatted) == formatted
    assert meaning(formatted) == meaning(text)
    assert comments(formatted) == comments(text)
    assert wrong(formatted) == wrong(text)
    assert code(formatted) == code(text)


def meaning(text: str) -> Any:
    """Return the whole meaning of a program, without offsets."""
    analysis = analyze(text)
    score = to_json(score_of(analysis))
    movements: list[str] = []  # each as text; statements share one only at the same place
    for kind, *rest in score["movements"]:
        if kind == "hold":
            said = rest[:2]
        elif kind == "to_pose":
            said = rest[:1]
        elif isinstance(rest[0], list):
            said = [movements[place] for place in rest[0]]
        else:
            said = [movements[rest[0]], *rest[1 : {"use": 1, "chance": 2}.get(kind)]]
        movements.append(f"{kind} {hash(str(said))}")
    parts = [
        (robot, {**part, "scenes": [movements[scene] for scene in part["scenes"]]})
        for robot, part in score["parts"].items()
    ]
    codes = [diagnostic.code for diagnostic in analysis.diagnostics]
    return len(analysis.statements), codes, score["tempo"], parts


def comments(text: str) -> list[str]:
    return [comment.rstrip(" \t\ufeff") for comment in re.findall(r"#[^\r\n]*", usual(text))]


def wrong(text: str) -> list[str]:
    """Return the statements with errors of form."""
    return [piece for _, piece in split(text) if parse_statement(piece).diagnostics]


def code(text: str) -> str:
    """Return all signs except spaces, in their order, each as ours."""
    return re.sub(r"[ \t\r\n\ufeff]", "", usual(text))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", ""),
        (" \n\t\n", ""),
        ("beat 60", "beat 60\n"),
        ("  beat\t60  ", "beat 60\n"),
        ("turtle1$forward(left)right||rest", "turtle1 $ forward (left) right || rest\n"),
        ("x=repeat2 forward", "x = repeat2 forward\n"),
        ("x=fast 2forward slow 3/2[ left  right ]", "x = fast 2 forward slow 3/2 [left right]\n"),
        ("r1  r2\t$ scale 1.50 ( ) [\n]", "r1 r2 $ scale 1.50 () []\n"),
        ("x = reflect  YZ ( a||b )", "x = reflect YZ (a || b)\n"),
        ("x = ((left)\n  [ (right)\n] )", "x = ((left) [(right)])\n"),
        ("r $ forward\n\n\n\n\nbeat 60\n\n", "r $ forward\n\nbeat 60\n"),
        ("f  n(m)( k )=repeat n  m k", "f n (m) (k) = repeat n m k\n"),
        ("f n=scale n *2/ 3 left g 4 / n (a)", "f n = scale n*2/3 left g 4/n (a)\n"),
        ("r $ a\n ----- # two\nr $ b", "r $ a\n-----  # two\nr $ b\n"),
        ("r $ until not near ( a )||if cue a b else(c)", "r $ until not near (a) || if cue a b else (c)\n"),
        # A `||` or `else` that begins a line still does.
        ("r $ a || b\n|| c d", "r $ a || b\n  || c d\n"),
        ("r $ if near a\n\n\nelse if cue b\n    else c", "r $ if near a\n  else if cue b\n  else c\n"),
        ("x = (a\n|| b)\n|| c", "x = (a || b)\n  || c\n"),
        # Tokens that touch before the sign are one name, though a wrong one.
        ("my-robot   other$forward", "my-robot other $ forward\n"),
    ],
)
def test_spaces_and_lines(before: str, after: str) -> None:
    check(before, after)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("x = left\r\ny = right\nz = up\r\n", "x = left\r\ny = right\r\nz = up\r\n"),
        ("x = left\r\ry = (a\r)", "x = left\r\ry = (a)\r"),
        ("x = left\ny = right\r\n", "x = left\ny = right\n"),  # as many of each: the first counts
        ("\ufeff\n x = left", "\ufeffx = left\n"),
        ("\ufeff \n", "\ufeff"),
        # Line ends in a statement that stays do not count: they would count for more the second time.
        ("x = (a\n\nb\n\nc\r\n\r\nbeat 60\r\n", "x = (a\n\nb\n\nc\r\n\r\nbeat 60\r\n"),
        ("x = (a\r\nb", "x = (a\r\nb\r\n"),
    ],
)
def test_line_ends_and_bom(before: str, after: str) -> None:
    check(before, after)


def test_comments_keep_their_places() -> None:
    check(
        dedent("""
              # A whole line.
            #and another


                # set off
            x=left# behind
               # below
            y = [ # opens
            left  # one
               || right up # two


              # three
             ] # closes
            z = ( left
            # last
            ) (a  b) reverse # what?
        """),
        dedent("""\
            # A whole line.
            #and another

            # set off
            x = left  # behind
            # below
            y = [  # opens
              left  # one
              || right up  # two

              # three
            ]  # closes
            z = (
              left
              # last
            ) (a  b) reverse # what?
        """).replace("z = (\n  left\n  # last\n)", "z = ( left\n# last\n)"),  # statements with errors stay as they are
    )


def test_a_comment_breaks_the_brackets_around_it_and_no_others() -> None:
    check(
        "x = (left) [up ((down # why\n) right) (rest)] (left)",
        dedent("""\
            x = (left) [
              up
              (
                (
                  down  # why
                )
                right
              )
              (rest)
            ] (left)
        """),
    )


def test_a_comment_inside_a_term_parts_it() -> None:
    check(
        "x = (a repeat # how often?\n 4 fast\n# how fast?\n2 (b || # and\nc))",
        dedent("""\
            x = (
              a
              repeat  # how often?
              4 fast
              # how fast?
              2 (
                b
                ||  # and
                c
              )
            )
        """),
    )


def test_long_brackets_are_broken_outermost_first() -> None:
    steps, turns = "forward " * 16, "[left right] " * 9
    check(
        f"r $ repeat 4 ({steps}|| slow 2 ({turns}) rest) || fast 2 (left right)",
        """\
r $ repeat 4 (
  forward forward forward forward forward forward forward forward forward forward forward forward
  forward forward forward forward
  || slow 2 (
    [left right] [left right] [left right] [left right] [left right] [left right] [left right]
    [left right] [left right]
  )
  rest
) || fast 2 (left right)
""",
    )


def test_brackets_stay_whole_as_long_as_they_fit() -> None:
    curve = "(scale 13/8 forward || left)"
    check(
        f"x = {' '.join([curve] * 7)}",
        f"""\
x = {curve} {curve} {curve} (
  scale 13/8 forward
  || left
) {curve} {curve} {curve}
""",
    )


def test_only_statements_that_are_too_wide_are_broken() -> None:
    inside = "left " * 18
    check(f"x = ({inside}rest)", f"x = ({inside}rest)\n")  # exactly the longest line
    check(f"x = ({inside}rest) # and more", f"x = ({inside}rest)  # and more\n")
    check(f"y = () ({inside}rest)", f"y = () (\n  {inside}rest\n)\n")
    check(f"x = {inside}{inside}()", f"x = {inside}{inside}()\n")


def test_broken_brackets_that_fit_are_joined() -> None:
    check("x = (\n  forward\n\n  || left\n) [\nup\n]\n", "x = (forward || left) [up]\n")


def test_wrong_statements_keep_their_layout() -> None:
    check("  x = (a   b\n\n    c  # not closed\ny=a\n r$ ,  a\n", "x = (a   b\n\n    c  # not closed\ny = a\nr$ ,  a\n")


def test_edits_cover_only_changes() -> None:
    assert edits("beat 60\n") == []
    assert edits("beat 60\nx=left\n\n") == [Edit(Span(8, 14), "x = left"), Edit(Span(14, 16), "\n")]


@pytest.mark.slow("formats the largest programs")
def test_deepest_and_longest() -> None:
    check_laws(f"x = {'(' * 199}left{')' * 199}")
    check_laws(f"x = {'([left] fast 2 ' * 60}{'left ' * 500}# deep\n{')' * 60}")
    check_laws(f"x = {'()' * 1000}{'(left)' * 1000}")


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.improv")), ids=lambda path: path.stem)
def test_examples_have_the_layout(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert format_text(text) == text
    check_laws(text.replace(" ", "   ").replace(")", "\n)"))


WORDS = ["forward", "strafeleft", "left", "x", "größe", "unknown"]
LEADS = [
    "ease",
    "ramp 1/2 2",
    "fit 4",
    "until cue",
    "pause not near",
    "if near up else",
    "chance 1/2",
    "f 3",
    "reverse",
]
LEADS += ["retrograde", "repeat", "repeat 3", "repeat 0", "reflect YZ", "fast 2", "slow 3/2", "scale 1.50"]
HEADS = ["f n (m) =", "x =", "größe =", "r1 $", "r1 r2 $", "my-robot $", "1 $", "r3 $ left ||"]
WHOLE = ["---", "f n (m) = repeat n*2/3 ( m )", "beat 92.5", "beat 0", "beat +60", "x = ( ) [ ]"]
WRONG = ["x = ( left", "r $ [ left ( up ]", "x = left )", "beat", "r $ fast", "x left", "= up", "r $ left , right"]
REMARKS = ["# note", "#", "# x = (", "# $ ]\t", "# ünï \u2028 code", "#\ufeff"]


def combined(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    series = st.lists(inner, min_size=1, max_size=12).map(" ".join)
    movement = st.lists(series, max_size=3).map(" || ".join)
    bracket = st.sampled_from(["( {} )", "[ {} ]"])
    return st.builds(str.format, bracket, movement) | st.builds("{} {}".format, st.sampled_from(LEADS), inner) | series


movements = st.recursive(st.sampled_from(WORDS), combined, max_leaves=60)
statements = st.builds("{} {}".format, st.sampled_from(HEADS), movements) | st.sampled_from([*WHOLE, *WRONG])
line_ends = st.sampled_from(["\n", "\r\n", "\r"])


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Draw programs as people might type them, some of them wrong."""
    end = draw(line_ends.map(st.just) | st.just(line_ends))  # one for all, or a mix
    remark = st.builds(str.__add__, st.sampled_from(REMARKS), end)
    outside = st.sampled_from(["", " ", " ", "\t", "   "])
    between = st.lists(end | remark | outside, max_size=3).map("".join)
    inside = outside | st.sampled_from(["", " ", "\ufeff"]) | st.builds("{}{}".format, end | remark, between)
    text = draw(st.sampled_from(["", "", "\ufeff"])) + draw(between)
    for statement in draw(st.lists(statements, max_size=5)):
        depth = 0
        for token in statement.split():
            must_part = re.search(r"[\w.]$", text) and re.match(r"[\w+.]", token)
            text += draw(inside if depth else outside) + " " * bool(must_part) + token
            depth += (token in "([") - (token in ")]")
        text += draw(remark | end) + draw(between)
    return text + draw(st.sampled_from(["", "\n\n", "# end", " \t"]))


@pytest.mark.slow("tries many programs")
@given(programs())
def test_laws_of_programs(text: str) -> None:
    check_laws(text)


@given(programs())
@example("f n (m) = " + "forward " * 12)
def test_layout_of_programs(text: str) -> None:
    formatted = format_text(text)
    for line in LINE_END.split(formatted.removeprefix("\ufeff")):
        bare = re.sub(r"#.*", "", line, flags=re.DOTALL).rstrip()
        if len(bare) > WIDTH and not any(bare in piece for piece in wrong(formatted)):
            body = re.sub(r"^[^=$]*[=$]", "", bare)  # a head stays on one line, with its parameters in brackets
            assert not re.search(r"\((?!\)|$)|\[(?!\]|$)", body), "a bracket in it could be broken"
    place = 0
    for start, piece in [*split(formatted), (len(formatted), "")]:
        assert "\n\n\n" not in LINE_END.sub("\n", formatted[place:start])
        place = start + len(piece)
    assert not re.search(r"^\ufeff?[\r\n]|[ \t]$|(\r\n|\n|\r)\1$", formatted)


PIECES = [*"()[]()[]$==,-#x\t\n\n\r\f\xa0\ufeff\u2028😀", "||", " ", "\r\n", "\nx=", "\nr $", "YZ", "3/2", "1.5", "4"]
PIECES += ["\n||", "\nelse ", "if near ", "\n---\n", "*", "\nf n (m) =", "beat ", "repeat", "reflect", "fast "]
PIECES += ["forward", "left ", "r ", *"（）［］＝＄＃４－．／×÷−　\u2003\u200b\u200d\u0301आगे"]


@given(st.lists(st.sampled_from(PIECES), max_size=40).map("".join))
@example("x = (a\n# remark\n\n y = b")
@example("\ufeff\ufeffx = (\n\ufeffbeat 60)")
def test_laws_of_anything(text: str) -> None:
    check_laws(text)


def test_a_head_stays_on_its_line() -> None:
    long = "forward " * 13 + "left"
    check(f"f n(m)={long}# note\n", f"f n (m) = {long}  # note\n")
    check(f"x=(left# note\n f n(m)={long}# note\n", f"x=(left# note\nf n (m) = {long}  # note\n")
