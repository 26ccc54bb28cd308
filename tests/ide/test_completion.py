"""Completion: the words that are offered at the cursor."""

from __future__ import annotations

from improv_core.ide.completion import Completion, complete, document
from improv_core.ide.completion_item import Item
from improv_core.robots.config import read_robots
from improv_core.syntax.vocabulary import TRANSFORMERS, of_kind
from improv_core.syntax.word import Kind
from tests.ide.cursor import at_cursor

MOVING = of_kind(Kind.PRIMITIVE, *TRANSFORMERS, Kind.IF)
PLANES = of_kind(Kind.PLANE)


def offered(program: str, robots: str = "") -> Completion:
    analysis, offset = at_cursor(program)
    found = complete(analysis.with_robots(read_robots(robots)).settled(), offset)
    assert found
    begun = analysis.text[found.span.start : found.span.end]
    assert found.span.end == offset
    assert begun == "" or begun.isidentifier()
    return found


def check(program: str, *labels: str) -> None:
    """Check that exactly these are offered at the cursor, and that they replace the word that has been begun."""
    assert [item.label for item in offered(program).items] == list(labels)


def check_nothing(program: str) -> None:
    assert complete(*at_cursor(program)) is None


def check_snippet(program: str, label: str, snippet: str) -> None:
    (item,) = [item for item in offered(program).items if item.label == label]
    assert item.snippet == snippet


def test_a_line_begins_with_the_tempo_or_a_robot() -> None:
    check("|>", "beat", "room", "bar")
    check("r1 $ left\n|>\n", "beat", "r1", "room", "bar")
    check("r1 $ left\nr|>", "beat", "r1", "room", "bar")
    check("r1 r2 $ left\nr1 |>", "r2", "at", "is")
    robots = '[robots.anna]\nprofile = "turtlesim"\n[robots.bruno]\nprofile = "turtlesim"\n'
    items = offered("bruno carla $ left\n|>", robots).items
    assert [(item.label, item.detail) for item in items[1:4]] == [
        ("anna", "in improv.toml"),
        ("bruno", "1 beat"),
        ("carla", "1 beat"),
    ]


def test_a_movement_is_a_word_or_a_name_defined_above() -> None:
    check("x = left\nr $ |> \nz = right", "x", *MOVING)
    check("x = left\nr $ fo|>\nz = right", "x", *MOVING)
    check("x = left\ny = left\nx = up\nr $ x || |>", "x", "y", *MOVING)
    check("x = left\nr $ fast 2 [|>", "x", *MOVING)
    check("x = |>", *MOVING)
    check("r $ repeat 2 re|>peat 3 left", *MOVING)
    assert offered("x = left up\nr $ |>").items[0] == Item("x", "name", "2 beats")


def test_planes_and_numbers_are_offered_in_their_places() -> None:
    check("r $ reflect |>", *PLANES)
    check("r $ reflect s|>", *PLANES)
    check("r $ fast |>", "2", "3", "3/2")
    check("beat |>", "60", "30", "120")
    check("r $ repeat |>", "2", "3", "4", "8", *MOVING)


PHRASES = "poly n = repeat n (forward scale 4/n left)\ntimes n (m) = repeat n m\nboth (a) (b) = a || b\n"


def test_phrases_leave_room_for_their_arguments() -> None:
    check_snippet(f"{PHRASES}r $ |>", "poly", "poly ${1:n}")
    check_snippet(f"{PHRASES}r $ |>", "times", "times ${1:n} ($0)")
    check_snippet(f"{PHRASES}r $ |> left", "times", "times ${1:n}")
    check_snippet(f"{PHRASES}r $ |>", "both", "both (${1:a}) ($0)")
    item = next(item for item in offered(f"{PHRASES}r $ |>").items if item.label == "times")
    assert (item.kind, item.detail) == ("phrase", "times n (m)")


def test_parameters_in_the_body_of_their_phrase() -> None:
    check("f n (m) = |>", "m", *MOVING)
    check("f n (m) = fast |>", "n", "2", "3", "3/2")
    check("f n (m) = fast 2*|>", "n", "2", "3", "3/2")
    check("m = left\nf (m) = m |>", "m", *MOVING)
    check("f n (m) = up\nr $ |>", "f", *MOVING)


def test_arguments_come_after_the_name_of_a_phrase() -> None:
    assert [item.label for item in offered(f"{PHRASES}f k = times |>").items] == ["k", "2", "3", "3/2"]
    check(f"{PHRASES}r $ times 2 |>", "both", "times", "poly", *MOVING)
    check("x = left\nr $ x |>", "x", *MOVING)
    check("f n (m) = m |>", "m", *MOVING)


def test_nothing_in_comments_and_numbers() -> None:
    check_nothing("# |>")
    check_nothing("r $ left # fo|>")
    check_nothing("r $ repeat 2|>")
    check_nothing("r $ repeat 2|>x")


def test_units_are_offered_directly_behind_the_number_of_a_measure() -> None:
    check("r $ forward 1.5|>", "m", "cm", "mm", "deg", "°")
    check("r $ left 9*10d|>", "deg", "°", "m", "cm", "mm")
    check("r $ left 90deg radius 2|>", "m", "cm", "mm")
    check("room 6|>", "m", "cm", "mm")
    check("ada at 50cm -1|>", "m", "cm", "mm")
    check("ada at 0 0 facing 90|>", "deg", "°")
    for program in ("r $ repeat 4|>", "r $ forward 1.|>", "bar 3|>", "m = up\nr $ fast 2|>", "r $ rest 2|>"):
        check_nothing(program)
    check_nothing("r $ left 9deg forward 1m*2|>")


