"""The paths of a text before it is saved."""

from __future__ import annotations

from collections.abc import Sequence

from improv_core.page.program_editor import PageEditor
from improv_core.protocol.editing import AskPreview, Preview, PreviewedPath
from improv_core.robots.config import read_robots

PAGE = 1


def previews(
    text: str, editor: PageEditor | None = None, number: int = 1, known: int | None = None
) -> Sequence[Preview]:
    """Return all answers about a text to a page that has the paths of the `known` one."""
    editor = editor or PageEditor(read_robots(""), str)
    editor.analyze(PAGE, {"type": "analyze", "number": number, "text": text})
    ask: AskPreview = {"type": "preview", "number": number}
    if known is not None:
        ask["known"] = known
    return [*editor.previews(PAGE, ask)]


def path(preview: Preview, robot: str) -> PreviewedPath:
    """Return a path that a page doesn't have."""
    found = preview["robots"][robot]
    assert found
    return found


def check(text: str, *robots: str, problem: str = "") -> None:
    """Check the robots with a path, each with the place where it ends, as `ada 1.5,0`, and the error."""
    latest = previews(text)[-1]
    ends = {
        name: ",".join(f"{place:g}" for place in path(latest, name)["strokes"][-1][3:5]) for name in latest["robots"]
    }
    assert [f"{name} {end}" for name, end in ends.items()] == [*robots]
    assert (latest["problem"], latest["waits_for"]) == (problem, [])


def test_the_path_of_a_text_has_its_start_and_its_strokes() -> None:
    (preview,) = previews("ada at 1 0\nada $ forward 50cm left 90deg radius 1m")
    look = path(preview, "ada")["look"]
    assert preview["robots"] == {
        "ada": {
            "start": [1, 0, 0],
            "strokes": [[1, 0, 0, 1.5, 0, 0], [1.5, 0, 0, 2.5, 1, 1.571]],
            "certain": 2,
            "look": look,
        }
    }
    assert (look["profile"], look["radius"], look["body"]) == ("turtlesim", 0.3, [])


def test_an_endless_path_has_a_beginning() -> None:
    check("ada $ repeat forward 1m", "ada 24,0")


def test_a_robot_that_lacks_a_word_has_no_path() -> None:
    word = "`lft` in line 1 is not defined"
    check("side = forward lft\nada $ repeat 4 side\nbo $ forward 1m\nbo at 0 0", "bo 1,0", problem=word)
    check("ada $ lft\nada $ forward\nbo $ forward 1m\nbo at 0 0", "bo 1,0", problem=word)
    check("beat 30\nbeat 20\nbo $ forward 1m\nbo at 0 0", "bo 1,0", problem="line 2 has an error")
    check(
        "bo $ forward 1m\nada $ until near repeat forward\nada $ lft\nbo at 0 0",
        "bo 1,0",
        problem=word.replace("1", "3"),
    )


ROOM = "room 10m 4m\nada at 0 0\n"


def test_senses_decide_as_in_the_simulator() -> None:
    first, second = previews(f"{ROOM}bo at 0 1\nbo $ forward 1m\nada $ until near repeat forward 1m")
    assert ([*first["robots"]], first["waits_for"]) == (["bo"], ["ada"])
    assert [*second["robots"]] == ["bo", "ada"]
    stroke = path(second, "ada")["strokes"][-1]
    assert 1 < stroke[3] < 4.7
    assert path(second, "ada")["certain"] == len(path(second, "ada")["strokes"])
    check(f"{ROOM}ada $ until near repeat forward 1m lft", problem="`lft` in line 3 is not defined")


def test_no_more_answers_follow_once_somebody_types() -> None:
    editor = PageEditor(read_robots(""), str)
    text = f"{ROOM}ada $ until near repeat forward 1m"
    editor.analyze(PAGE, {"type": "analyze", "number": 1, "text": text})
    answers = editor.previews(PAGE, {"type": "preview", "number": 1})
    next(answers)
    editor.analyze(PAGE, {"type": "analyze", "number": 2, "text": f"{text} left"})
    assert next(answers, None) is None
    assert previews("ada $ left", editor, 3)
    assert [*editor.previews(PAGE, {"type": "preview", "number": 2})] == []


def test_only_what_changes_is_drawn_again() -> None:
    editor = PageEditor(read_robots(""), str)
    (before,) = previews("ada $ forward\nbo $ left forward", editor, 1)
    (after,) = previews("# bo\nada $ forward\nbo $ right forward", editor, 2)
    assert after["robots"]["ada"] is before["robots"]["ada"]
    assert after["robots"]["bo"] != before["robots"]["bo"]
    (slower,) = previews("beat 30\nada at 1 0\nada $ forward", editor, 3)
    assert path(slower, "ada")["start"] == [1, 0, 0]


def test_a_page_gets_only_the_paths_that_it_does_not_have() -> None:
    editor = PageEditor(read_robots(""), str)
    room = f"{ROOM}bo at 0 1\ncy at 0 -1\n"
    first, second = previews(f"{room}bo $ left\ncy $ left\nada $ until near repeat forward 1m", editor, 1)
    changed = f"{room}bo $ left\ncy $ forward\nada $ until near repeat forward 1m"
    also, sensed = previews(changed, editor, 2, known=1)
    assert [also["robots"]["bo"], sensed["robots"]["bo"]] == [None, None]
    assert also["robots"]["cy"] == sensed["robots"]["cy"] != first["robots"]["cy"]
    assert sensed["robots"]["ada"] == second["robots"]["ada"]  # sent again: it was computed again
    (all_again, _), (late, _) = (previews(changed, editor, number, known) for number, known in ((3, None), (4, 1)))
    assert None not in all_again["robots"].values()
    assert [name for name, each in late["robots"].items() if each is None] == ["bo"]  # two texts have come since then
