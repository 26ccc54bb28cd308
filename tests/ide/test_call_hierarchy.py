"""Call hierarchy: from the name or robot at the cursor to its users, and to the names that it uses."""

from __future__ import annotations

from improv_core.ide.call_hierarchy import HierarchyCall, incoming, outgoing, prepare
from improv_core.program.analysis import Analysis
from tests.ide.cursor import at_cursor


def check(program: str, item: str, callers: list[str], callees: list[str]) -> None:
    """Check the item at the cursor, with its callers and callees: the kind of each, and the texts of the uses by
    line."""
    analysis, offset = at_cursor(program)
    entry = prepare(analysis, offset)
    assert entry
    place = entry.name_span.start
    assert f"{entry.kind} {entry.name}" == item
    assert [shown(analysis, call) for call in incoming(analysis, place)] == callers
    assert [shown(analysis, call) for call in outgoing(analysis, place)] == callees


def shown(analysis: Analysis, call: HierarchyCall) -> str:
    """Return `name x at 2: y y`."""
    words = " ".join(analysis.text[slice(*span)] for span in call.spans)
    line = analysis.lines.position(call.spans[0].start).line + 1
    return f"{call.entry.kind} {call.entry.name} at {line}: {words}"


PROGRAM = """
step = forward
poly n = repeat n (step left) # a comment
walk = poly 3 step poly 4
anna bo $ walk repeat 2 walk
step = backward
bo $ step
"""


def at(use: str, place: int = 0) -> str:
    """Return the program with the cursor in a use of a word."""
    before = PROGRAM.split(use)
    return use.join(before[: place + 1]) + use[:1] + "|>" + use[1:] + use.join(before[place + 1 :])


def test_from_a_definition_or_any_use() -> None:
    users = ["phrase poly at 2: step", "name walk at 3: step"]
    for place in range(3):
        check(at("step", place), "name step", users, [])
    check(at("poly"), "phrase poly", ["name walk at 3: poly poly"], ["name step at 2: step"])
    check(
        at("walk"),
        "name walk",
        ["robots anna bo at 4: walk walk"],
        ["phrase poly at 3: poly poly", "name step at 3: step"],
    )


def test_a_name_that_is_defined_again_is_another_symbol() -> None:
    check(at("step", 4), "name step", ["robot bo at 6: step"], [])


def test_from_the_line_of_a_robot() -> None:
    check(at("anna"), "robots anna bo", [], ["name walk at 4: walk walk"])
    check("x = left\n|>r $ x", "robot r", [], ["name x at 2: x"])
    check("hi|>gh = left\nr is puppet\nr $ high head to high", "name high", ["robot r at 3: high"], [])  # no pose


def test_nothing_else_has_callers() -> None:
    for program in ("r $ qq|>q", "r $ le|>ft", "f n = repeat |>n left", "be|>at 60", "# |>", "|>---"):
        assert prepare(*at_cursor(program)) is None
    analysis, offset = at_cursor("r $ left\n|>\n")
    assert incoming(analysis, offset) == outgoing(analysis, offset) == []
