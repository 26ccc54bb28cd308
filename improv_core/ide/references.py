"""Find the symbol that the name or robot at the cursor refers to, all references to it, and the robots that perform a
statement."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from heapq import heappop, heappush
from itertools import chain, islice
from typing import Literal

from improv_core.ide.phrases import poses_at
from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.robots.config import Robots
from improv_core.robots.toml_text import read_toml
from improv_core.score.profiles import DEFAULT, Profile
from improv_core.slices import in_slices
from improv_core.syntax.heads import classified
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Statement
from improv_core.syntax.parser import LONGEST_KEPT, parse_statement
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

MAX_USERS = 1_000
"""The most statements that are followed to the lines that play them."""


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name, a parameter, a robot, or a scene, and its span.

    `definer` is the index of the statement that defines a name or a parameter; None if nothing above defines it, and
    for robots and scenes.
    """

    text: str
    span: Span
    kind: Literal["name", "parameter", "robot", "scene"]
    definer: int | None = None


@dataclass(frozen=True, slots=True)
class Reference:
    """A span that refers to a symbol or `defines` it."""

    span: Span
    defines: bool = False


def symbol_at(analysis: Analysis, offset: int) -> Symbol | None:
    """Return the name, the parameter, the robot, or the scene that the cursor touches, including at its end."""
    placed = analysis.statement_at(offset)
    if not placed:
        return None
    statement, place = placed.statement, offset - placed.start
    for head in _heads(statement):
        if head.span.holds(place):
            span = head.span.shifted(placed.start)
            if statement.defines is not None:
                return Symbol(head.text, span, "name", placed.index)
            return Symbol(head.text, span, "scene" if statement.kind == "SCENE" else "robot")
    for token in _parameters(statement):
        if token.span.holds(place):
            return Symbol(token.text, token.span.shifted(placed.start), "parameter", placed.index)
    for name in names_used(placed):
        if name.span.holds(place):
            definer = analysis.bindings.definer(name.text, placed.index)
            return Symbol(name.text, name.span.shifted(placed.start), "name", definer)
    return None


def references(analysis: Analysis, symbol: Symbol) -> list[Reference]:
    """Return all references to the same robot or the same definition, in the order of the text.

    A name that is defined again is a different symbol from there on.
    """
    if symbol.kind == "robot":
        return [Reference(span) for _, span in plays(analysis, symbol.text)]
    if symbol.kind == "scene":
        return [Reference(span, defines=True) for _, span in scenes_called(analysis, symbol.text)]
    found = []
    if symbol.kind == "parameter" and symbol.definer is not None:
        start, statement = analysis.offsets[symbol.definer], analysis.statements[symbol.definer]
        named = (token for token in _parameters(statement) if token.text == symbol.text)
        heads = {each.token.span for each in statement.parameters}
        return [Reference(token.span.shifted(start), token.span in heads) for token in named]
    if symbol.definer is not None:
        head = analysis.statements[symbol.definer].heads[0]
        found.append(Reference(head.span.shifted(analysis.offsets[symbol.definer]), defines=True))
    for index in in_slices(analysis.bindings.users(symbol.text, -1 if symbol.definer is None else symbol.definer)):
        start = analysis.offsets[index]
        names = names_used(analysis.placed(index))
        found += [Reference(name.span.shifted(start)) for name in names if name.text == symbol.text]
    return found


def definition(analysis: Analysis, symbol: Symbol) -> Span | None:
    """Return the definition of a name, even if only below. For a robot without a section in `improv.toml`: the line
    that places it or gives it its kind, or else its first line."""
    if symbol.kind == "robot":
        lines = list(plays(analysis, symbol.text))
        opening = (span for index, span in lines if analysis.meanings[index].said)
        return next(chain(opening, (span for _, span in lines)), None)
    if symbol.kind == "scene":
        return symbol.span
    if symbol.kind == "parameter":
        return next(reference.span for reference in references(analysis, symbol) if reference.defines)
    definers = analysis.bindings.defined.get(symbol.text, ())
    definer = symbol.definer if symbol.definer is not None else next(iter(definers), None)
    return None if definer is None else analysis.statements[definer].heads[0].span.shifted(analysis.offsets[definer])


