"""Answers to the page on which somebody edits a program."""

from __future__ import annotations

from threading import Thread
from typing import Any

import pytest

from improv_core.ide.semantic_tokens_legend import TYPES
from improv_core.page.program_editor import MAX_PROBLEMS, PageEditor
from improv_core.program.analysis import analyze
from improv_core.protocol.editing import Analyze, Analyzed, ArrangeRobots, PlaceRobots, RoomChecked, TuneMusic
from improv_core.robots.config import read_robots
from improv_core.slices import on_checkpoint
from improv_core.storage.program_file import TEMPLATE

PAGE, OTHER = 1, 2


@pytest.fixture
def editor() -> PageEditor:
    """An editor without an improv.toml."""
    return PageEditor(read_robots(""), str)


def ask(editor: PageEditor, text: str, number: int = 1, page: int = PAGE) -> Analyzed:
    return editor.analyze(page, {"type": "analyze", "number": number, "text": text})


def colored(text: str) -> list[str]:
    """Return `word:kind` of each colored word."""
    colors, found, at = ask(PageEditor(read_robots(""), str), text)["colors"]["new"], [], 0
    for gap, length, kind in zip(colors[::3], colors[1::3], colors[2::3], strict=True):
        start, at = at + gap, at + gap + length
        found.append(f"{text[start:at]}:{TYPES[kind]}")
    return found


def test_words_have_the_colors_that_editors_give_them() -> None:
    assert colored("# 🤖\nr $ repeat 2 left\n") == [
        *("# 🤖:comment", "r:class", "$:operator", "repeat:keyword", "2:number", "left:function")
    ]


@pytest.mark.parametrize(
    ("known", "text", "change"),
    [
        (1, "r $ left\ns $ right left\n", {"first": 16, "last": 2, "new": [5, 2, 1]}),
        (1, "r $ left\n", {"first": 9, "last": 0, "new": []}),
        (0, "r $ left\n", {"first": 0, "last": 0, "new": [0, 1, 4, 1, 1, 7, 1, 4, 2]}),
        (None, "r $ left\n", {"first": 0, "last": 0, "new": [0, 1, 4, 1, 1, 7, 1, 4, 2]}),
    ],
)
def test_a_page_gets_the_colors_that_it_lacks(
    editor: PageEditor, known: int | None, text: str, change: dict[str, object]
) -> None:
    ask(editor, "r $ left\ns $ left\n")
    later: Analyze = {"type": "analyze", "number": 2, "text": text}
    assert editor.analyze(PAGE, later if known is None else {**later, "known": known})["colors"] == change


def test_a_problem_has_its_place_its_message_and_its_fixes(editor: PageEditor) -> None:
    (problem,) = ask(editor, "r $ left\ns $ forwrd\n")["problems"]
    assert (problem["start"], problem["end"], problem["line"], problem["severity"]) == (13, 19, 2, "error")
    edits = [{"start": 13, "end": 19, "text": "forward"}]
    (fix,) = problem["fixes"]
    assert fix == {"title": "Change to forward", "kind": "unknown-name: Change to forward", "edits": edits}


HEAD_ON = "ada at -2 0\nbo at 2 0 facing 180\nada bo $ forward\n"


def in_room(editor: PageEditor, text: str, number: int = 1) -> RoomChecked | None:
    return editor.check_room(PAGE, {"type": "analyze", "number": number, "text": text})


def test_a_check_of_the_room_ends_once_somebody_types(editor: PageEditor) -> None:
    """It shares its interpreter with the answers to keys."""
    text = f"{HEAD_ON}ada bo $ repeat choose (left right forward)\n"
    ask(editor, text)
    passed: list[None] = []

    def types() -> None:
        passed.append(None)
        if len(passed) == 100:
            key = Thread(target=ask, args=(editor, f"{text} ", 2))
            key.start()
            key.join()

    on_checkpoint(types)
    try:
        assert in_room(editor, text) is None
    finally:
        on_checkpoint(None)
    assert len(passed) == 100


def test_meetings_come_later_with_all_other_problems(editor: PageEditor) -> None:
    text = f"unused = left\n{HEAD_ON}"
    at_once = ask(editor, text)
    assert len(at_once["problems"]) == at_once["count"] == 1
    later = in_room(editor, text)
    assert later is not None
    meeting, hint = later["problems"]
    assert (later["number"], later["count"], hint) == (1, 2, at_once["problems"][0])
    assert (meeting["line"], meeting["severity"]) == (4, "warning")
    assert "`ada` and `bo` meet" in meeting["message"]


def test_nothing_is_added_without_meetings_or_after_an_edit(editor: PageEditor) -> None:
    apart = HEAD_ON.replace("0 facing", "3 facing")
    ask(editor, apart)
    assert in_room(editor, apart) is None
    ask(editor, HEAD_ON, number=2)
    assert in_room(editor, HEAD_ON, number=1) is None
    assert in_room(editor, HEAD_ON, number=2) is not None


def test_of_many_problems_the_first_are_listed_and_all_are_counted(editor: PageEditor) -> None:
    answer = ask(editor, "r $ x\n" * 200)
    assert (len(answer["problems"]), answer["count"]) == (MAX_PROBLEMS, 200)


def test_many_hints_hide_no_collision(editor: PageEditor) -> None:
    program = "".join(f"unused{number} = left\n" for number in range(2 * MAX_PROBLEMS)) + HEAD_ON
    ask(editor, program)
    answer = in_room(editor, program)
    assert answer
    assert [each["severity"] for each in answer["problems"]] == ["warning", *["hint"] * (MAX_PROBLEMS - 1)]
    assert [each["line"] for each in answer["problems"][1:4]] == [1, 2, 3]


