"""Diagnostics of robots that meet, or hit something: the marked words, the severities, and the fixes."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import Severity, applied
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.room import RoomReport
from improv_core.robots.config import read_robots
from improv_core.score.encounters import RoomResults
from improv_core.score.meetings import would_meet
from improv_core.score.prediction import Predict
from improv_core.score.score import Score
from improv_core.stage import dry_run
from improv_core.text import Span
from tests.program import drawing


def check(expected: str, robots: str = "") -> None:
    drawing.check(expected, robots=robots, in_room=True)


def report(program: str, robots: str = "") -> RoomReport:
    found = room.check(analyze(program, read_robots(robots)))
    assert found
    return found


CROSSING = "ada at 0 0\nbo at 1 -1 facing 90\n"
"""Their paths cross if both go forward."""


def test_a_meeting_is_at_the_word_of_the_robot_that_is_named_later() -> None:
    check("""
        bo at 1 -1 facing 90
        ada at 0 0
        ada $ rest forward
        bo $ rest forward left
                  ^^^^^^^ meets: `ada` and `bo` meet at beat 2.29, as near as 0 m: keep them 0.6 m apart
    """)


def test_a_meeting_is_at_the_other_robots_word_if_the_later_one_stands() -> None:
    check("""
        ada at 0 0
        bo at 2 0
        ada $ forward
              ^^^^^^^ meets: `ada` and `bo` meet at beat 1.7, as near as 0 m: keep them 0.6 m apart
        bo $ rest
    """)


def test_of_several_words_the_first_that_moves_the_robot_is_marked() -> None:
    check("""
        ada at 0 0
        bo at 2 0
        step = rest || forward
        ada $ [rest rest] || step || rest
                             ^^^^ meets: `ada` and `bo` meet at beat 1.7, as near as 0 m: keep them 0.6 m apart
    """)


@pytest.mark.parametrize(
    ("program", "marked"),
    [
        (f"{CROSSING}ada $ forward\nbo $ forward", ("forward", 51, "`ada` does this then", 38)),
        (f"{CROSSING}ada bo $ forward", ("forward", 41, "", 0)),
        ("ada at 0 0\nbo at 2 0\nada $ forward", ("forward", 27, "`bo` stands then", 11)),
    ],
)
def test_the_other_robots_word_is_related(program: str, marked: tuple[str, int, str, int]) -> None:
    (diagnostic,) = report(program).diagnostics
    word, at, message, elsewhere = marked
    assert diagnostic.span == Span(at, at + len(word))
    assert [(each.message, each.span.start) for each in diagnostic.related] == (
        [(message, elsewhere)] if message else []
    )


def test_a_meeting_at_beat_0_is_at_the_line_that_places_the_later_robot() -> None:
    check(
        """
        bo at 0.5 0
        ^^^^^^^^^^^ meets: `ada` and `bo` start 0.5 m apart: place them at least 0.6 m apart
        ada $ rest
        bo $ rest
    """,
        "[robots]\nada.start = {}\nbo.start = { x = 7 }",
    )
    check("""
        bo at 0.5 0
        ada at 0 0
        ^^^^^^^^^^ meets: `ada` and `bo` start 0.5 m apart: place them at least 0.6 m apart
        ada bo $ rest
    """)
    check(
        """
        ada $ rest
        bo $ rest
        ^^ meets: `ada` and `bo` start 0.5 m apart: place them at least 0.6 m apart
        bo $ forward
    """,
        "[robots]\nada.start = {}\nbo.start = { x = 0.5 }",
    )
    check("""
        ada bo at line 0.5985
        ^^^^^^^^^^^^^^^^^^^^^ meets: `ada` and `bo` start 0.599 m apart: place them at least 0.6 m apart
    """)


def test_a_robot_on_the_ground_is_reported_at_the_word_that_takes_it_down() -> None:
    check("""
        ada $ up forward fast 2 (down down)
                                      ^^^^ hits: `ada` is on the ground at beat 3.5: let it go up first
    """)


def test_a_hit_is_at_the_robots_own_word_or_line() -> None:
    check(
        """
        room 6 4
        ada at 2.8 0 facing 90
        ^^^^^^^^^^^^^^^^^^^^^^ hits: `ada` starts too near to the edge of the floor: place it at least 0.3 m away
        bo at 9 9
        ^^^^^^^^^ hits: `bo` starts outside the floor: place it at least 0.3 m inside
        ada $ forward
        cy $ forward right
             ^^^^^^^ hits: `cy` hits circle 1 at beat 1.84: keep it 0.3 m away
    """,
        "[robots]\nada.start = {}\nbo.start = {}\ncy.start = { x = -1, y = 1 }\n"
        "[world]\ncircles = [{ x = 1, y = 1.5, radius = 0.3 }]",
    )
    outside = report("ada at 4 0", "[world]\nsize = [6, 6]\ncircles = [{ x = 4, y = 0, radius = 0.5 }]")
    assert [each.message for each in outside.diagnostics] == [
        "`ada` starts too near to circle 1: place it at least 0.3 m away",
        "`ada` starts outside the floor: place it at least 0.3 m inside",
    ]


def test_meetings_of_unplaced_robots_are_information() -> None:
    facing = "ada $ right forward\nbo $ left forward\n"
    assert [each.severity for each in report(facing).diagnostics] == [Severity.INFORMATION]
    assert [each.severity for each in report("ada at 0 0\n" + facing).diagnostics] == [Severity.INFORMATION]
    placed = "ada at 0 0\nbo at 0 -3\n" + facing
    assert [each.severity for each in report(placed).diagnostics] == [Severity.WARNING]
    formation = '[formation]\nshape = "line"\ndistance = 3'
    assert [each.severity for each in report(facing, formation).diagnostics] == [Severity.WARNING]
    assert [each.severity for each in report("ada $ forward", "[world]\nsize = [4, 4]").diagnostics] == [
        Severity.INFORMATION
    ]


@pytest.mark.parametrize(
    "program",
    ["ada bo at 0 0\n", "ada at 0 0\nada $ forward\n", "ada at 0 0\nbo at 0 0\nada $ forwrad\n", "walk = forward\n"],
)
def test_a_program_with_errors_or_one_robot_is_not_checked(program: str) -> None:
    assert room.check(analyze(program)) is None


@pytest.mark.parametrize(
    ("program", "checked"),
    [
        ("ada bo $ repeat choose (left right)", "checked to the end of beat 1,000"),
        ("ada bo $ forward", "checked to the end of beat 1, after which everything has ended or repeats"),
        (
            "ada bo $ until near repeat forward",
            "checked to the end of beat 4, after which everything has ended or repeats, "
            "assuming that no sense is ever true",
        ),
    ],
)
def test_the_report_states_what_was_checked(program: str, checked: str) -> None:
    assert str(report(program)) == checked


def predicting(program: str, predict: Predict, robots: str = "") -> RoomReport:
    found = room.check(analyze(program, read_robots(robots)), predict=predict)
    assert found
    return found


def test_senses_are_decided_as_predicted() -> None:
    """Anna turns in front of the wall. Where nothing is placed, or nothing decides, nobody is asked."""
    program = "room 6 4\nanna $ repeat (until near (repeat scale 1/2 forward) left)\n"
    known = predicting(program, dry_run.predict)
    assert (known.diagnostics, str(known)) == (
        (),
        "checked to the end of beat 120, with what robots sense in the simulator",
    )
    assert [each.code for each in report(program).diagnostics] == ["hits"]
    for other in ("room 6 4\nada $ until cue repeat scale 1/8 forward\n", "ada bo $ until near repeat forward\n"):
        assert "assuming that no sense is ever true" in str(predicting(other, dry_run.predict))


@pytest.mark.parametrize(
    ("program", "marked"),
    [
        ("room 2m 2m\nada $ repeat (until near (repeat forward) left)\n", ["near"]),
        ("room 2m 2m\nwaits = pause near forward\nada $ repeat waits\n", ["near"]),
        ("room 4m 3m\nada $ repeat (until near (repeat forward 50cm) left 135deg)\n", ["near"]),
        ("room 2m 2m\nada $ repeat (if near left else right)\n", []),
        ("room 9m 9m\nada $ repeat (until near (repeat forward) left)\n", []),
        ("room 2m 2m\nada at 0.3 0\nada $ repeat 4 (until near forward forward 10cm)\n", []),
    ],
)
def test_a_robot_that_a_sense_keeps_in_its_place_is_reported(
    program: str, marked: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dry_run, "LONGEST", 20.0)
    found = [each for each in predicting(program, dry_run.predict).diagnostics if each.code == "may-stall"]
    assert [program[slice(*each.span)] for each in found] == marked
    assert all(each.message.startswith("`near` keeps `ada` in its place all the time") for each in found)


SENSING_CROSSING = "room 20 20\nada at -2 0\nbo at 0 -2 facing 90\nbo $ forward forward\n"


@pytest.mark.parametrize(
    "lines",
    [
        "ada $ until bump (forward forward)\n",
        "ada $ forward forward\ncleo at 5 5\ncleo $ until near repeat forward 1m\n",
    ],
)
def test_a_meeting_that_was_predicted_has_a_fix(lines: str) -> None:
    program = SENSING_CROSSING + lines
    (meeting,) = (each for each in predicting(program, dry_run.predict).diagnostics if each.code == "meets")
    (fix,) = meeting.fixes
    assert fix.title == "Start ada 1 beat later"
    after = predicting(applied(program, fix.edits), dry_run.predict)
    assert "meets" not in [each.code for each in after.diagnostics]


def test_messages_mention_what_a_prediction_assumes() -> None:
    program = "room 6 4\nada $ until cue (until bump repeat scale 1/4 forward) forward\n"
    (diagnostic,) = predicting(program, dry_run.predict).diagnostics
    assert diagnostic.message.startswith("`ada` hits the edge of the floor at beat 6.4 if no other sense holds: ")


def test_messages_mention_assumed_senses() -> None:
    program = "ada at 0 0\nbo at 9 0\nada $ until near repeat forward\n"
    (diagnostic,) = report(program, "[world]\nmargin = 1").diagnostics
    start = "`ada` and `bo` meet at beat 4.7 if no sense holds, as near as 1 m"
    assert diagnostic.message == f"{start}: keep them 1.6 m apart"


def fixed(program: str) -> dict[str, str]:
    """Return the fixes of the first diagnostic, and the program after each."""
    (diagnostic, *_) = report(program).diagnostics
    return {fix.title: applied(program, fix.edits) for fix in diagnostic.fixes}


@pytest.mark.parametrize(
    ("before", "title", "after"),
    [
        (
            f"{CROSSING}ada $ forward\nbo $ forward\n",
            "Start bo 1 beat later",
            f"{CROSSING}ada $ forward\nbo $ rest forward\n",
        ),
        (f"{CROSSING}ada bo $ forward\n", "Start bo 1 beat later", f"{CROSSING}bo $ rest\nada bo $ forward\n"),
        (
            f"{CROSSING}ada bo $ rest\n---\nbo ada $ forward\n",
            "Start bo 1 beat later",
            f"{CROSSING}ada bo $ rest\n---\nbo $ rest\nbo ada $ forward\n",
        ),
        (
            f"{CROSSING}ada $ slow 2 forward\nbo $ slow 2 forward || rest rest rest\n",
            "Start bo 1 beat later",
            f"{CROSSING}ada $ slow 2 forward\nbo $ rest\nbo $ slow 2 forward || rest rest rest\n",
        ),
        (
            f"{CROSSING}ada $ slow 5 forward\nbo $ slow 5 forward\n",
            "Start bo 3 beats later",
            f"{CROSSING}ada $ slow 5 forward\nbo $ repeat 3 rest slow 5 forward\n",
        ),
        (
            "ada bo at line 1 # near\nada $ rest\nbo $ strafeleft",
            "Change to line 2.6",
            "ada bo at line 2.6 # near\nada $ rest\nbo $ strafeleft",
        ),
        ("a b c d e f at circle 0.2\n", "Change to circle 0.6", "a b c d e f at circle 0.6\n"),
    ],
)
def test_a_fix_keeps_them_apart(before: str, title: str, after: str) -> None:
    fixes = fixed(before)
    assert fixes[title] == after
    for text in fixes.values():
        left = report(text)
        assert not [
            each for each in left.diagnostics if each.message[:12] == report(before).diagnostics[0].message[:12]
        ]


def test_no_fix_is_offered_if_none_helps() -> None:
    assert fixed("ada at 0 0\nbo at 1 0\nada $ repeat forward\n") == {}


def test_after_an_edit_the_report_is_that_of_the_whole_program() -> None:
    analysis: Analysis = analyze(f"{CROSSING}ada $ slow 5 forward\nbo $ slow 5 forward\ncy at 9 9\n")
    first = room.check(analysis)
    assert first
    edited = analysis.edited(0, 0, "# one more line\ndan at 5 5\n")
    again, whole = room.check(edited, first.known), room.check(edited)
    assert again
    assert whole
    assert again.diagnostics == whole.diagnostics


def test_fixes_that_did_not_help_are_tried_again_once_one_of_the_two_moves_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried = []

    def notice(score: Score, robots: tuple[str, str], known: RoomResults) -> bool:
        tried.append(robots)
        return would_meet(score, robots, known)

    monkeypatch.setattr(room, "would_meet", notice)
    analysis = analyze(f"{CROSSING}ada $ slow 5 forward\nbo $ slow 5 forward\ncy at 9 9\n")
    known, counts = None, []
    for edit in ("", "cy $ left\n", "ada $ left\n"):
        tried.clear()
        analysis = analysis.edited(len(analysis.text), len(analysis.text), edit)
        found = room.check(analysis, known)
        assert found
        known = found.known
        counts.append(len(tried))
    assert counts == [5, 1, 5]  # 1 and 2 beats, each for both robots, and 3 for one


def test_many_meetings_are_counted() -> None:
    names = " ".join(f"r{number}" for number in range(20))
    found = report(f"{names} at line 0.001\n").diagnostics
    assert len(found) == room.MAX_MARKED + 1
    assert [each.message for each in found if each.code == "more-hints"] == [
        "fix what is marked first: 90 more problems of this kind aren't marked yet"
    ]
