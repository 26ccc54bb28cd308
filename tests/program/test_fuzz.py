"""Nothing that anybody can write raises an error or hangs. How long it takes: `python -m tests.benchmarks worst`.

By hand: IMPROV_FUZZ_SECONDS=600 pytest -s tests/program/test_fuzz.py
"""

from __future__ import annotations

import gc
import os
import random
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from improv_core.ide.completion import complete
from improv_core.ide.hover import hover
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.syntax.formatter import format_text
from improv_core.syntax.vocabulary import WORDS

SECONDS = float(os.environ.get("IMPROV_FUZZ_SECONDS", "6"))
"""How long random programs are tried."""
LIMIT = 600
"""Seconds after which a test counts as hanging, on a busy machine."""
pytestmark = pytest.mark.timeout(2 * SECONDS + LIMIT)

EXAMPLES = [path.read_text(encoding="utf-8") for path in sorted(Path("examples").glob("*.improv"))]
PIECES = [*WORDS, "x", "y", "größe", "=", "$", "(", ")", "[", "]", "||", "|", "\n", "\r\n", "\r", " ", "\t", "# ", "2"]
PIECES += [
    "1/0",
    "3/2",
    "-1",
    "9" * 40,
    "1e9",
    ".5",
    "😀",
    "\0",
    "\f",
    "\u2028",
    "\ufeff",
    "\ud800",
    "\\",
    '"',
    "{",
    "x = ",
]
PIECES += ["r $ ", "beat 60\n", "repeat 1000000000 ", "fast 1.000000001 ", "(" * 30, "[" * 30, ")" * 30]


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
    """Thousands of kept statements make a collection of garbage slow, whichever program it happens to fall on."""
    gc.disable()
    yield
    gc.enable()


def use(text: str, place: int) -> Analysis:
    """Everything an editor and the command line ask of a program."""
    analysis = analyze(text)
    assert analysis.diagnostics is not None
    hover(analysis, place)
    complete(analysis, place)
    compiled(analysis, 100)
    format_text(text)
    return analysis


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
    print(f"{source.__name__}: {count} programs")


WORST = [
    "r $ " + "(" * 100_000,
    "r $ " + "(" * 100_000 + "left" + ")" * 100_000,
    "r $ " + "reverse " * 100_000 + "left",
    "r $ " + "[left || " * 100_000,
    ")" * 100_000,
    "x = " * 20_000,
    "$" * 100_000,
    "\0" * 100_000,
    "r $ " + "fast 1.000000001 " * 199 + "left",
    "r $ " + "9" * 10_000 + " left",
    "beat " + "9" * 10_000,
    "x = left\n" + "x = x || x\n" * 1_000 + "r $ x",
    "r $ repeat " * 500,
]


@pytest.mark.parametrize("text", WORST, ids=lambda text: f"{text[:20]!r}…")
def test_the_worst_inputs_are_wrong_and_no_more(text: str) -> None:
    assert not use(text, len(text) // 2).ok


def test_a_line_of_ten_megabytes() -> None:
    text = "r $ " + "left " * 2_000_000
    (diagnostic,) = use(text, len(text) // 2).diagnostics
    assert diagnostic.message == "write shorter statements: this one has more than 100,000 characters"
