"""The replay of a score from what robots sensed is the same as what a stage has them play."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import islice

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score import replay
from improv_core.score.movement import Exact
from improv_core.score.path import pose_at
from improv_core.score.performer import Performer
from improv_core.score.projection import BASE
from improv_core.score.replay import Replay
from improv_core.score.score import Score
from improv_core.score.walk import Moment

TURNER = "r $ repeat (if near left else forward)\n"
PROGRAMS = [
    TURNER,
    "r $ repeat (until near (repeat forward) left)\n",
    "r $ repeat (pause near (forward left) || if bump up else down)\n",
    "r $ repeat (if near nothing else fast 3 (left forward))\nnothing = 0\n",
    "r $ until near (repeat choose [left until bump (repeat 3 forward)])\n",
]


def made(program: str) -> Score:
    return score_of(analyze(program))


def sensing(program: str, *near: tuple[Exact, bool | None]) -> Replay:
    """The replay of `r` if `near` has these values from these beats on."""
    replayed = Replay(made(program))
    for beat, value in near:
        replayed.sense("r", "near", value, beat)
    return replayed


def words(replayed: Replay, start: Exact, program: str, count: int = 4, body_part: str | None = None) -> str:
    """`2 left, 3 left`."""
    found = []
    for moment in replayed.moments("r", start, body_part):
        word = ""
        for source in moment.sources[-1:]:
            start, end = source.span.shifted(replayed.score.offsets[source.statement])
            word = program[start:end]
        found.append(f"{float(moment.start):g} {word or 'stands'}")
        if len(found) == count:
            break
    return ", ".join(found)


def test_the_latest_sense_stays() -> None:
    replayed = sensing(TURNER, (0, False), (2, True))
    assert words(replayed, 0, TURNER) == "0 forward, 1 forward, 2 left, 3 left"


def test_a_robot_stands_without_words_while_its_sense_is_silent() -> None:
    replayed = sensing(TURNER, (0, False), (2, None))
    assert words(replayed, 1, TURNER, 3) == "1 forward, 2 stands, 3 stands"
    assert not any(any(moment.velocity) for moment, _ in zip(replayed.moments("r", 2), range(3), strict=False))


BODY = "r is puppet\nr $ repeat (head (if near left else right) || forward)\n"


def test_a_body_part_plays_what_senses_decide_and_so_does_its_base() -> None:
    replayed = sensing(BODY, (0, False), (2, True))
    assert words(replayed, 1, BODY, 3, "head") == "1 right, 2 left, 3 left"
    assert words(replayed, 1, BODY, 3, BASE) == "1 forward, 2 forward, 3 forward"
    turning = [moment.velocity.yaw for moment, _ in zip(replayed.moments("r", 1, "head"), range(2), strict=False)]
    assert turning == [-1, 1]
    assert not any(moment.velocity.yaw for moment, _ in zip(replayed.moments("r", 1), range(3), strict=False))


def test_a_body_part_plays_on_when_its_part_does() -> None:
    before = sensing(BODY, (0, False), (2, True))
    replayed = Replay(made("# more\n" + BODY), 5, before)
    assert words(replayed, 4, "# more\n" + BODY, 2, "head") == "4 left, 5 left"


def test_each_body_part_plays_its_own_words_and_rests_while_others_move() -> None:
    program = "r is puppet\nr $ head (left right) left_arm to high forward\n"
    replayed = Replay(made(program))
    assert list(replayed.body_parts("r")) == ["head", "left_arm"]
    assert words(replayed, 0, program, 3, "head") == "0 left, 1 right, 2 stands"
    assert words(replayed, 0, program, 3, "left_arm") == "0 stands, 2 to high, 3 stands"
    assert words(replayed, 0, program, 4, BASE) == "0 stands, 2 stands, 3 forward"
    assert words(replayed, 0, program, 4) == "0 left, 1 right, 2 to high, 3 forward"


def test_thousands_of_edges_are_remembered() -> None:
    """The first senses still count, though most of the performance is forgotten."""
    program = "r $ until near (repeat forward)\nr $ repeat (if near left else forward)\n"
    replayed = sensing(program, (0, False))
    for edge in range(2 * replay.MAX_PAST):
        replayed.sense("r", "near", bool(edge % 2 == 0), Fraction(edge + 6, 4))
    last = Fraction(2 * replay.MAX_PAST + 5, 4)
    assert words(replayed, 0, program, 1) != "0 forward"
    assert words(replayed, int(last) + 1, program, 1) == f"{int(last) + 1} forward"
    now = replayed.now("r", last)
    assert now
    assert replayed.line("r", last) == (now.sources[0].statement, 2)
    assert replayed.pose("r", 0) is None
    assert replayed.pose("r", last) is not None


def test_decisions_stay_when_a_part_plays_on() -> None:
    program = "r $ until near (repeat forward) repeat left\ns $ repeat forward\n"
    before = sensing(program, (0, False), (2, True), (3, False))
    score = before.score
    later = replace(score, parts={**score.parts, "s": replace(score.parts["s"], begins=5)})
    assert words(Replay(later, 5, before), 5, program, 2) == "5 left, 6 left"
    begun = replace(score, parts={**score.parts, "r": replace(score.parts["r"], begins=5)})
    replayed = Replay(begun, 5, before)
    replayed.sense("r", "near", False, 5)
    assert words(replayed, 5, program, 2) == "5 forward, 6 forward"


def test_the_words_of_a_part_that_plays_on_are_those_of_the_program_as_it_is_read_again() -> None:
    program = "walk = repeat forward\nr $ until near walk repeat left\ns $ forward\n"
    before = sensing(program, (0, False), (2, True))
    again = "# more\n" + program.replace("s $ forward", "s $ left")
    replayed = Replay(made(again), 5, before)
    assert words(replayed, 1, again, 4) == "1 forward, 2 until, 3 left, 4 left"
    line = replayed.line("r", 4)
    assert line
    assert (again[replayed.score.offsets[line[0]] :][:3], line[1]) == ("r $", 0)


def test_after_a_jump_no_sense_was_true_before() -> None:
    program = "r $ until not near (repeat forward) repeat left\n"
    replayed = Replay(made(program), 3)
    replayed.sense("r", "near", True, 3)
    assert words(replayed, 0, program, 5) == "0 until, 1 left, 2 left, 3 left, 4 left"


@pytest.mark.parametrize("beat", [0, Fraction(1, 2), 3])
def test_now_is_the_moment_at_a_beat(beat: Exact) -> None:
    replayed = Replay(made("r $ left right\ns $ repeat 8 forward\n"))
    now = replayed.now("r", beat)
    assert (now and (now.start, now.start + now.duration)) == (None if beat == 3 else (0, 1) if not beat else (beat, 1))


EDGES = st.lists(
    st.tuples(st.fractions(0, 12, max_denominator=8), st.sampled_from(["near", "bump"]), st.booleans()), max_size=30
)


@given(st.sampled_from(PROGRAMS), EDGES, st.fractions(0, 14, max_denominator=8))
def test_the_performance_is_that_of_a_performer(
    program: str, edges: list[tuple[Fraction, str, bool]], start: Fraction
) -> None:
    """A performance in steps, forked at each edge, and read from any beat, is the same as one performer's at once."""
    score, edges = made(program), sorted(edges, key=lambda edge: edge[0])
    replayed = Replay(score)
    for sense in ("near", "bump"):
        replayed.sense("r", sense, False, 0)
    for beat, sense, value in edges:
        replayed.sense("r", sense, value, beat)
        next(replayed.moments("r", beat), None)
    end = 16
    assert _parts(replayed.moments("r", start), start, end) == _parts(_at_once(score, edges), start, end)