def test_fixes_that_may_be_made_together_are_of_one_kind(editor: PageEditor) -> None:
    program = "unused = left\nidle = left\nr $ forwrd forwrd lef near\n"
    problems = ask(editor, program)["problems"]
    kinds = {fix["title"]: fix["kind"] for each in problems for fix in each["fixes"]}
    assert kinds["Change to forward"] == "unknown-name: Change to forward"
    assert kinds["Change to left"] != kinds["Change to forward"]
    assert kinds["Define near as rest above"] == ""  # once defined, it needs no second definition
    removals = [fix["kind"] for each in problems for fix in each["fixes"] if fix["title"].startswith("Remove")]
    assert removals == ["unused-name", "unused-name"]


def test_problems_of_the_robots_file_are_listed_until_it_is_right() -> None:
    editor = PageEditor(read_robots("[robots.r]\nprofile = 'none'\n"), str)
    (problem,) = ask(editor, "r $ left\n")["problems"]
    assert (problem["file"], problem["line"], problem["fixes"]) == ("improv.toml", 2, [])
    editor.robots = read_robots("[robots.s]\n")
    assert [each["message"] for each in ask(editor, "r $ left\n")["problems"]] == [
        each.message for each in analyze("r $ left\n", editor.robots).diagnostics
    ]


def test_words_are_offered_and_explained_for_the_text_that_the_page_has(editor: PageEditor) -> None:
    ask(editor, "r $ le", number=7)
    ask(editor, "s $ reflect YZ ri", number=1, page=OTHER)
    completed = editor.complete(PAGE, {"type": "complete", "number": 7, "offset": 6})
    assert completed
    assert (completed["start"], completed["end"], [each["word"] for each in completed["words"]]) == (4, 6, ["left"])
    completed = editor.complete(OTHER, {"type": "complete", "number": 1, "offset": 17})
    assert completed
    assert [each["word"] for each in completed["words"]] == ["right"]
    explained = editor.explain(OTHER, {"type": "explain", "number": 1, "offset": 5})
    assert explained
    assert explained["text"].startswith("reflect YZ")
    assert editor.complete(PAGE, {"type": "complete", "number": 6, "offset": 6}) is None  # of another text
    assert editor.explain(3, {"type": "explain", "number": 7, "offset": 0}) is None  # of a page without one
    for offset in (0, 10**9):
        editor.complete(PAGE, {"type": "complete", "number": 7, "offset": offset})
        editor.explain(PAGE, {"type": "explain", "number": 7, "offset": offset})


def test_the_program_of_improv_new_is_right(editor: PageEditor) -> None:
    assert ask(editor, TEMPLATE)["problems"] == []


def test_the_page_gets_starts_of_programs_without_errors(editor: PageEditor) -> None:
    starts = ask(editor, "bo at 1 2 facing 90\nada $ left\n")["starts"]
    assert starts == {"ada": {"x": 0, "y": 0, "heading": 0}, "bo": {"x": 1, "y": 2, "heading": 90}}
    assert ask(editor, "bo at 1 2\nada $ lft\n")["starts"] == {}


def test_robots_are_moved_in_the_text_of_their_page(editor: PageEditor) -> None:
    place: PlaceRobots = {"type": "place", "start_poses": {"ada": {"x": 1, "y": 2, "heading": 0}}}
    ask(editor, "ada $ left\n", number=3)
    moved = editor.change(PAGE, {"type": "change", "number": 3, "change": place})
    assert moved
    assert moved["edits"] == [{"start": 0, "end": 0, "text": "ada at 1 2\n"}]
    form: ArrangeRobots = {"type": "arrange", "shape": "line", "distance": 2, "facing": "in"}
    arranged = editor.change(PAGE, {"type": "change", "number": 3, "change": form})
    assert arranged
    assert arranged["edits"] == [{"start": 0, "end": 0, "text": "ada at 0 0\n"}]
    assert editor.change(OTHER, {"type": "change", "number": 3, "change": place}) is None
    ask(editor, "ada at x\nada $ left\n", number=4)
    assert editor.change(PAGE, {"type": "change", "number": 3, "change": place}) is None
    refused = editor.change(PAGE, {"type": "change", "number": 4, "change": place})
    assert refused
    assert (refused["edits"], refused["problem"]) == ([], "a line with `at` has an error: fix it first")


@pytest.mark.parametrize(
    "what",
    [
        {"type": "place", "start_poses": {"ada": {"x": 1, "y": 2, "heading": 0}}},
        {"type": "arrange", "shape": "line", "distance": 2, "facing": "in"},
    ],
)
def test_no_start_is_written_from_a_rehearsals_places(what: Any, editor: PageEditor) -> None:
    ask(editor, "ada $ left\n", number=3)
    refused = editor.change(PAGE, {"type": "change", "number": 3, "change": what}, rehearses=True)
    assert refused
    line = "this rehearsal doesn't begin at the starts: leave out --from and --only to move them"
    assert (refused["edits"], refused["problem"]) == ([], line)


def test_a_tempo_is_written_into_the_text_of_its_page(editor: PageEditor) -> None:
    ask(editor, "beat 60\nada $ left\n", number=3)
    tune: TuneMusic = {"type": "tune", "key": "beat", "value": 96}
    answer = editor.change(PAGE, {"type": "change", "number": 3, "change": tune})
    assert answer
    assert answer["edits"] == [{"start": 0, "end": 7, "text": "beat 96"}]
    assert editor.change(PAGE, {"type": "change", "number": 2, "change": tune}) is None
