"""A score is written without anything that its reader already has."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import pytest

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.score import score_json
from improv_core.score.score import Score
from improv_core.score.score_json import LackingError, RowsRead, RowsWritten, from_json, to_json
from improv_core.score.walk import walk
from improv_core.session.state import MAX_SENT, PartEditions

PROGRAM = (
    "".join(f"x{line} = forward left {line + 1} right\n" for line in range(100)) + "anna $ x1 x2 x3\nbert $ x4 x5\n"
)


class Line:
    """A writer and a reader, with JSON in between."""

    def __init__(self) -> None:
        self.editions, self.writer, self.reader, self.generation = PartEditions(), RowsWritten(), RowsRead(), 0

    def write(self, analysis: Analysis) -> dict[str, Any]:
        self.generation += 1
        self.editions, score = self.editions.number(score_of(analysis), self.generation)
        return json.loads(json.dumps(to_json(score, self.writer)))  # type: ignore[no-any-return]

    def read(self, data: dict[str, Any]) -> Score:
        return from_json(data, self.reader)


def check(read: Score, analysis: Analysis) -> None:
    """Check that the score that was read is the one that was written, down to the places in the text."""
    assert read.text == analysis.text
    assert read.offsets == dict(zip(analysis.statement_ids, analysis.offsets, strict=True))
    assert list(read.parts) == list(analysis.robots)
    for robot, movement in analysis.robots.items():
        assert list(walk(read.parts[robot].movement)) == list(walk(movement))


def edited(analysis: Analysis, before: str, after: str) -> Analysis:
    at = analysis.text.index(before)
    return analysis.edited(at, at + len(before), after)


def test_only_the_changes_of_an_edit_are_written() -> None:
    line, analysis = Line(), analyze(PROGRAM)
    check(line.read(line.write(analysis)), analysis)
    analysis = edited(analysis, "x4 x5", "x4 left x5")
    data = line.write(analysis)
    assert data["parts"]["anna"] is None
    assert len(data["movements"]) < 10
    check(line.read(data), analysis)


def test_words_that_have_moved_are_written_though_the_part_stays_the_same() -> None:
    line, analysis = Line(), analyze(PROGRAM)
    first = line.read(line.write(analysis))
    analysis = edited(analysis, "x4 x5", "x4    x5 # slowly")
    data = line.write(analysis)
    check(second := line.read(data), analysis)
    assert second.parts["bert"].editions == first.parts["bert"].editions


def test_a_reader_that_missed_a_score_asks_for_a_whole_one() -> None:
    line, analysis = Line(), analyze(PROGRAM)
    line.read(line.write(analysis))
    line.write(edited(analysis, "x4 x5", "x4 left x5"))  # lost
    analysis = edited(analysis, "x4 x5", "x4 right x5")
    with pytest.raises(LackingError):
        line.read(line.write(analysis))
    line.writer = RowsWritten()
    check(line.read(line.write(analysis)), analysis)


def test_a_part_that_nobody_has_sent_is_lacking() -> None:
    data = Line().write(analyze(PROGRAM))
    data["parts"]["anna"] = None
    with pytest.raises(LackingError):
        from_json(data, RowsRead())


def test_after_an_unreadable_score_the_next_one_has_to_be_whole() -> None:
    """Its writer counts on it: a part that is the same as before must not be the part before that."""
    line, first = Line(), analyze(PROGRAM)
    second = edited(first, "x4 x5", "x4 left x5")
    line.read(line.write(first))
    line.read(line.write(second))
    back = line.write(first)
    assert back["movements"] == []
    with pytest.raises(ValueError, match="not above zero"):
        line.read({**back, "tempo": "0"})
    with pytest.raises(LackingError):
        line.read(line.write(edited(first, "x4 x5", "x4 x5 # again")))
    line.writer = RowsWritten()
    check(line.read(line.write(first)), first)


def test_the_movements_that_are_kept_do_not_grow_forever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(score_json, "MAX_KNOWN", most := 500)
    line = Line()
    for turn in range(2, 20):
        line.writer = line.writer.renewed()
        analysis = analyze("".join(f"x{name} = forward left {turn}\nr $ x{name}\n" for name in range(20)))
        check(line.read(line.write(analysis)), analysis)
    assert len(line.reader.movements) < 2 * most


def numbered(programs: Sequence[str]) -> tuple[PartEditions, list[Score]]:
    """The editions after these programs have been saved, and their scores with the editions of their parts."""
    editions, scores = PartEditions(), []
    for generation, program in enumerate(programs, 1):
        editions, score = editions.number(score_of(analyze(program)), generation)
        scores.append(score)
    return editions, scores


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        ("x = forward left\nr $ x\n", "# before\nr $ forward    left # after\n", True),
        ("r $ forward left\n", "r $ left forward\n", False),
    ],
)
def test_parts_that_move_a_robot_alike_have_the_same_edition(one: str, other: str, alike: bool) -> None:
    _, (first, second) = numbered([one, other])
    assert (first.parts["r"].editions == second.parts["r"].editions) is alike


def test_a_part_is_compared_with_all_that_may_play() -> None:
    editions, scores = numbered(["r $ forward\n", "r $ left\n", "r $ forward\n"])
    first, second, third = (score.parts["r"].editions for score in scores)
    assert first == third
    _, again = editions.plays(2).plays(3).number(score_of(analyze("r $ left\n")), 4)
    assert again.parts["r"].editions not in (first, second)


def test_saves_that_wait_for_the_end_of_a_dance_do_not_pile_up() -> None:
    saves = [f"anna $ repeat left\nbert $ repeat {times} forward\n" for times in range(1, 3 * MAX_SENT)]
    editions, (first, *_, last) = numbered(saves)
    assert first.parts["anna"].editions == last.parts["anna"].editions
    assert len(editions.sent) == MAX_SENT
    _, again = editions.number(score_of(analyze("bert $ repeat 1 forward\n")), 3 * MAX_SENT)
    assert again.parts["bert"].editions == first.parts["bert"].editions
