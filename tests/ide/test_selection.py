"""A selection `«…»`, a line, marked `«`, or a name played alone: the robots and their movements, or why not."""

from __future__ import annotations

from itertools import islice

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.ide.selection import Selection, UnplayableError, select
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.walk import Moment, walk
from improv_core.syntax import nodes
from improv_core.text import Span
from tests.random_programs import written

WORDS = 12
"""The most words of a robot that a test compares."""
ROBOTS = """
[robots.anna]
profile = "turtlebot3_burger"

[robots.bert]
profile = "turtlesim"
"""


def marked(program: str) -> tuple[str, Span]:
    """Return the program without its marks, and the selection, which is empty if there is only the first mark."""
    start = program.index("«")
    end = program.find("»") - 1
    return program.replace("«", "").replace("»", ""), Span(start, end if end > 0 else start)


def selected(program: str, name: str = "", robots: str = "") -> Selection:
    text, span = (program, Span(0, 0)) if name else marked(program)
    return select(analyze(text, read_robots(robots)), name or span)


def danced(analysis: Analysis) -> str:
    """Return the words that each robot performs, as they are written: `anna: forward left · bert: right`."""
    texts = {id_: analysis.text[offset:] for id_, offset in zip(analysis.statement_ids, analysis.offsets, strict=True)}

    def word(moment: Moment) -> str:
        if not moment.sources:
            return "-"  # it stands until a scene begins
        source = moment.sources[-1]
        return texts[source.statement][slice(*source.span)] if source.statement in texts else "?"

    parts = score_of(analysis).parts.values()
    played = {part.robot: [word(moment) for moment in islice(walk(part.movement), WORDS)] for part in parts}
    return " · ".join(f"{robot}: {' '.join(words)}" for robot, words in played.items())


def check(program: str, expected: str, name: str = "", robots: str = "") -> None:
    found = selected(program, name, robots)
    assert danced(found.analysis) == expected
    assert (found.ghost is not None) == ("ghost" in expected)


def refused(program: str, expected: str, name: str = "", robots: str = "") -> None:
    with pytest.raises(UnplayableError) as refusal:
        selected(program, name, robots)
    assert str(refusal.value) == expected


def test_a_line_plays_and_the_others_stay_out() -> None:
    check("anna $ forward\n  «bert $ left # and so on\n", "bert: left")
    check("anna $ forward\nbert $ left  # and« so on\n", "bert: left")
    check("anna $ (forward\n  «\n left)\nbert $ left", "anna: forward left")
    check("x = up\nanna bert $ x« left", "anna: up left · bert: up left")


def test_a_selection_plays_its_lines() -> None:
    check("anna $ forward\nbe«rt $ left\nanna $ u»p\nbert $ right", "bert: left · anna: up")
    check("x = left\nanna $ forward«\n\n# more\ny = up\nbert $ x\n»anna $ left", "bert: left")
    check("anna $ «forward left»", "anna: forward left")
    check("«beat 30\nx = left\nanna $ x»", "anna: left")
    check("anna $ up\n---\nbert $ «left\n---\nanna» $ right", "bert: left · anna: - right")


def test_a_definition_is_danced_by_the_robot_of_the_nearest_line_that_plays_it() -> None:
    check("x = left up«\ny = x x\nbert $ y\nanna $ x", "bert: left up")
    check("x = left up\ny = x x\nbert $ y\nanna $ x", "bert: left up", name="x")
    check("x = left up\nanna $ x\nx = right\nbert $ x", "bert: right", name="x")
    check("x« = left up\nanna $ x\nx = right\nbert $ x", "anna: left up")
    check("«x = left\ny = up\n»anna bert $ x y", "anna: left up · bert: left up")
    check("x« = left\nanna $ x lft", "anna: left")


def test_a_ghost_dances_definitions_that_no_robot_plays() -> None:
    check("x« = left up\nanna $ right", "ghost: left up")
    check("anna $ x\nx« = left up", "ghost: left up")
    check("repeat 2 «(forward left)\nanna $ right", "ghost: forward left forward left")
    check("answer (m) = m reflect sagittal m\nanswer «left\nanna $ right", "ghost: left left")
    check("x« = left\nghost $ right\nghost2 $ right", "ghost3: left")
    assert "ghost" not in selected("ghost $ up\nx« = left").analysis.robots
    # The ghost is like the first robot that can do it.
    assert profile("x« = forward") == "turtlebot3_burger"
    assert profile("x« = strafeleft") == "turtlesim"


def profile(program: str) -> str:
    found = selected(program, robots=ROBOTS)
    assert found.ghost
    return score_of(found.analysis).parts[found.ghost].profile.name


def test_a_part_of_a_movement_is_danced_by_itself() -> None:
    check("anna $ repeat 3 slow 2 (forward «left» up)", "anna: left")
    check("anna $ [forward «left up» right]", "anna: left up")
    check("anna $ forw«ard le»ft up", "anna: forward left")
    check("x = forward «left»\nbert $ x", "bert: left")
    check("x = forward left\nbert $ up «x» up", "bert: forward left")
    check("x = forward «left»", "ghost: left")
    check("anna bert $ canon 1 «(forward» left)", "anna: forward left · bert: forward left")
    canon = selected("anna bert $ «canon 1 forward» left").analysis
    assert [part.movement.duration for part in score_of(canon).parts.values()] == [2, 2]


