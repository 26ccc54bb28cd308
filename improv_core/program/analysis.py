"""What a program means and what is wrong with it: the one value that all editor features and the compiler read."""

from __future__ import annotations

import dataclasses
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import count, islice

from improv_core.diagnostics import MOST_SHOWN, Diagnostic, Edit, Fix, Related, Severity, replace
from improv_core.program.bindings import Bindings, bind
from improv_core.program.feasibility import check_casting
from improv_core.program.meaning import Definition, Meaning, Scope, movement_of, understand
from improv_core.robots.config import Robots
from improv_core.score import movement
from improv_core.score.movement import Movement
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.text import LineIndex, Span

DEFAULT_TEMPO = Fraction(60)
NO_ROBOTS = Robots()
LONGEST_PROGRAM = 10_000_000
"""Characters of a program that is analyzed."""
_TOO_LONG = Diagnostic("syntax", Span(0, 0), f"split this program: it has more than {LONGEST_PROGRAM:,} characters")

_new_ids = count()  # every statement of every document gets its own, and keeps it wherever it moves


@dataclass(frozen=True, slots=True)
class Placed:
    """A statement, its place among the others and its offset in the text."""

    index: int
    start: int
    statement: Statement
    meaning: Meaning

    @property
    def span(self) -> Span:
        return Span(self.start, self.start + len(self.statement.text))


