"""No text raises an error or hangs.

By hand: IMPROV_FUZZ_SECONDS=600 pytest -s tests/program/test_fuzz.py
"""

from __future__ import annotations

import gc
import json
import os
import random
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.ide.code_action import fixes
from improv_core.ide.code_action_play import play_actions
from improv_core.ide.code_action_refactor import refactorings
from improv_core.ide.code_lens import lenses
from improv_core.ide.completion import complete
from improv_core.ide.document_symbol import outline
from improv_core.ide.folding_range import folds
from improv_core.ide.formatting import format_span
from improv_core.ide.hover import hover, robot_at
from improv_core.ide.inlay_hint import hints
from improv_core.ide.moments import Places, lit_words
from improv_core.ide.on_type_formatting import indent
from improv_core.ide.references import references, symbol_at
from improv_core.ide.rename import RefusalError, renamable, rename
from improv_core.ide.selection_range import selections
from improv_core.ide.semantic_tokens import colored, fragments
from improv_core.ide.signature_help import signature
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.program.program import scene_ids
from improv_core.program.report import summary
from improv_core.score.replay import Replay
from improv_core.score.score_json import from_json, to_json
from improv_core.syntax.formatter import format_text
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

SECONDS = float(os.environ.get("IMPROV_FUZZ_SECONDS", "2" if "IMPROV_REQUIRE_ALL" in os.environ else "0.6"))
"""Seconds of tests with random programs: longer in CI."""
LIMIT = 600
"""Seconds after which a test counts as hanging, on a busy machine."""
pytestmark = pytest.mark.timeout(2 * SECONDS + LIMIT)

EXAMPLES = [path.read_text(encoding="utf-8") for path in sorted(Path("examples").rglob("*.improv"))]
EXAMPLES += [
    case["program"]
    for case in json.loads(Path("tests/conformance.json").read_text(encoding="utf-8"))["cases"]
    if case["source"] == "language 2"
]
BODIES = json.loads(Path("tests/bodies.json").read_text(encoding="utf-8"))
EXAMPLES += [f"r1 is puppet\n{case['program']}" for part in (BODIES, BODIES["poses"]) for case in part["cases"]]
SIGNS = "head arms left_arm to start high x y größe = $ ( ) [ ] || | { * / \\ 2 1/0 3/2 -1 1e9 .5 n (m) near 😀 \0"
PIECES = [*WORDS, *SIGNS.split(" "), "9" * 40, '"', "# ", "(" * 30, "[" * 30, ")" * 30]
PIECES += ["\n", "\r\n", "\r", " ", "\t", "\f", "\u2028", "\ufeff", "\ud800", "\n---\n", "\n|| ", "\nelse "]
PIECES += ["x = ", "x n (m) = ", "y (m) = m m\n", "x 3 y ", "a b $ ", "r $ ", "beat 60\n", "until near repeat "]
PIECES += ["pause not cue ", "if bump () else ", "repeat 1000000000 ", "fast 1.000000001 "]


def bytes_of_any_kind(chance: random.Random) -> str:
    return chance.randbytes(chance.randrange(200)).decode("utf-8", "replace")


def pieces_in_any_order(chance: random.Random) -> str:
    return "".join(chance.choice(PIECES) for _ in range(chance.randrange(60)))


def programs_with_edits(chance: random.Random) -> str:
    text = chance.choice(EXAMPLES)
    for _ in range(chance.randrange(1, 8)):
        start = chance.randrange(len(text) + 1)
        text = text[:start] + chance.choice(PIECES) * chance.randrange(2) + text[start + chance.randrange(12) :]
    return text


@pytest.fixture(autouse=True)
def no_collector() -> Iterator[None]:
    """Turn off garbage collection: thousands of cached statements make it slow, whichever program it interrupts."""
    gc.disable()
    yield
    gc.enable()


def use(text: str, offset: int) -> Analysis:
    """Use everything that an editor and the command line need of a program."""
    analysis = analyze(text)
    assert analysis.diagnostics is not None
    hover(analysis, offset, pictures=True)
    complete(analysis, offset)
    list(lenses(analysis, scene_ids(analysis)))
    list(play_actions(analysis, offset))
    use_in_editor(analysis, offset)
    compiled(analysis, 100)
    summary(analysis)
    format_text(text)
    written = json.dumps(to_json(score_of(analysis)))
    assert json.dumps(to_json(from_json(json.loads(written)))) == written
    return analysis


def use_in_editor(analysis: Analysis, offset: int) -> None:
    """Use all other editor features, at a cursor and for a whole program."""
    cursor, everything = Span(offset, offset), Span(0, len(analysis.text))
    for name in list(analysis.robots)[:1]:
        robot_at(analysis, name, pictures=True)
    signature(analysis, offset)
    selections(analysis, offset)
    indent(analysis, offset)
    if symbol := symbol_at(analysis, offset):
        references(analysis, symbol)
    with suppress(RefusalError):
        rename(analysis, renamable(analysis, offset), "other")
    fixes(analysis.diagnostics, cursor)
    refactorings(analysis, cursor)
    format_span(analysis, cursor)
    hints(analysis, everything)
    outline(analysis)
    folds(analysis)
    for _, fragment in fragments(analysis):
        colored(fragment)
    lit_words(Replay(score_of(analysis)), 1.5, Places(analysis, analysis), lambda robot: False)


