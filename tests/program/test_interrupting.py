"""Statements that are interrupted while others are understood have the same analysis as without an interruption."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count, cycle

import pytest
from greenlet import getcurrent, greenlet
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import Analysis, analyze, unread
from improv_core.program.compiler import score_of
from improv_core.slices import on_checkpoint
from improv_core.syntax import parser
from tests.heavy import HEAVY
from tests.program.test_conformance import CASES
from tests.program.test_editing import PIECES, seen

TEXTS = list(dict.fromkeys(case["program"] for case in CASES))


@contextmanager
def nothing_parsed_yet(most: int = parser.MAX_KEPT) -> Iterator[parser.Kept]:
    """Empty the cache of statements' trees, so that both works have to make them."""
    before, parser._KEPT = parser._KEPT, parser.Kept(most)
    try:
        yield parser._KEPT
    finally:
        parser._KEPT = before


def in_turns(works: list[Callable[[], Analysis]], every: int) -> list[Analysis]:
    """Return the results of several works that take turns: each is interrupted at every `every`-th checkpoint."""
    passed, switches = count(1), count()
    made: dict[int, Analysis] = {}

    def begin(place: int) -> greenlet:
        return greenlet(lambda: made.update({place: works[place]()}))

    def interrupt() -> None:
        current = getcurrent()
        if isinstance(current, greenlet) and current.parent and not next(passed) % every:
            next(switches)
            current.parent.switch()

    running = [begin(place) for place in range(len(works))]
    on_checkpoint(interrupt)
    try:
        while running := [each for each in running if not each.dead]:
            for each in running:
                each.switch()
    finally:
        on_checkpoint(None)
    assert next(switches)
    return [made[place] for place in range(len(works))]


def understood(text: str) -> Analysis:
    analysis = unread(text).settled()
    assert analysis.diagnostics is analysis.diagnostics
    return analysis


def test_every_program_of_the_suite_is_understood_in_slices() -> None:
    expected = {text: seen(analyze(text)) for text in TEXTS}
    for text, other, every in zip(TEXTS, [*TEXTS[1:], TEXTS[0]], cycle([1, 2, 7]), strict=False):
        texts = [text, other, text]
        with nothing_parsed_yet():
            found = in_turns([lambda text=text: understood(text) for text in texts], every)  # type: ignore[misc]
        assert [seen(each) for each in found] == [expected[each] for each in texts]


@pytest.mark.parametrize("link", ["{} left", "(left {}) || left", "until cue {}", "slow 2 {} left", "[{} left]"])
def test_a_definition_costs_as_much_however_many_open_ones_it_rests_on(link: str) -> None:
    def steps(definitions: int) -> int:
        chain = "".join(f"x{number + 1} = {link.format(f'x{number}')}\n" for number in range(definitions))
        passed: list[None] = []
        on_checkpoint(lambda: passed.append(None))
        try:
            analyze(f"room 6 4\nx0 = until near repeat forward\n{chain}r $ x{definitions}\n")
        finally:
            on_checkpoint(None)
        return len(passed)

    few, more, most = map(steps, (10, 30, 50))
    assert most - more <= 1.1 * (more - few)


@given(st.lists(st.sampled_from(PIECES), max_size=40).map("".join), st.integers(1, 5))
def test_any_text_is_understood_in_slices(text: str, every: int) -> None:
    texts = [f"r $ left up\n{text}", f"{text}\nr $ left up"]
    with nothing_parsed_yet():
        found = in_turns([lambda text=text: understood(text) for text in texts], every)  # type: ignore[misc]
    assert [seen(each) for each in found] == [seen(analyze(each)) for each in texts]


def test_a_statement_that_two_parse_at_once_is_kept_once() -> None:
    text = "r $ " + "up * " * 60 + "\n"
    with nothing_parsed_yet(most=2 * len(text)) as kept:
        one, other = in_turns([lambda: understood(text)] * 2, 5)
        assert one.statements[0] is other.statements[0]
        assert kept.characters == len(text.rstrip())


def test_deep_programs_are_understood_while_others_are_interrupted() -> None:
    deep = "r $ " + "(" * 199 + "up" + ")" * 199 + "\n"
    found = in_turns([lambda: understood(deep), lambda: understood(HEAVY["3,000 parameters"])] * 2, 3)
    assert [each.ok for each in found] == [True] * 4


@pytest.mark.parametrize(
    "work",
    [
        lambda: parser.parse_statement("r $ " + "up " * 20_000),
        lambda: parser.parse_statement("r $ " + "up || " * 2_000 + "up"),
        lambda: parser.parse_statement("r $ " + "up 3 * " * 2_000),
        partial(score_of, analyze(" ".join(f"r{robot}" for robot in range(200)) + " $ up")),
    ],
    ids=["right", "voices", "wrong", "score"],
)
def test_one_long_statement_has_checkpoints(work: Callable[[], object]) -> None:
    passed: list[None] = []
    on_checkpoint(lambda: passed.append(None))
    try:
        work()
    finally:
        on_checkpoint(None)
    assert len(passed) >= 20
