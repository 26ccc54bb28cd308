"""Select a part of a program to play alone: lines, a movement, or a name; or say why it can't be played."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, count

from improv_core import LineError
from improv_core.diagnostics import Severity
from improv_core.ide.cursor import touching
from improv_core.ide.fragment import Fragment, fragment_at, is_broken
from improv_core.ide.references import lines_playing
from improv_core.program.analysis import Analysis
from improv_core.program.definitions import ReadNodes
from improv_core.program.feasibility import check_casting
from improv_core.program.program import Line, Placed
from improv_core.robots.config import Robots
from improv_core.robots.limits import unsupported
from improv_core.score.algebra import series
from improv_core.score.dice import position_of, throwing
from improv_core.score.movement import Movement
from improv_core.score.throws import StreamPosition
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node
from improv_core.text import Span

GHOST = "ghost"
"""The robot that dances movements that no robot plays."""
MAX_DANCED = 100
"""The most definitions of a selection in which no line has robots."""
_NOWHERE = -1  # the ID of no statement
_PLAYS_NOTHING = "choose a line with a robot, a name, or a movement"


class UnplayableError(LineError):
    """A selection can't be played. The message is one line that gives the reason."""


@dataclass(frozen=True, slots=True)
class Selection:
    """A part of a program: its name for people, and an analysis in which nothing else plays.

    If it has a `ghost`, a robot that nobody named, it may be played in the simulator only. `note` is information about
    it for people, in one line. If robots are `moved`, they don't begin where the program places them. `span` has the
    lines, or the part of one, that somebody chose.
    """

    name: str
    analysis: Analysis
    ghost: str | None = None
    note: str = ""
    moved: bool = False
    span: Span | None = None


def select(analysis: Analysis, wanted: Span | str) -> Selection:
    """Select the statements that a span touches (an empty one: its line), or a name. Raises UnplayableError.

    Lines with robots play as in the whole program: in their scenes, and with their throws of the dice. If there are
    none, the robots of the nearest line that plays the definitions and movements dance them, or else a ghost.
    """
    chosen, part = _named(analysis, wanted) if isinstance(wanted, str) else _touched(analysis, wanted)
    lines = [each for each in chosen if each.statement.kind == "DOLLAR"]
    if lines and not part:
        require_no_errors(analysis, [each.index for each in lines])
        played = [analysis.played[each.index] for each in lines]
        return Selection(_lines(analysis, lines), replace(analysis, selected=played), span=_span(lines))
    found = [each for each in chosen if part or each.statement.kind in ("EQUAL", "")]
    if not found:
        raise UnplayableError(f"there is nothing to play on {_lines(analysis, chosen)}: {_PLAYS_NOTHING}")
    if len(found) > MAX_DANCED:
        raise UnplayableError(f"these are {len(found):,} definitions: select {MAX_DANCED} or fewer")
    ghost = _unused_name(analysis)
    danced = [_danced(analysis, each, part, ghost) for each in found]
    selected = replace(analysis, selected=danced)
    name = (
        _head(found[0])
        if len(found) == 1 and found[0].statement.kind == "EQUAL" and not part
        else _lines(analysis, found)
    )
    ghostly = [movement for line in danced for robot, movement in line.parts if robot == ghost]
    if not ghostly:
        return Selection(name, selected, span=part or _span(found))
    selected = selected.cast_with(_with_ghost(analysis.config, ghost, ghostly))
    return Selection(name, selected, ghost, span=part or _span(found))


def uses(analysis: Analysis, index: int) -> Sequence[int] | None:
    """Return the statements that give a phrase its arguments: its nearest use, the nearest use of that if it is a
    phrase, …

    None if nothing uses one of them correctly. A statement that takes no arguments needs none.
    """
    found: list[int] = []
    while analysis.statements[index].parameters:
        name = analysis.statements[index].defines
        users = analysis.bindings.users(name, index) if name else ()
        nearest = next((each for each in users if analysis.meanings[each].ok), None)
        if nearest is None:
            return None
        found.append(index := nearest)
    return found


def _named(analysis: Analysis, name: str) -> tuple[Sequence[Placed], None]:
    """Return the last definition of a name."""
    if definers := analysis.bindings.defined.get(name):
        return [analysis.placed(definers[-1])], None
    near = analysis.bindings.nearest(name)
    hint = f"did you mean `{near}`?" if near in analysis.bindings.defined else f"write `{name} = …`"
    raise UnplayableError(f"`{name}` is not defined in this program: {hint}")


