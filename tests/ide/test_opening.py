"""Editor features in the opening: completion, hovers, references, renames, outlines, colors, folds, selections."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.code_action_play import play_actions
from improv_core.ide.code_lens import lenses
from improv_core.ide.completion_item import Item
from improv_core.ide.hover import hover
from improv_core.ide.inlay_hint import hints
from improv_core.ide.references import definition, references, symbol_at
from improv_core.ide.rename import RefusalError, renamable, rename
from improv_core.ide.selection_range import selections
from improv_core.ide.signature_help import signature
from improv_core.program.analysis import analyze
from improv_core.program.program import scene_ids
from improv_core.robots.config import read_robots
from improv_core.score.profiles import BUILT_IN
from improv_core.text import Span
from tests.ide.cursor import at_cursor
from tests.ide.test_completion import check as check_completion
from tests.ide.test_completion import offered
from tests.ide.test_document_symbol import check as check_outline
from tests.ide.test_hover import check as check_hover
from tests.ide.test_semantic_tokens import check as check_colors

DANCE = """
room 6 4
bar 3
ada bo at circle 1.5
ada is quadrotor
cy at -1 2
--- meet
ada bo $ forward
--- bow
ada cy $ left
"""


@pytest.mark.parametrize(
    ("program", "labels"),
    [
        ("room |>", ["4", "6", "8", "at", "is"]),
        ("room 6 |>", ["4", "6", "8"]),
        ("room 6 4 |>", []),
        ("bar |>", ["3", "4", "at", "is"]),
        ("bar 3 |>", []),
        ("room 6 4\nbar 3\n|>", ["beat"]),
        ("room 6 4\n|>", ["beat", "bar"]),
        ("ada |>\nada bo $ left", ["bo", "at", "is"]),
        ("ada a|>", ["at", "is"]),
        ("ada at |>", ["0 0", "circle", "line", "grid"]),
        ("ada at ci|>", ["0 0", "circle", "line", "grid"]),
        ("ada bo at |>", ["circle", "line", "grid"]),
        ("at at |>", ["0 0", "circle", "line", "grid"]),
        ("ada at 1 |>", ["0", "2"]),
        ("ada at 1 2 |>", ["facing"]),
        ("ada at 1 2 facing |>", ["0", "90", "180", "-90"]),
        ("ada at 1 2 facing 90 |>", []),
        ("ada at circle |>", ["1", "2"]),
        ("ada at circle 1 |>", ["facing", "around"]),
        ("ada at circle 1 facing |>", ["in", "out"]),
        ("ada at circle 1 facing in |>", ["around"]),
        ("ada at circle 1 around |>", ["0", "2"]),
        ("ada at circle 1 around 0 |>", ["0", "2"]),
        ("ada at circle 1 around 0 0 |>", ["facing"]),
        ("ada bo at line 1 |>", ["around"]),
        ("ada is |>", list(BUILT_IN)),
        ("ada is hus|>", list(BUILT_IN)),
        ("--- |>", []),
    ],
)
def test_possible_words_are_offered(program: str, labels: list[str]) -> None:
    check_completion(program, *labels)


def test_profiles_are_described() -> None:
    items = offered("ada is |>", "[profiles.nao-v6]\nstep = 0.4\nmotions = ['forward']\n").items
    about = {item.label: item.detail for item in items}
    assert about["turtlebot4"] == "step 0.2 m, radius 0.171 m, up to 0.306 m/s; forward, turn"
    assert about["quadrotor"] == "step 0.5 m, radius 0.25 m, up to 1 m/s; all motions"
    assert about["nao-v6"] == "step 0.4 m, radius 0.3 m; forward"


def test_placed_robots_are_offered_too() -> None:
    assert Item("cy", "robot", "only stands there") in offered("cy at 1 2\n|>").items


@pytest.mark.parametrize(
    ("program", "marked", "said"),
    [
        ("ro|>om 6 4", "room 6 4", ["**room 6 4**: the floor, with walls around it", "x from -3 to 3 m"]),
        ("room 6 |>4 # wide", "room 6 4", ["y from -2 to 2 m"]),
        ("beat 120\nb|>ar 3", "bar 3", ["**bar 3**: 3 beats a bar, 1.5 s at beat 120"]),
        ("ada a|>t -1 1/2 facing 90", "at -1 1/2 facing 90", ["**at**: ada starts at x -1 m, y 0.5 m, facing 90°"]),
        ("ada at 1 |>1\nbo at 1 1\ncy at 5 5", "at 1 1", ["here too: bo"]),
        ("ada at |>0 0\nbo at 3 4", "at 0 0", ["nearest: bo, 5 m away"]),
        ("ada bo at ci|>rcle 1", "at circle 1", ["2 robots start here", "bo: x 0 m, y -1 m, facing 90°"]),
        ("ada is hu|>sky", "husky", ["**husky**: step 0.2 m"]),
        ("a|>da at 1 2\nada $ left", "ada", ["everything it plays", "starts at x 1 m, y 2 m, facing 0°"]),
        ("a|>da at 1 2\nbo $ left", "ada", ["only stands there", "starts at x 1 m, y 2 m"]),
        ("r $ left\n--- b|>ow\nr $ left", "bow", ["a new scene"]),
        ("--- b|>ow\nr $ left", "bow", ["the name of the first scene"]),
    ],
)  # fmt: skip
def test_lines_of_the_opening_have_hovers(program: str, marked: str, said: list[str]) -> None:
    check_hover(program, marked, *said)


def test_of_a_thousand_robots_the_first_places_are_listed() -> None:
    names = " ".join(f"r{number}" for number in range(1_000))
    found = hover(analyze(f"{names} at circle 100"), len(names) + 2)
    assert found
    assert len(found.facts) == 13
    assert found.facts[-1] == "and 988 more"


@pytest.mark.parametrize("program", ["ada at |>1", "room |>6", "ada at 1|>001 0", "bar |>0", "ada is |>nobody"])
def test_lines_with_errors_have_no_hover(program: str) -> None:
    assert hover(*at_cursor(program)) is None


def test_a_robot_is_found_on_all_lines() -> None:
    analysis = analyze(DANCE)
    for at in [place for place in range(len(DANCE)) if DANCE.startswith("ada", place)]:
        symbol = symbol_at(analysis, at)
        assert symbol
        assert symbol.kind == "robot"
        lines = [analysis.lines.position(each.span.start).line for each in references(analysis, symbol)]
        assert lines == [3, 4, 7, 9]
        assert definition(analysis, symbol) == Span(DANCE.index("ada"), DANCE.index("ada") + 3)
        edits = rename(analysis, symbol, "zoe")
        assert applied(DANCE, edits) == DANCE.replace("ada", "zoe")
        with pytest.raises(RefusalError, match="`cy` is already a robot, on line 6"):
            rename(analysis, symbol, "cy")


def test_a_robot_is_defined_where_it_is_placed() -> None:
    analysis, offset = at_cursor("a|>da $ left\nada at 1 2")
    symbol = symbol_at(analysis, offset)
    assert symbol
    assert definition(analysis, symbol) == Span(11, 14)


def test_a_scene_is_renamed() -> None:
    analysis = analyze(DANCE)
    symbol = renamable(analysis, DANCE.index("bow") + 1)
    assert symbol.kind == "scene"
    assert definition(analysis, symbol) == symbol.span
    assert [each.span for each in references(analysis, symbol)] == [symbol.span]
    assert applied(DANCE, rename(analysis, symbol, "end")) == DANCE.replace("bow", "end")
    for new in ("meet", "left", "2"):
        with pytest.raises(RefusalError):
            rename(analysis, symbol, new)


def test_a_scene_is_no_robot() -> None:
    analysis, offset = at_cursor("b|>o $ left\n--- bo\nbo $ up")
    symbol = symbol_at(analysis, offset)
    assert symbol
    assert len(references(analysis, symbol)) == 2


def test_outlines_have_places_and_scenes_by_name() -> None:
    check_outline(
        DANCE,
        "meet: scene",
        "  room 6 4: setting",
        "  bar 3: setting",
        "  ada bo: robots at circle 1.5",
        "    ada: robot at circle 1.5",
        "    bo: robot at circle 1.5",
        "  ada: robot is quadrotor",
        "  cy: robot at -1 2",
        "  ada bo: robots 1 beat",
        "    ada: robot 1 beat",
        "    bo: robot 1 beat",
        "bow: scene from beat 2",
        "  ada cy: robots 1 beat",
        "    ada: robot 1 beat",
        "    cy: robot 1 beat",
    )
    check_outline("room 6\nbar 3 # waltz\nada at", "bar 3: setting", "ada: robot")


def test_scenes_are_called_by_their_names() -> None:
    analysis = analyze("--- meet\nr $ left\n--- bow\nr $ left\n---\nr $ left")
    texts = [lens.text.partition(" ·")[0] for lens in lenses(analysis, scene_ids(analysis))]
    assert texts == ["▶ play", "▶ scene bow", "▶ from here", "▶ scene 3"]
    played = [
        [action.title for action in play_actions(analysis, at) if "only scene" in action.title] for at in (0, 20, 40)
    ]
    assert played == [
        ["Play only scene meet (1 beat, 1.0 s)"],
        ["Play only scene bow (1 beat, 1.0 s)"],
        ["Play only scene 3 (1 beat, 1.0 s)"],
    ]


def test_lines_of_the_opening_have_colors() -> None:
    check_colors(
        "room 6 4\nbar 3\nin at at circle 1.5 facing in around -1 0\nada is nao-v6\n---bow\nada $ forward",
        *("room:keyword", "6:number", "4:number", "bar:keyword", "3:number"),
        *("in:class", "at:class", "at:keyword", "circle:keyword", "1.5:number", "facing:keyword", "in:keyword"),
        *("around:keyword", "-1:number", "0:number", "ada:class", "is:keyword"),
        *("---:operator", "bow:variable.definition", "ada:class", "$:operator", "forward:function.defaultLibrary"),
    )
    robots = read_robots("[profiles.nao-v6]\nstep = 1\n")
    check_colors(analyze("ada is nao-v6 # a", robots), "ada:class", "is:keyword", "nao-v6:enumMember", "# a:comment")


def test_lines_of_the_opening_have_no_hint_and_no_signature() -> None:
    analysis = analyze(DANCE)
    assert [hint.text for hint in hints(analysis, Span(0, len(DANCE)))] == ["1 beat", "1 beat"]
    assert all(signature(analysis, offset) is None for offset in range(DANCE.index("---")))


def test_a_selection_grows_over_a_place() -> None:
    analysis, offset = at_cursor("ada at circle 1.|>5 facing in # a\nada $ left")
    assert [analysis.text[slice(*span)] for span in selections(analysis, offset)][:3] == [
        "1.5",
        "circle 1.5 facing in",
        "ada at circle 1.5 facing in # a",
    ]