def _at_once(score: Score, edges: list[tuple[Fraction, str, bool]]) -> list[Moment]:
    performer, moments = Performer(score.parts["r"].movement), []
    values: dict[str, bool | None] = {"near": False, "bump": False}
    beats = sorted({beat for beat, _, _ in edges})
    while performer.beat < 16:
        values |= {sense: value for beat, sense, value in edges if beat == performer.beat}
        performer.settle(values.get)
        if performer.is_over:
            break
        until = min([performer.until, *(beat for beat in beats if beat > performer.beat)])
        assert not isinstance(until, float)
        moments.append(Moment(performer.beat, until - performer.beat, *performer.performed(values.get)))
        performer.advance(until)
    return moments


def _parts(moments: Iterable[Moment], start: Exact, end: int) -> Mapping[Fraction, object]:
    """The words that play in each 64th of a beat."""
    found: dict[Fraction, object] = {}
    for moment in moments:
        if moment.start >= end:
            break
        at = max(Fraction(-(-moment.start * 64 // 1), 64), Fraction(-(-start * 64 // 1), 64))
        while at < min(moment.start + moment.duration, end):
            found[at] = moment.velocity, moment.sources
            at += Fraction(1, 64)
    return found


@pytest.mark.parametrize("turns", [1, 10**6, 10**14])
def test_a_far_turn_plays_like_the_next_one(turns: int) -> None:
    """Nothing is performed up to there, so a page that is opened after a day takes no longer."""
    program, beat = "r $ repeat (until near (repeat 3 forward) left)\n", 4 * turns + Fraction(1, 2)
    replayed = Replay(made(program), beat)
    replayed.sense("r", "near", False, beat)
    replayed.sense("r", "near", True, beat + 1)
    played = islice(replayed.moments("r", beat), 4)
    found = [(moment.start - 4 * turns, moment.duration) for moment in played]
    assert found == [(Fraction(1, 2), Fraction(1, 2)), (1, Fraction(1, 2)), (Fraction(3, 2), Fraction(1, 2)), (2, 1)]
    assert replayed.pose("r", beat) == pose_at(replayed.score.parts["r"], beat)


def test_a_pose_that_takes_too_long_to_compute_is_unknown() -> None:
    program = "r $ repeat (until not near (repeat forward) left)\n"
    replayed = Replay(made(program), 10**6)
    assert replayed.pose("r", 10**6) is None
    assert words(replayed, 10**6, program, 1)