def test_measures_are_offered_behind_primitives_after_the_words_of_the_language() -> None:
    check("p n = left |>", "n*1deg", *MOVING, "90deg", "45deg", "radius")
    check("x = up\nr $ forward |>", "x", *MOVING, "1m", "50cm")
    check("r $ left 90deg |>", "radius", *MOVING)
    check("r $ left radius |>", "1m", "50cm")


def test_snippets_leave_room_for_their_operands() -> None:
    check_snippet("r $ re|>", "repeat", "repeat ${1:4} ($0)")
    check_snippet("r $ (re|>) left", "reflect", "reflect ${1|YZ,XZ,XY|} ($0)")
    check_snippet("r $ re|> (forward left)", "repeat", "repeat ${1:4}")
    check_snippet("|>", "beat", "beat ${1:60}")


def test_of_many_names_the_nearest_that_fit() -> None:
    program = "".join(f"name{number} = left\n" for number in range(1000))
    found = offered(f"{program}r $ |>")
    assert not found.whole
    assert [item.label for item in found.items if item.kind == "name"][:2] == ["name999", "name998"]
    found = offered(f"{program}r $ n99|>")
    assert not found.whole
    assert [item.label for item in found.items if item.kind == "name"][-1] == "name99"


def test_completions_are_documented() -> None:
    analysis, _ = at_cursor("x = left\nx = x up\nr $ x|>")

    def said(label: str, kind: str, statement: int) -> str:
        found = document(analysis, Item(label, kind), statement, pictures=False)
        return found.plain if found else ""

    assert said("x", "name", 2).startswith("x (name, line 2)\nx = x up\n2 beats, 2.0 s")
    assert said("x", "name", 1).startswith("x (name, line 1)\nx = left\n1 beat")
    assert said("x", "name", 99) == said("x", "name", 2)
    analysis, _ = at_cursor("# Turns.\nx = left\nr $ x|>")
    assert said("x", "name", 1).startswith("x (name, line 2)\n# Turns.\nx = left\n1 beat")
    analysis, _ = at_cursor("x = left\nx = x up\nr $ x|>")
    assert said("r", "robot", 2) == "r (robot, profile turtlesim): everything it plays\n2 beats, 2.0 s at beat 60"
    assert said("reflect", "keyword", 2) == "reflect YZ movement: Mirrors the movement across a plane: YZ, XZ, or XY."
    assert said("8", "number", 2) == said("y", "name", 2) == ""


SENSES = """
[senses.drop]
key = "d"
[senses.near]
topic = "scan"
message = "sensor_msgs/LaserScan"
below = 0.5
from = -30
to = 30
[senses.kick]
osc = "kick"
"""


def test_conditions_offer_senses_and_their_sources() -> None:
    check("r $ until |>", "bump", "near", "cue", "not")
    check("r $ repeat pause ne|> left", "bump", "near", "cue", "not")
    check("x = if not |>", "bump", "near", "cue")
    assert "else" in [item.label for item in offered("x = if near left |>").items]
    found = {item.label: item.detail for item in offered("r $ until |>", SENSES).items if item.kind == "sense"}
    assert list(found) == ["bump", "near", "cue", "drop", "kick"]
    assert found["near"] == "topic scan (sensor_msgs/LaserScan) below 0.5, -30° to 30°"
    assert found["drop"] == "key d, while it is held on the page"
    assert found["kick"] == "OSC messages /improv/sense kick"
    assert found["bump"].startswith("in the simulator")
    analysis, _ = at_cursor("r $ |>")
    shown = document(analysis, Item("near", "sense"), 0, pictures=False)
    assert shown
    assert "closer than" in shown.markdown


ROBOTS = (
    '[robots.anna]\nprofile = "turtlebot4"\n[robots.bo]\nprofile = "holonomic"\n[robots.fly]\nprofile = "quadrotor"\n'
)


def check_last(program: str, *last: str, robots: str = ROBOTS) -> None:
    """Check that these come last, each with the reason why a robot can't perform it."""
    items = [item for item in offered(program, robots).items if item.kind != "number"]
    assert [f"{item.label}: {item.detail}" for item in items if " can't " in item.detail] == list(last)
    assert not last or [f"{item.label}: {item.detail}" for item in items[-len(last) :]] == list(last)


def test_words_that_a_robot_cannot_perform_come_last() -> None:
    sideways = [f"{word}: anna can't move sideways" for word in ("strafeleft", "straferight")]
    upward = ["up: {} can't move up or down", "down: {} can't move up or down"]
    check_last("anna $ |>", *sideways, *(each.format("anna") for each in upward))
    check_last("bo $ forward |>", *(each.format("bo") for each in upward))
    check_last("fly $ |>")
    check_last("anna $ |>", robots="")
    check_last("bo $ reflect |>")


def test_names_that_the_robot_cannot_play_come_last() -> None:
    hover, still = "hop = up left down\n", "still = strafeleft || straferight\n"
    assert [item.label for item in offered(f"{hover}{still}fly $ |>", ROBOTS).items][:2] == ["still", "hop"]
    assert offered(f"{hover}{still}bo $ |>", ROBOTS).items[0].label == "still"
    check_last(f"{hover}bo $ u|>", "hop: bo can't move up or down", *UPWARD)
    check_last("x = |>\ny = x left\nbo $ y", *UPWARD)
    check_last("x = |>\nfly $ x")
    check_last("x = |>", *(f"{word}: anna can't move sideways" for word in ("strafeleft", "straferight")), *ANNA_UPWARD)


UPWARD = ["up: bo can't move up or down", "down: bo can't move up or down"]
ANNA_UPWARD = ["up: anna can't move up or down", "down: anna can't move up or down"]