def test_a_phrase_takes_the_arguments_of_its_nearest_use() -> None:
    poly = "poly n« = repeat n (forward left)\n"
    check(f"{poly}anna $ poly 2\nbert $ poly 3", "anna: forward left forward left")
    check(f"{poly}q = poly 1\nbert $ poly 3\nanna $ q", "bert: forward left")
    check(f"{poly}two n = poly n poly n\nbert $ two 2", "bert: forward left forward left")
    check(f"{poly}q = poly 2\nbert $ left", "ghost: forward left forward left")
    check(f"{poly}anna $ poly\nbert $ poly 1", "anna: forward left")
    check("twice (m) = m «m»\nanna $ twice (up left)", "anna: up left")
    check("poly n = repeat n (forward «scale 4/n left»)\nanna $ poly 5", "anna: left")
    twice = selected("poly n = repeat n (forward «scale 4/n left»)\nanna $ poly 8").analysis
    assert next(walk(score_of(twice).parts["anna"].movement)).velocity.yaw * 2 == 1
    refused(poly, "nothing below uses `poly`: write a line that gives it its arguments")
    refused(f"{poly}two n = poly n", "nothing below uses `poly`: write a line that gives it its arguments")


def test_errors_that_it_does_not_need_do_not_stop_it() -> None:
    check("x = (\nanna $ forward\nbert $ le«ft\nanna $ lft\nbeat 30\nbeat 20", "bert: left")
    check("anna $ [lft «forward» nonsense", "anna: ?")
    check("anna $ lft «forward» nonsense", "anna: forward")
    check("«forward left» [", "ghost: ? ?")
    refused("x = lft\nanna $ forw«ard x", "line 1: `lft` is not defined: did you mean `left`?")
    refused("anna $ forw«ard lft", "line 1: `lft` is not defined: did you mean `left`?")
    refused("anna $ forward «lft» up", "line 1: `lft` is not defined: did you mean `left`?")
    refused("beat 0\nanna $ forw«ard", "line 1: write the tempo as a number above 0")
    refused("x = (forward«\nanna $ x", "line 1: close this bracket with `)`")
    refused("4 forward«", "line 1: write `repeat 4 forward` or `scale 4 forward`")
    refused(
        "x = up«\nanna $ x",
        "line 1: `anna` can't move up or down: use another motion, or a profile other than turtlebot3_burger, "
        "such as quadrotor",
        robots=ROBOTS,
    )


def test_selections_that_play_nothing_are_refused_in_one_line() -> None:
    advice = "choose a line with a robot, a name, or a movement"
    refused("anna $ left\n\n«\n", f"there is nothing to play on line 3: {advice}")
    refused("anna $ left\n# «a comment»\n", f"there is nothing to play in this selection: {advice}")
    refused("beat« 60\nanna $ left", f"there is nothing to play on line 1: {advice}")
    refused("«beat 60\n\n---»\nanna $ left", f"there is nothing to play on lines 1 to 3: {advice}")
    refused("«", f"there is nothing to play on line 1: {advice}")
    refused("square = up", "`sqare` is not defined in this program: did you mean `square`?", name="sqare")
    refused("square = up", "`x` is not defined in this program: write `x = …`", name="x")
    many = "\n".join(f"x{number} = up" for number in range(200))
    refused(f"«{many}»", "these are 200 definitions: select 100 or fewer")


THROWS = ["shuffle (left right up down)", "choose (left right up down)"]
FORMS = ["({0})", "({0} {1})", "[{0} {1}]", "choose (fit 1 {0} fit 1 {1})", "shuffle ({0} {1})", "chance 2/3 {0}"]
FORMS += ["seed 3/2 {0}", "if near {0} else {1}"]
dances = written([*THROWS, "x", "y"], FORMS, 8)


def once(movement: str, letter: str, word: str) -> str:
    """Return the movement with a word in place of a letter's first occurrence."""
    return movement.replace(letter, word, 1).replace(letter, "right")


@given(dances, dances, st.data())
def test_the_dice_fall_as_in_the_whole_program(x: str, played: str, data: st.DataObject) -> None:
    """Check that a part that is performed more than once throws as it does the first time."""
    played = once(once(played, "y", f"many 2 {THROWS[0]}"), "x", "(X)")
    x = x.replace("x", "up").replace("y", "left")
    text = f"many n (m) = repeat n m {THROWS[1]}\nX = {x}\nanna $ {THROWS[0]} {played}\n"
    analysis = analyze(text)
    placed = analysis.placed(data.draw(st.integers(0, 2)))
    body = placed.body
    assert body
    terms = [node for node in nodes.nodes(body) if isinstance(node, nodes.Apply)]  # never all items of a `choose`
    if not terms:
        return
    span = data.draw(st.sampled_from(terms)).span
    id_ = analysis.statement_ids[placed.index]
    whole = performed(analysis, id_, span)
    try:
        alone = performed(select(analysis, span.shifted(placed.start)).analysis, id_, span)
    except UnplayableError:
        return  # a phrase that nothing uses
    assert whole[: len(alone)] == alone or not whole  # the dice may choose something else


def performed(analysis: Analysis, statement: int, span: Span) -> list[Span]:
    """Return the words of a part of a statement that a robot performs, in this order."""
    (part,) = score_of(analysis).parts.values()
    found = []
    for moment in walk(part.movement):
        inside = [each for each in moment.sources if each.statement == statement]
        if any(span.start <= each.span.start and each.span.end <= span.end for each in inside):
            found.append(moment.sources[-1].span)
    return found