def _touched(analysis: Analysis, span: Span) -> tuple[Sequence[Placed], Span | None]:
    """Return the statements of a selection, and its span if it is only a part of the movement of one."""
    text, lines = analysis.text[slice(*span)], analysis.lines
    if not text.strip():
        first, last = (lines.position(offset).line for offset in span)
        found = list(touching(analysis, Span(lines.start(first), lines.end(last))))
        if not found:
            raise UnplayableError(f"there is nothing to play on line {first + 1}: {_PLAYS_NOTHING}")
        return found, None
    start, end = span.start + len(text) - len(text.lstrip()), span.start + len(text.rstrip())
    found = [each for each in touching(analysis, Span(start, end)) if each.start < end and start < each.span.end]
    if not found:
        raise UnplayableError(f"there is nothing to play in this selection: {_PLAYS_NOTHING}")
    (first_one, *others), sign = found, found[0].statement.sign
    begin = first_one.start + (sign.end if sign else 0)
    is_whole = not analysis.text[begin:start].strip() and end >= first_one.span.end
    if others or start < begin or is_whole or first_one.statement.kind not in ("EQUAL", "DOLLAR", ""):
        return found, None
    return found, Span(start, min(end, first_one.span.end))


def _danced(analysis: Analysis, placed: Placed, part: Span | None, ghost: str) -> Line:
    """Have the robots of the nearest line that plays a definition or a part of a statement dance it, or else a
    ghost."""
    playing = next(lines_playing(analysis, placed.index), None)
    robots = (ghost,) if playing is None else analysis.meanings[playing].robots
    own_id = analysis.statement_ids[placed.index]
    scene = analysis.played[playing].scene if playing is not None and playing in analysis.played else 0
    if is_broken(placed) and (part or not placed.statement.kind):
        written = _written(analysis, placed, part or placed.span)
        body = placed.meaning.body
        if not placed.statement.kind and not part and body:  # the movement there itself, so that its words light up
            return Line([(ghost, analysis.reader(placed.index).movement_made(body))], own_id)
        return _able(analysis, placed, Line([(robot, written) for robot in robots], _NOWHERE, scene), playing)
    fragment = fragment_at(analysis, part) if part else None
    using = uses(analysis, placed.index)
    if using is None:
        raise UnplayableError(f"nothing below uses `{_head(placed)}`: write a line that gives it its arguments")
    if part and not fragment:
        raise UnplayableError(f"there is nothing to play in this selection: {_PLAYS_NOTHING}")
    require_no_errors(analysis, [placed.index, *using], fragment)
    voices = len(robots) if placed.statement.by_robot else 1
    found = [_movement(analysis, [placed.index, *using], fragment, robot) for robot in range(voices)]
    parts = list(zip(robots, found * (len(robots) // voices), strict=True))
    return _able(analysis, placed, Line(parts, own_id, scene), playing)


def _movement(analysis: Analysis, using: Sequence[int], fragment: Fragment | None, robot: int) -> Movement:
    """Return the movement of a statement or a fragment of it, with its arguments and throws in the whole program.

    `using` has the statement, then those through whose uses it gets its arguments, the outermost last.
    """
    *phrases, top = using
    reader, body = analysis.reader(top, robot), analysis.meanings[top].body
    whole = reader.movement_made(body) if body else series(())
    for index in reversed(phrases):
        reader, body = _expanded(reader, body, analysis.meanings[index].body)
    items = [reader.movement_made(node) for node in (fragment.nodes if fragment else (body,)) if node]
    inner = series(items)
    line = next((analysis.played.get(host) for host in lines_playing(analysis, top)), None)
    if not inner.dice or not line:
        return inner
    definition, place = analysis.meanings[top].definition, StreamPosition(throw=line.throw)
    if definition:
        place = position_of(definition.movement, line.parts[0][1], place) or place
    place = position_of(items[0], whole, place) or place
    return throwing(inner, place.throw, place.stream)


def _expanded(reader: ReadNodes, body: Node | None, phrase: Node | None) -> tuple[ReadNodes, Node | None]:
    """Return the reader and the body of the first use of a phrase, found by its body, among the nodes read so far."""
    for node in nodes.nodes(body) if body else ():
        expansion = reader.expansion(node) if isinstance(node, nodes.Call) else None
        if expansion and expansion.body is phrase:
            return expansion.reader, expansion.body
    raise UnplayableError("the nearest line that uses it has an error: fix that line, or play it by itself")


def _written(analysis: Analysis, placed: Placed, span: Span) -> Movement:
    """Return the movement at a span, if that alone is a correct one; the statement around it is not."""
    free = analysis.with_robots(replace(analysis.config, robots={}))  # no robots are listed, so the ghost is no error
    text = f"{GHOST} $ ({analysis.text[slice(*span)]}\n)"
    alone = free.edited(placed.start, placed.span.end, text)
    require_no_errors(alone, [placed.index])
    return alone.meanings[placed.index].movement


def _able(analysis: Analysis, placed: Placed, line: Line, playing: int | None) -> Line:
    """Return the line, if its robots, those of the line `playing`, can do that."""
    if playing is None:
        return line
    statement, meaning = analysis.statements[playing], analysis.meanings[playing]
    first, *others = (movement for _, movement in line.parts)
    heads = tuple(head for head in statement.heads if head.text in meaning.robots)
    changed = replace(placed.meaning, robots=meaning.robots, movement=first, others=tuple(others))
    for problem in check_casting(replace(statement, heads=heads), changed, analysis.opening.config, analysis.tempo):
        if problem.severity is Severity.ERROR:
            raise UnplayableError(f"{_lines(analysis, [placed])}: {problem.message}")
    return line


def require_no_errors(analysis: Analysis, indices: Sequence[int], fragment: Fragment | None = None) -> None:
    """Raise UnplayableError if statements have errors, or the definitions that they use, the tempo, or the opening.

    Of the first statement, only the `fragment` counts, if there is one.
    """
    needed = _needed(analysis, indices, fragment)
    for index in sorted(needed):
        for problem in analysis.diagnostics_of(index):
            counts = (
                not fragment or index != indices[0] or (fragment.span.start <= problem.span.start < fragment.span.end)
            )
            if counts and problem.severity is Severity.ERROR:
                raise UnplayableError(f"{_lines(analysis, [analysis.placed(index)])}: {problem.message}")


def _needed(analysis: Analysis, indices: Sequence[int], fragment: Fragment | None) -> set[int]:
    """Return these statements, the definitions that they use, the tempo, and the opening."""
    reached = {*indices, *analysis.tempos[:1], *analysis.openings}
    waiting = list(reached)
    while waiting:
        index = waiting.pop()
        names = analysis.statements[index].uses
        if fragment and index == indices[0]:
            names = tuple(name.text for node in fragment.nodes for name in nodes.names(node))
        definers = {analysis.bindings.definer(name, index) for name in names}
        found = {definer for definer in definers if definer is not None} - reached
        reached |= found
        waiting += found
    return reached


def _unused_name(analysis: Analysis) -> str:
    """Return a name for the ghost that no robot has."""
    taken = {robot for meaning in analysis.meanings for robot in meaning.robots}.union(analysis.config.robots)
    taken |= analysis.opening.places.keys()
    names = chain([GHOST], (f"{GHOST}{number}" for number in count(2)))
    return next(name for name in names if name not in taken)


def _with_ghost(config: Robots, ghost: str, movements: Sequence[Movement]) -> Robots:
    """Return the robots, and a ghost that is like the first of them that can do these movements."""
    able = (
        robot
        for robot in config.robots.values()
        if not any(unsupported(movement.bounds.peak, robot.profile) for movement in movements)
    )
    like = next(able, config.robot(ghost))
    return replace(config, robots={**config.robots, ghost: replace(like, start=None, reset=None)})


def _head(placed: Placed) -> str:
    return placed.statement.heads[0].text


def _span(placed: Sequence[Placed]) -> Span:
    return Span(placed[0].start, placed[-1].span.end)


def _lines(analysis: Analysis, placed: Sequence[Placed]) -> str:
    """`line 3`, `lines 3 to 5`."""
    first, last = (analysis.lines.number(each.start) for each in (placed[0], placed[-1]))
    return f"line {first}" if first == last else f"lines {first} to {last}"