NUMBERS = st.sampled_from(["1000000000", "9" * 30, "." + "0" * 28 + "1", "3/2", "1.000000001", "100"])
TRANSFORMED = st.builds("{} {}".format, st.sampled_from(["repeat", "fast", "slow", "scale"]), NUMBERS)


@st.composite
def movements_of_huge_numbers(draw: st.DrawFn) -> str:
    """Draw factors and counts around one movement, each often enough to leave the range of floats."""
    around = draw(st.lists(st.tuples(TRANSFORMED, st.integers(1, 40)), min_size=1, max_size=4))
    body = draw(st.sampled_from(["forward", "rest", "(forward left)", "(forward || left)", "(repeat left || rest)"]))
    return " ".join(f"{word} " * times for word, times in around) + body


@given(
    st.lists(movements_of_huge_numbers(), min_size=1, max_size=4), st.sampled_from([" ", " || ", "\nr $ "]), st.data()
)
def test_no_number_is_too_large(movements: list[str], between: str, data: st.DataObject) -> None:
    text = "r $ " + between.join(movements)
    use(text, data.draw(st.integers(0, len(text))))


SOURCES = [bytes_of_any_kind, pieces_in_any_order, programs_with_edits]


@pytest.mark.parametrize("source", SOURCES)
def test_nothing_raises_and_nothing_hangs(source: Callable[[random.Random], str]) -> None:
    chance = random.Random(1)
    count, end = 0, time.monotonic() + SECONDS / 3
    while time.monotonic() < end:
        text = source(chance)
        place = chance.randrange(len(text) + 1)
        analysis = use(text, place)
        put = chance.choice(PIECES)
        edited = analysis.edited(place, min(place + chance.randrange(5), len(text)), put)
        assert edited.diagnostics is not None
        count += 1
        if count % 1000 == 0:
            gc.collect()
    assert count
    print(f"{source.__name__}: {count} programs")


MANY = 4_000
"""Far more levels than Python's stack has."""
WORST = [
    "r $ " + "(" * MANY,
    "r $ " + "(" * MANY + "left" + ")" * MANY,
    "r $ " + "reverse " * MANY + "left",
    "r $ " + "[left || " * MANY,
    ")" * MANY,
    "x = " * MANY,
    "$" * MANY,
    "r $ left " + "9" * MANY,
    "\0" * MANY,
    "r $ " + "fast 1.000000001 " * 199 + "left",
    "r $ " + "9" * MANY + " left",
    "beat " + "9" * MANY,
    "x = left\n" + "x = x || x\n" * 500 + "r $ x",
    "r $ repeat " * 500,
    "r $ " + "repeat 1000000000 " * 35 + "forward",
    "r $ " + "slow 1000000000 " * 35 + "fast 100 forward",
    "r $ " + "fast 1000000000 " * 35 + "rest",
    "x = left right\n" + "x = x || x\n" * 30 + "r $ x",
    "x = forward\n" + ("x = " + " || ".join(["x"] * 200) + "\n") * 150 + "r $ x",
    "r $ " + " ".join(f"fast 1.{odd:07} left" for odd in range(1_500)),
    "a (m) = m m\nr $ " + "a " * 400 + "forward",
    "p0 (m) = reverse m\n" + "".join(f"p{k + 1} (m) = p{k} p{k} m\n" for k in range(100)) + "r $ p100 left",
    "p0 (m) = m\n" + "".join(f"p{k + 1} (m) = p{k} m\n" for k in range(2_000)) + "r $ p2000 left",
    "p0 a = scale a left\n" + "".join(f"p{k + 1} a = p{k} a p{k} a*{k + 2}\n" for k in range(200)) + "r $ p200 1",
    "s0 n = scale n left\n" + "".join(f"s{k + 1} n = s{k} n*n\n" for k in range(100)) + "r $ s100 3",
    "p0 (m) = m || m\n" + "".join(f"p{k + 1} (m) = p{k} p{k} m\n" for k in range(20)) + "r $ p20 left",
    "r $ " + "if near left else " * 2_000 + "left",
    "r $ " + "if near " * 2_000 + "left",
    "r $ " + "n*" * 3_000 + "3 left",
    "f " + "n " * 2_000 + "= left",
    "f " + "(m" * 2_000 + "= left",
    *(f"r $ {word} {'3*' * 1_000}3 left" for word in ("slow", "fast", "scale", "fit", "ramp 0")),
    "r $ slow " + "3*" * 3_000 + "3 left",
    "r $ accumulate (" + " ".join(f"fast 1.{odd:07} left" for odd in range(1_000)) + ")",
    "".join(f"r $ {f'fast 1.{odd:028} ' * 10}left\n" for odd in range(1_000)),
]


@pytest.mark.parametrize("text", WORST, ids=lambda text: f"{text[:20]!r}…")
def test_the_worst_inputs_have_errors_and_nothing_worse(text: str) -> None:
    assert not use(text, len(text) // 2).ok


def test_a_line_of_ten_megabytes_is_one_error() -> None:
    text = "r $ " + "left " * 1_999_999
    analysis = analyze(text)
    assert hover(analysis, len(text) // 2) is None
    assert format_text(text) == text.rstrip() + "\n"
    (diagnostic,) = analysis.diagnostics
    assert diagnostic.message == "this statement has more than 100,000 characters: split it up"