@dataclass(frozen=True)
class Analysis:
    """One version of a document, understood. Made by `analyze`, and by `edited` from the version before.

    The sequences run side by side, one entry for each statement: its offset, tree, number and meaning. `tempos` has
    the indices of the statements with a tempo, `faulty` those of the statements whose meaning has diagnostics or
    undefined names. `infeasible` says, by index, what the robots of a statement can't do.
    """

    lines: LineIndex
    offsets: Sequence[int]
    statements: Sequence[Statement]
    statement_ids: Sequence[int]
    meanings: Sequence[Meaning]
    bindings: Bindings
    tempos: Sequence[int]
    faulty: frozenset[int]
    cast: Robots  # what improv.toml says
    infeasible: Mapping[int, tuple[Diagnostic, ...]]

    @property
    def text(self) -> str:
        return self.lines.text

    @property
    def ok(self) -> bool:
        """Whether it may play: neither it nor `improv.toml` has an error."""
        return self.cast.ok and all(each.severity is not Severity.ERROR for each in self.diagnostics)

    @property
    def tempo(self) -> Fraction:
        """Beats per minute."""
        return _tempo(self.tempos, self.meanings)

    @cached_property
    def robots(self) -> Mapping[str, Movement]:
        """What each robot plays, in order of appearance."""
        plays: dict[str, list[Movement]] = {}
        for number, meaning in zip(self.statement_ids, self.meanings, strict=True):
            for robot in meaning.robots:
                plays.setdefault(robot, []).append(movement.use(meaning.movement, None, number))
        return {robot: movement.series(parts) for robot, parts in plays.items()}

    @cached_property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics of the program, in the order of the text."""
        if len(self.text) > LONGEST_PROGRAM:
            return (_TOO_LONG,)
        serious = self.faulty.union(self.tempos[1:], self.infeasible)
        indices = [*sorted(serious), *sorted(self.bindings.unused - serious)]
        told = ((index, each) for index in indices for each in self._said_of(index))
        found = [each.shifted(self.offsets[index]) for index, each in islice(told, MOST_SHOWN)]
        if next_one := next(told, None):
            found.append(self._more(indices[indices.index(next_one[0]) :]))
        return tuple(sorted(found, key=lambda diagnostic: diagnostic.span))

    def statement_at(self, offset: int) -> Placed | None:
        """The statement that a cursor at `offset` touches."""
        index = bisect_right(self.offsets, offset) - 1
        placed = self.placed(index) if index >= 0 else None
        return placed if placed and placed.span.holds(offset) else None

    def placed(self, index: int) -> Placed:
        return Placed(index, self.offsets[index], self.statements[index], self.meanings[index])

    def definition(self, name: str, before: int) -> Definition | None:
        """What a name stands for where the statement with this index stands."""
        index = self.bindings.definer(name, before)
        return None if index is None else self.meanings[index].definition

    def movement(self, placed: Placed, node: Node) -> Movement:
        """What a part of a statement means where it stands."""
        return movement_of(node, self._scope(placed.index))

    def edited(self, start: int, end: int, text: str) -> Analysis:
        """The analysis after the text from `start` to `end` has been replaced; costs what the edit touches."""
        lines = self.lines.edited(start, end, text)
        if max(len(self.text), len(lines.text)) > LONGEST_PROGRAM:
            return analyze(lines.text, self.cast)
        growth = len(text) - (end - start)
        # The statement before the first one touched may lack a bracket, and go on into what now stands there.
        first = max(bisect_right(self.offsets, start) - 2, 0)
        begin = lines.start(lines.position(self.offsets[first]).line) if self.offsets[first:] else 0
        after, offsets, pieces = len(self.offsets), [], []
        for offset, piece in split(lines.text, begin if first else 0):
            # Where a statement begins behind the edit as one did before, all goes on as before.
            if offset >= start + len(text):
                known = bisect_left(self.offsets, offset - growth)
                if offset - growth > end and known < after and self.offsets[known] == offset - growth:
                    after = known
                    break
            offsets.append(offset)
            pieces.append(piece)
        rest = [offset + growth for offset in self.offsets[after:]] if growth else self.offsets[after:]
        all_offsets = [*self.offsets[:first], *offsets, *rest]
        statements = [parse_statement(piece) for piece in pieces]
        while statements and first < after and statements[0] is self.statements[first]:
            del statements[0]
            first += 1
        while statements and first < after and statements[-1] is self.statements[after - 1]:
            del statements[-1]
            after -= 1
        if len(statements) == after - first:
            return _with_others(self, lines, all_offsets, first, statements)
        # Statements came or went: every index changes, but what is unchanged is not understood again.
        return _assembled(
            lines,
            all_offsets,
            [*self.statements[:first], *statements, *self.statements[after:]],
            [*self.statement_ids[:first], *(next(_new_ids) for _ in statements), *self.statement_ids[after:]],
            self.cast,
            self,
        )

    def with_robots(self, robots: Robots) -> Analysis:
        """The same program for other robots."""
        return dataclasses.replace(
            self, cast=robots, infeasible=_infeasible(self.meanings, self.statements, robots, self.tempo)
        )

    def _scope(self, index: int) -> Scope:
        return _scope(self.statements[index], index, self.bindings, self.meanings)

    def _said_of(self, index: int) -> Iterator[Diagnostic]:
        """The diagnostics of one statement; spans count from its start."""
        statement, meaning = self.statements[index], self.meanings[index]
        yield from meaning.diagnostics
        yield from self.infeasible.get(index, ())
        if index in self.bindings.unused:
            head = statement.heads[0]
            message = f"use `{head.text}` below, or remove this line: nothing plays it"
            line = self._whole_line(index)
            yield Diagnostic("unused-name", head.span, message, (Fix("Remove the definition", (Edit(line, ""),)),))
        if statement.sign and statement.sign.type == "BEAT" and index != self.tempos[0]:
            first = self.offsets[self.tempos[0]]
            message = f"remove this `beat`: line {self._line(self.tempos[0])} has one already"
            related = Related(self._relative(Span(first, first + len("beat")), index), "the first `beat`")
            fixes = (Fix("Remove it", (Edit(self._whole_line(index), ""),)),)
            yield Diagnostic("duplicate-beat", Span(0, len(statement.text)), message, fixes, (related,))
        for node in meaning.unresolved:
            yield self._unresolved(index, node)

    def _more(self, hidden: Sequence[int]) -> Diagnostic:
        """What stands for the diagnostics of the statements that are not shown."""
        tempos = frozenset(self.tempos[1:])
        has_errors = any(
            not self.meanings[index].ok
            or index in tempos
            or any(each.severity is Severity.ERROR for each in self.infeasible.get(index, ()))
            for index in hidden
        )
        lines = "line is" if len(hidden) == 1 else "lines are"
        message = f"fix what is marked first: {len(hidden):,} more {lines} wrong, and not marked yet"
        return Diagnostic("more-errors" if has_errors else "more-hints", self.placed(hidden[0]).span, message)

    def _unresolved(self, index: int, node: nodes.Name) -> Diagnostic:
        name = node.text
        if name not in self.bindings.defined:
            return self._unknown(node)
        later = self.bindings.defined[name][0]
        head = self.statements[later].heads[0].span.shifted(self.offsets[later])
        related = Related(self._relative(head, index), f"`{name}` is defined here")
        line = self._line(later)
        if later == index:
            message = f"define `{name}` above this line (line {line}) before using it in its own definition"
            return Diagnostic("used-before-definition", node.span, message, (), (related,))
        message = f"move the definition of `{name}` (line {line}) above this line"
        here = self._relative(Span(self.offsets[index], self.offsets[index]), index)
        above = self.lines.position(self.offsets[index]).line
        line_end = self.text[self.lines.end(above) : self.lines.start(above + 1)]
        moved = (Edit(here, self.statements[later].text + line_end), Edit(self._whole_line(later, index), ""))
        fixes = (Fix(f"Move the definition of {name} up", moved),)
        return Diagnostic("used-before-definition", node.span, message, fixes, (related,))

    def _unknown(self, node: nodes.Name) -> Diagnostic:
        name = node.text
        near = self.bindings.nearest(name)
        if near is None:
            return Diagnostic("unknown-name", node.span, f"`{name}` is not known: define it above: `{name} = …`")
        message = f"`{name}` is not known: did you mean `{near}`?"
        return Diagnostic("unknown-name", node.span, message, replace(f"Write {near}", node.span, near))

    def _line(self, index: int) -> int:
        """The line a statement begins in, as people count."""
        return self.lines.position(self.offsets[index]).line + 1

    def _whole_line(self, index: int, seen_from: int | None = None) -> Span:
        """The lines of a statement with their end, to be removed; counted from the start of a statement."""
        start = self.offsets[index]
        first = self.lines.position(start).line
        last = self.lines.position(start + len(self.statements[index].text)).line
        whole = Span(self.lines.start(first), self.lines.start(last + 1))
        return self._relative(whole, index if seen_from is None else seen_from)

    def _relative(self, span: Span, index: int) -> Span:
        return span.shifted(-self.offsets[index])


def analyze(text: str, robots: Robots = NO_ROBOTS) -> Analysis:
    """Read a whole program, for these robots; nothing of one that is too long. Never raises."""
    offsets, statements = [], []
    for offset, piece in split(text) if len(text) <= LONGEST_PROGRAM else ():
        offsets.append(offset)
        statements.append(parse_statement(piece))
    return _assembled(LineIndex(text), offsets, statements, [next(_new_ids) for _ in statements], robots)


def _assembled(
    lines: LineIndex,
    offsets: Sequence[int],
    statements: Sequence[Statement],
    statement_ids: Sequence[int],
    cast: Robots,
    old: Analysis | None = None,
) -> Analysis:
    """All statements in their order; what `old` knows of them is kept where their scope is the same."""
    known = dict(zip(old.statement_ids, old.meanings, strict=True)) if old else {}
    current: dict[str, Definition] = {}
    meanings: list[Meaning] = []
    for statement, statement_id in zip(statements, statement_ids, strict=True):
        scope = {name: current.get(name) for name in statement.uses}
        meaning = known.get(statement_id)
        if meaning is None or meaning.scope != tuple(scope.values()):
            meaning = understand(statement, statement_id, scope)
        meanings.append(meaning)
        if meaning.definition:
            current[meaning.definition.name] = meaning.definition
    tempos = _tempos(statements)
    tempo = _tempo(tempos, meanings)
    infeasible: dict[int, tuple[Diagnostic, ...]] = {}
    changed: Iterable[int] = range(len(statements))
    if old and old.tempo == tempo:
        found = {old.statement_ids[index]: diagnostics for index, diagnostics in old.infeasible.items()}
        infeasible = {index: found[each] for index, each in enumerate(statement_ids) if each in found}
        changed = (index for index, each in enumerate(statement_ids) if known.get(each) is not meanings[index])
    return Analysis(
        lines=lines,
        offsets=offsets,
        statements=statements,
        statement_ids=statement_ids,
        meanings=meanings,
        bindings=bind(statements),
        tempos=tempos,
        faulty=frozenset(index for index, meaning in enumerate(meanings) if _is_faulty(meaning)),
        cast=cast,
        infeasible=_infeasible(meanings, statements, cast, tempo, infeasible, changed),
    )


def _with_others(
    old: Analysis, lines: LineIndex, offsets: Sequence[int], first: int, others: Sequence[Statement]
) -> Analysis:
    """The analysis with as many other statements from `first` on: indices stay, and only what depends is read again."""
    changed = dict(enumerate(others, first))
    statements, statement_ids = list(old.statements), list(old.statement_ids)
    statements[first : first + len(others)] = others
    statement_ids[first : first + len(others)] = [next(_new_ids) for _ in others]
    bindings = old.bindings.edited({index: old.statements[index] for index in changed}, changed)
    meanings = list(old.meanings)
    again = _understand_again(meanings, statements, statement_ids, bindings, changed)
    tempos = old.tempos
    if any(_sets_tempo(statement) or index in tempos for index, statement in changed.items()):
        tempos = _tempos(statements)
    tempo = _tempo(tempos, meanings)
    known, doubtful = (old.infeasible, again) if tempo == old.tempo else ({}, range(len(statements)))
    return dataclasses.replace(
        old,
        lines=lines,
        offsets=offsets,
        statements=statements,
        statement_ids=statement_ids,
        meanings=meanings,
        bindings=bindings,
        tempos=tempos,
        faulty=old.faulty.difference(again).union(index for index in again if _is_faulty(meanings[index])),
        infeasible=_infeasible(meanings, statements, old.cast, tempo, known, doubtful),
    )


def _understand_again(
    meanings: list[Meaning],
    statements: Sequence[Statement],
    statement_ids: Sequence[int],
    bindings: Bindings,
    changed: Collection[int],
) -> list[int]:
    """Understand what has changed, and in the order of the text all that depends on it; their indices."""
    again = []
    waiting = list(changed)
    heapify(waiting)
    done = -1
    while waiting:
        index = heappop(waiting)
        if index == done:
            continue
        done = index
        before = meanings[index]
        scope = _scope(statements[index], index, bindings, meanings)
        if index not in changed and before.scope == tuple(scope.values()):
            continue
        meaning = meanings[index] = understand(statements[index], statement_ids[index], scope)
        again.append(index)
        for definition in (before.definition, meaning.definition):
            if definition:
                for user in bindings.users(definition.name, index):
                    heappush(waiting, user)
    return again


def _infeasible(
    meanings: Sequence[Meaning],
    statements: Sequence[Statement],
    cast: Robots,
    tempo: Fraction,
    known: Mapping[int, tuple[Diagnostic, ...]] | None = None,
    doubtful: Iterable[int] | None = None,
) -> Mapping[int, tuple[Diagnostic, ...]]:
    """What robots can't do, by statement: as is `known`, with the `doubtful` ones (all, if not given) checked again."""
    found = dict(known or {})
    for index in range(len(statements)) if doubtful is None else doubtful:
        problems = check_casting(statements[index], meanings[index], cast, tempo) if meanings[index].robots else ()
        if problems:
            found[index] = problems
        else:
            found.pop(index, None)
    return found


def _scope(statement: Statement, index: int, bindings: Bindings, meanings: Sequence[Meaning]) -> Scope:
    definers = {name: bindings.definer(name, index) for name in statement.uses}
    return {name: None if at is None else meanings[at].definition for name, at in definers.items()}


def _tempos(statements: Sequence[Statement]) -> Sequence[int]:
    return [index for index, statement in enumerate(statements) if _sets_tempo(statement)]


def _tempo(tempos: Sequence[int], meanings: Sequence[Meaning]) -> Fraction:
    return (meanings[tempos[0]].tempo if tempos else None) or DEFAULT_TEMPO


def _sets_tempo(statement: Statement) -> bool:
    return bool(statement.sign and statement.sign.type == "BEAT")


def _is_faulty(meaning: Meaning) -> bool:
    return bool(meaning.diagnostics or meaning.unresolved)
