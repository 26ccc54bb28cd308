"""The meaning of one statement, given the definitions of its names, and its errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from improv_core.diagnostics import Diagnostic, Severity, replace
from improv_core.program.definitions import NOTHING, Definition, Phrase, Scope, Takes
from improv_core.program.measures import without_units, wrong_measures
from improv_core.program.misuse import check_conditions, misplaced_poses
from improv_core.program.naming import is_reserved, robots_named
from improv_core.program.opening import OPENING, Said, said_by
from improv_core.program.reader import Reader, Reading, takes
from improv_core.program.unreachable import unperformed
from improv_core.score.algebra import items_of
from improv_core.score.movement import NOWHERE, Movement
from improv_core.syntax import nodes
from improv_core.syntax.descent import TooDeepError
from improv_core.syntax.gather import gather
from improv_core.syntax.nodes import Call, Name, Node, Parameter, Statement
from improv_core.syntax.vocabulary import RADIUS, WORDS
from improv_core.text import Span
from improv_core.values import value

FOR_ALL = frozenset({"BEAT", *OPENING})
"""The kinds of statements on which all others may depend."""


@value(frozen=True, slots=True, eq=False)
class Meaning:
    """The meaning of a statement in a scope, which decides how the `statement` is read. Spans count from its start.

    `body` is its movement with the arguments of phrases in their places. `movement` is the first robot's, and `others`
    are those of the other robots, if `canon` makes them differ. `unresolved` are the names that nothing above defines,
    and `misused` those whose arguments don't match their heads. Their diagnostics depend on other lines. `said` is the
    content of a line of the opening. If it isn't `is_known`, the statement waits to be understood.
    """

    statement: Statement
    scope: tuple[Definition | None, ...]
    movement: Movement
    diagnostics: tuple[Diagnostic, ...]
    unresolved: tuple[Name, ...] = ()
    misused: tuple[Name | Call, ...] = ()
    tempo: Fraction | None = None
    definition: Definition | None = None
    robots: tuple[str, ...] = ()
    body: Node | None = None
    others: tuple[Movement, ...] = ()
    said: Said | None = None
    is_known: bool = True

    @property
    def ok(self) -> bool:
        """True if the statement itself has no error."""
        return not (
            self.unresolved or self.misused or any(each.severity is Severity.ERROR for each in self.diagnostics)
        )

    @property
    def is_faulty(self) -> bool:
        """True if it has diagnostics, or names that are undefined or have wrong arguments."""
        return bool(self.diagnostics or self.unresolved or self.misused)

    @property
    def parts(self) -> Sequence[tuple[str, Movement]]:
        """Each robot with its movement."""
        movements = (self.movement, *self.others) if self.others else (self.movement,) * len(self.robots)
        return list(zip(self.robots, movements, strict=True))


def understand(statement: Statement, statement_id: int, scope: Scope) -> Meaning:
    """Return the meaning of the statement with this ID. Never raises."""
    bound = tuple(scope.values())
    statement = _as_read(statement, bound)
    diagnostics = list(statement.diagnostics)
    sign = statement.sign
    if not sign:  # already reported: one error, one message
        body = _gathered(statement.body, scope, []) if statement.body else None
        return Meaning(statement, bound, NOTHING, tuple(diagnostics), body=body)
    if sign.type in OPENING:
        said = said_by(statement, diagnostics)
        return Meaning(statement, bound, NOTHING, tuple(diagnostics), said=said)
    plays = sign.type == "DOLLAR"
    robots = robots_named(statement.heads, diagnostics, ", or write it after `$`") if plays else ()
    uses_phrases = bool([each for each in bound if each and (each.phrase or each.takes)])
    body = _gathered(statement.body, scope, diagnostics) if statement.body and uses_phrases else statement.body
    reader = Reader(scope, statement_id, Reading(0, len(robots)))
    meant, definition, tempo = NOTHING, None, None
    others: list[Movement] = []
    if body and not statement.parameters:
        meant = reader.movement(body)
        if robots and ("to" in scope or meant.body_words.loose_poses):
            diagnostics += misplaced_poses(body, reader.movement_made)
        if statement.has_voices or isinstance(meant.duration, float) or reader.calls:  # otherwise all of it plays
            diagnostics += unperformed(body, reader)
        if statement.by_robot:
            others = [movement_of(body, scope, len(robots), statement_id, robot) for robot in range(1, len(robots))]
    if statement.number:
        tempo = reader.number(statement.number, "the tempo")
    if sign.type == "EQUAL":
        _check_head(statement, diagnostics)
        phrase = _phrase(statement, body, reader, diagnostics) if statement.parameters else None
        items = reader.items(body) if body and not phrase else None
        if statement.defines:
            other_items = None if items == (items_of(meant), statement_id) else items
            definition = Definition(statement.defines, statement_id, meant, other_items, phrase)
    diagnostics += reader.found
    unresolved: tuple[Name, ...] = ()
    misused: tuple[Name | Call, ...] = ()
    wrong: list[Diagnostic] = []
    if body:
        if None in bound:
            unresolved = tuple(each for each in nodes.names(body) if each.text in scope and scope[each.text] is None)
        tokens = statement.tokens if unresolved or statement.has_measures else ()
        if statement.has_measures and not statement.diagnostics:  # else they may follow from the first
            known = {*(name for name, found in scope.items() if found), *(each.name for each in statement.parameters)}
            wrong = list(wrong_measures(body, tokens, known))
            diagnostics += wrong
        if unresolved:
            unresolved = tuple(without_units(wrong, unresolved, tokens))
        if (uses_phrases or statement.has_arguments) and not statement.diagnostics:  # else they follow from the first
            misused = tuple(_misused(body, scope, statement.parameters))
        if sign.type == "EQUAL" and statement.by_robot:
            diagnostics += _misplaced(body)
        if statement.has_senses and not statement.diagnostics:
            diagnostics += check_conditions(body)
    reader.reading.expansions.clear()  # a cycle of references: without it, memory is free at once
    found = tuple(diagnostics)
    return Meaning(statement, bound, meant, found, unresolved, misused, tempo, definition, robots, body, tuple(others))


def _as_read(statement: Statement, bound: Sequence[Definition | None]) -> Statement:
    """Return a statement as it is read with these meanings of the names that it uses: one may be called `radius`."""
    if statement.as_names and bound[statement.uses.index(RADIUS)]:
        return statement.as_names
    return statement


def not_understood(
    statement: Statement, statement_id: int, scope: Scope, definition: Definition | None = None
) -> Meaning:
    """Return the meaning of a statement before it is understood: only its syntax. Only a tempo and the opening are
    understood at once, because all lines depend on them."""
    if statement.kind in FOR_ALL:
        return understand(statement, statement_id, scope)
    bound = tuple(scope.values())
    statement = _as_read(statement, bound)
    return Meaning(
        statement,
        bound,
        NOTHING,
        statement.diagnostics,
        definition=definition,
        body=statement.body,
        is_known=False,
    )


def movement_of(node: Node, scope: Scope, robots: int, statement_id: int = NOWHERE, robot: int = 0) -> Movement:
    """Return the movement of a node of a statement, in its scope, as one of the robots of its line plays it."""
    return Reader(scope, statement_id, Reading(robot, robots)).movement(node)


def reader_of(meaning: Meaning, scope: Scope, statement_id: int, robot: int) -> Reader:
    """Return a reader that has read the movement of a statement again, as one of its robots plays it."""
    reader = Reader(scope, statement_id, Reading(robot, len(meaning.robots)))
    if meaning.body:
        reader.movement(meaning.body)
    return reader


def _gathered(body: Node, scope: Scope, diagnostics: list[Diagnostic]) -> Node | None:
    """Return the movement of a statement, in which each phrase has its arguments."""
    taking = {name: len(found.phrase.movements) for name, found in scope.items() if found and found.phrase}
    parts, poses = (
        {name for name, found in scope.items() if found and found.takes is kind}
        for kind in (Takes.MOVEMENT, Takes.POSE)
    )
    try:
        takes_any = parts or poses or any(taking.values())
        return gather(body, lambda name: taking.get(name, 0), parts, poses) if takes_any else body
    except TooDeepError as error:
        diagnostics.append(Diagnostic("too-deep", error.span, str(error)))
        return None


def _check_head(statement: Statement, diagnostics: list[Diagnostic]) -> None:
    """Report reserved words, and parameters with the same name, in the head of a definition."""
    for head in statement.heads:
        is_reserved(head, diagnostics)
    names: set[str] = set()
    for parameter in statement.parameters:
        token = parameter.token
        if not is_reserved(token, diagnostics) and token.text in names:
            message = f"another parameter is called `{token.text}` too: choose another name"
            diagnostics.append(Diagnostic("duplicate-parameter", token.span, message))
        names.add(token.text)


def _phrase(statement: Statement, body: Node | None, reader: Reader, diagnostics: list[Diagnostic]) -> Phrase | None:
    """Return the phrase that a statement defines. Nodes that depend on no parameter are read here, once."""
    parameters = statement.parameters
    if body is None:
        return None
    movements = {each.name for each in parameters if not each.is_number}
    if not any(each.severity is Severity.ERROR for each in statement.diagnostics):
        mentioned = set(nodes.mentions(body, movements))
        unused = [each for each in parameters if each.name not in mentioned and each.name not in WORDS]
        head, named = statement.heads[0], "_".join(each.name for each in parameters)  # `let x =`, or `my x =`
        named = named if head.text in ("let", "def", "define", "set", "var", "to") else f"{head.text}_{named}"
        whole = Span(head.start, parameters[-1].token.end)
        is_name = len(unused) == len(parameters) and not movements
        fixes = replace(f"Change to {named}", whole, named, guess=True) if is_name else ()
        advice = f"use it, or write `{named} = …`" if is_name else "use it or remove it here"
        for each in unused:
            message = f"the movement does not use `{each.name}`: {advice}"
            diagnostics.append(Diagnostic("unused-name", each.token.span, message, fixes))
    dependent = _dependent(body, movements)
    diagnostics += _settled(body, dependent, reader)
    return Phrase(parameters, body, reader.scope, reader, len(dependent))


def _dependent(body: Node, movements: set[str]) -> set[int]:
    """Return the nodes that mention a parameter, by `id`."""
    dependent: set[int] = set()

    def depends(node: Node) -> bool:
        inside = [depends(child) for child in nodes.children(node)]
        own = isinstance(node, Name) and node.text in movements
        if own or any(inside) or any(any(number.parameters) for number in nodes.numbers(node)):
            dependent.add(id(node))
            return True
        return False

    depends(body)
    return dependent


def _settled(node: Node, dependent: set[int], reader: Reader) -> Iterator[Diagnostic]:
    """Read the nodes that mention no parameter. Yield the hints about them."""
    if id(node) not in dependent:
        reader.movement(node)
        yield from unperformed(node, reader)
        return
    reader.numbers(node)
    for child in nodes.children(node):
        yield from _settled(child, dependent, reader)


def _misused(body: Node, scope: Scope, parameters: Sequence[Parameter]) -> Iterator[Name | Call]:
    """Yield the uses of names and parameters whose arguments don't match their heads."""
    own = {each.name for each in parameters}
    called: set[int] = set()
    for node in nodes.nodes(body):
        if isinstance(node, Call):
            called.add(id(node.name))
            found = scope.get(node.name.text)
            if node.name.text in own or (found and (found.takes or not takes(found.phrase, node))):
                yield node
        elif isinstance(node, Name) and node.text not in own and id(node) not in called:
            found = scope.get(node.text)
            if found and (found.phrase or found.takes):
                yield node


def _misplaced(body: Node) -> Iterator[Diagnostic]:
    for node in nodes.nodes(body):
        if isinstance(node, nodes.Apply) and WORDS[node.word.text].by_robot:
            message = f"`{node.word.text}` needs the robots of a line: write it after `$`, before the name"
            yield Diagnostic("misplaced-canon", node.word.span, message)