def plays(analysis: Analysis, robot: str) -> Iterator[tuple[int, Span]]:
    """Yield the index of each line about a robot, and the span of the robot in it."""
    lines = (
        index
        for index, each in enumerate(in_slices(analysis.statements))
        if each.defines is None and each.kind != "SCENE"
    )
    return _called(analysis, lines, robot)


def scenes_called(analysis: Analysis, name: str) -> Iterator[tuple[int, Span]]:
    """Yield the index of each line `---` with this name, and the span of the name."""
    return _called(analysis, analysis.scenes, name)


def _called(analysis: Analysis, lines: Iterable[int], name: str) -> Iterator[tuple[int, Span]]:
    for index in lines:
        for head in _heads(analysis.statements[index]):
            if head.text == name:
                yield index, head.span.shifted(analysis.offsets[index])


def lines_playing(analysis: Analysis, index: int) -> Iterator[int]:
    """Yield the lines that play a statement, itself or through names that use it, the nearest ones first."""
    reached, waiting = {index}, [index]
    while waiting:
        index = heappop(waiting)
        if analysis.meanings[index].robots:
            yield index
        name = analysis.statements[index].defines
        for user in analysis.bindings.users(name, index)[:MAX_USERS] if name else ():
            if user not in reached and len(reached) < MAX_USERS:
                reached.add(user)
                heappush(waiting, user)


def sections(robots: Robots, name: str) -> Sequence[Span]:
    """Return the spans that name a robot in the text of `improv.toml`."""
    return read_toml(robots.text).positions.named.get(("robots", name), ())


def names_used(placed: Placed) -> list[Token]:
    """Return the name tokens in the movement of a statement, except parameters and poses."""
    text, poses = placed.statement.text, poses_at(placed)
    names = (_cached_names if len(text) <= LONGEST_KEPT else _names_in)(text, _hides_radius(placed.statement))
    return [name for name in names if name.span not in poses]


def _names_in(text: str, hides_radius: bool) -> Sequence[Token]:
    statement = parse_statement(text)
    if hides_radius and statement.as_names:
        statement = statement.as_names
    return tuple(token for token in _movement(statement) if token.type == "NAME" and token.text in statement.uses)


_cached_names = lru_cache(maxsize=2_000)(_names_in)  # lexing takes time, and callers ask for the same names again


def _heads(statement: Statement) -> list[Token]:
    """Return the robots of a statement, the name that it defines, or that of its scene, except reserved words."""
    if not statement.sign or (statement.kind == "EQUAL" and not statement.defines):
        return []
    return [head for head in statement.heads if head.text and head.text not in WORDS]


def _parameters(statement: Statement) -> list[Token]:
    """Return the parameters of a phrase, in its head and in its body."""
    own = {each.name for each in statement.parameters}
    if not own:
        return []
    used = (token for token in _movement(statement) if token.text in own and token.type in ("NAME", "PARAM"))
    return [*(each.token for each in statement.parameters), *used]


def _movement(statement: Statement) -> list[Token]:
    """Return the tokens after the sign."""
    begin = statement.sign.end if statement.sign and statement.kind != "BEAT" else 0
    tokens = (token for token in statement.tokens if token.start >= begin)
    return classified(list(tokens), statement.parameters, _hides_radius(statement))


def _hides_radius(statement: Statement) -> bool:
    return all(word.type != "RADIUS" for word in statement.words)


MAX_ROBOTS = 100
"""The most robots that are searched."""


def performers(analysis: Analysis, index: int) -> dict[Profile, str]:
    """Return the profiles of the robots that play a statement, or of all robots if none does, each with its first
    robot."""
    lines = (analysis.meanings[line].robots for line in lines_playing(analysis, index))
    return by_profile(analysis.opening.config, dict.fromkeys(chain.from_iterable(lines)))


def by_profile(config: Robots, robots: Iterable[str]) -> dict[Profile, str]:
    """Return the profiles of these robots, or of all listed ones if there are none, and the first robot of each."""
    found: dict[Profile, str] = {}
    for robot in islice(tuple(robots) or config.robots, MAX_ROBOTS):
        found.setdefault(config.profile_of(robot), robot)
    return found or {DEFAULT: ""}
