"""The meaning of a program and its errors: the one value that all editor features and the compiler read."""

from __future__ import annotations

import dataclasses
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from heapq import heapify, heappop, heappush, nsmallest
from itertools import count

from improv_core.diagnostics import MOST_SHOWN, Diagnostic, Severity
from improv_core.program.bindings import Bindings, bind
from improv_core.program.diagnosis import diagnose, diagnose_statement, find_scene_hints
from improv_core.program.feasibility import check_casting
from improv_core.program.meaning import Meaning, movement_of, reader_of, understand
from improv_core.program.program import Placed, Program, is_uneven, tempo_of
from improv_core.program.reader import Definition, Reader, Scope
from improv_core.program.sensing import check_senses
from improv_core.robots.config import Robots
from improv_core.score.movement import Movement
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.text import LineIndex, Span

NO_ROBOTS = Robots()
LONGEST_PROGRAM = 10_000_000
"""Characters of a program that is analyzed."""
_TOO_LONG = Diagnostic("syntax", Span(0, 0), f"split this program: it has more than {LONGEST_PROGRAM:,} characters")

_new_ids = count()  # every statement of every document gets its own and keeps it when it moves


@dataclass(frozen=True)
class Analysis(Program):
    """One version of a document, with its errors. Made by `analyze`, or by `edited` from the previous version."""

    @property
    def ok(self) -> bool:
        """Whether it may play: neither the program nor `improv.toml` has an error."""
        return self.cast.ok and all(each.severity is not Severity.ERROR for each in self.diagnostics)

    @cached_property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics of the program, in the order of the text."""
        return (_TOO_LONG,) if len(self.text) > LONGEST_PROGRAM else diagnose(self, self._scene_hints)

    def diagnostics_of(self, index: int) -> Iterator[Diagnostic]:
        """The diagnostics of one statement. Spans count from its start."""
        return diagnose_statement(self, index, self._scene_hints)

    @cached_property
    def _scene_hints(self) -> Mapping[int, Diagnostic]:
        return find_scene_hints(self)

    def movement(self, placed: Placed, node: Node) -> Movement:
        """The movement of a node of a statement, as its first robot plays it."""
        return movement_of(node, self._scope(placed.index), len(placed.meaning.robots))

    def reader(self, index: int, robot: int = 0) -> Reader:
        """A reader that has read the movement of a statement, as one of its robots plays it."""
        return reader_of(self.meanings[index], self._scope(index), self.statement_ids[index], robot)

    def edited(self, start: int, end: int, text: str, at_once: int | None = None) -> Analysis:
        """The analysis after `text` has replaced the text from `start` to `end`. Costs what the edit touches.

        If more than `at_once` other statements depend on the edit, the rest of them wait for `settled`.
        """
        lines = self.lines.edited(start, end, text)
        if max(len(self.text), len(lines.text)) > LONGEST_PROGRAM:
            return analyze(lines.text, self.cast)
        growth = len(text) - (end - start)
        # The statement before the first one touched may lack a bracket and continue into the new text.
        first = max(bisect_right(self.offsets, start) - 2, 0)
        begin = lines.start(lines.position(self.offsets[first]).line) if self.offsets[first:] else 0
        after, offsets, pieces = len(self.offsets), [], []
        for offset, piece in split(lines.text, begin if first else 0):
            # If a statement after the edit starts where one started before, nothing changes from there on.
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
            return _with_others(self, lines, all_offsets, first, statements).settled(at_once)
        # Statements came or went. All indices change, but unchanged statements keep their meanings.
        return _assembled(
            lines,
            all_offsets,
            [*self.statements[:first], *statements, *self.statements[after:]],
            [*self.statement_ids[:first], *(next(_new_ids) for _ in statements), *self.statement_ids[after:]],
            self.cast,
            self,
        )

    def settled(self, most: int | None = None, until: int | None = None) -> Analysis:
        """The analysis in which statements that wait are understood: up to `most` of them, up to the offset `until`.

        They are taken in the order of the text, so that those near an edit come first.
        """
        last = len(self.offsets) if until is None else bisect_right(self.offsets, until) - 1
        if not self.waiting or self.waiting[0] > last:
            return self
        meanings, waiting = list(self.meanings), list(self.waiting)
        again: list[int] = []
        while waiting and waiting[0] <= last and (most is None or len(again) < most):
            index = heappop(waiting)
            scope = _scope(self.statements[index], index, self.bindings, meanings)
            if meanings[index].scope != tuple(scope.values()):
                for user in self._understand(index, scope, meanings):
                    heappush(waiting, user)
                again.append(index)
        return self._with_meanings(meanings, again, waiting, self.tempo)

    def _understand(self, index: int, scope: Scope, meanings: list[Meaning]) -> Iterator[int]:
        """Put what a statement means now into `meanings`. Yields the statements that use what it defines or defined."""
        before = meanings[index]
        now = meanings[index] = understand(self.statements[index], self.statement_ids[index], scope)
        for name in {each.name for each in (before.definition, now.definition) if each}:
            yield from self.bindings.users(name, index)

    def _with_meanings(
        self, meanings: Sequence[Meaning], again: Sequence[int], waiting: Sequence[int], tempo_before: Fraction
    ) -> Analysis:
        """The analysis with other meanings of the statements `again`."""
        tempo = tempo_of(self.tempos, meanings)
        known, doubtful = (self.infeasible, again) if tempo == tempo_before else ({}, range(len(meanings)))
        return dataclasses.replace(
            self,
            meanings=meanings,
            faulty=self.faulty.difference(again).union(index for index in again if _is_faulty(meanings[index])),
            uneven=self.uneven.difference(again).union(index for index in again if is_uneven(meanings[index])),
            infeasible=_infeasible(meanings, self.statements, self.cast, tempo, known, doubtful),
            waiting=waiting,
        )

    def with_robots(self, robots: Robots) -> Analysis:
        """The same program for other robots."""
        return dataclasses.replace(
            self, cast=robots, infeasible=_infeasible(self.meanings, self.statements, robots, self.tempo)
        )

    def _scope(self, index: int) -> Scope:
        return _scope(self.statements[index], index, self.bindings, self.meanings)


def analyze(text: str, robots: Robots = NO_ROBOTS) -> Analysis:
    """Analyze a whole program for these robots; nothing of one that is too long. Never raises."""
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
    """The analysis of these statements. Meanings from `old` are kept if their scope is the same."""
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
    tempos = _signed("BEAT", statements)
    tempo = tempo_of(tempos, meanings)
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
        scenes=_signed("SCENE", statements),
        faulty=frozenset(index for index, meaning in enumerate(meanings) if _is_faulty(meaning)),
        uneven=frozenset(index for index, meaning in enumerate(meanings) if is_uneven(meaning)),
        cast=cast,
        infeasible=_infeasible(meanings, statements, cast, tempo, infeasible, changed),
    )


def _with_others(
    old: Analysis, lines: LineIndex, offsets: Sequence[int], first: int, others: Sequence[Statement]
) -> Analysis:
    """The analysis with these statements replaced from `first` on. Indices stay, and what depends on them waits."""
    changed = dict(enumerate(others, first))
    statements, statement_ids = list(old.statements), list(old.statement_ids)
    statements[first : first + len(others)] = others
    statement_ids[first : first + len(others)] = [next(_new_ids) for _ in others]
    signs = {_sign(each) for index, statement in changed.items() for each in (statement, old.statements[index])}
    replaced = dataclasses.replace(
        old,
        lines=lines,
        offsets=offsets,
        statements=statements,
        statement_ids=statement_ids,
        bindings=old.bindings.edited({index: old.statements[index] for index in changed}, changed),
        tempos=_signed("BEAT", statements) if "BEAT" in signs else old.tempos,
        scenes=_signed("SCENE", statements) if "SCENE" in signs else old.scenes,
    )
    meanings, waiting = list(old.meanings), [*old.waiting]
    for index, statement in changed.items():
        scope = _scope(statement, index, replaced.bindings, meanings)
        waiting += replaced._understand(index, scope, meanings)
    heapify(waiting)
    return replaced._with_meanings(meanings, [*changed], waiting, old.tempo)


def _infeasible(
    meanings: Sequence[Meaning],
    statements: Sequence[Statement],
    cast: Robots,
    tempo: Fraction,
    known: Mapping[int, tuple[Diagnostic, ...]] | None = None,
    doubtful: Iterable[int] | None = None,
) -> Mapping[int, tuple[Diagnostic, ...]]:
    """What robots can't do, by statement: `known`, with the `doubtful` statements (default: all) checked again.

    Only the first `MOST_SHOWN` are sure to have messages and fixes.
    """
    found = dict(known or {})

    def check(index: int, brief: bool) -> tuple[Diagnostic, ...]:
        statement, meaning = statements[index], meanings[index]
        problems = check_casting(statement, meaning, cast, tempo, brief) if meaning.robots else ()
        if statement.has_senses or meaning.is_open:
            problems = (*problems, *check_senses(statement, meaning, cast))
        return problems

    for index in range(len(statements)) if doubtful is None else doubtful:
        if problems := check(index, brief=len(found) >= MOST_SHOWN):
            found[index] = problems
        else:
            found.pop(index, None)
    for index in nsmallest(MOST_SHOWN, found):
        if not all(each.message for each in found[index]):
            found[index] = check(index, brief=False)
    return found


def _scope(statement: Statement, index: int, bindings: Bindings, meanings: Sequence[Meaning]) -> Scope:
    scope = {}
    for name in statement.uses:
        definer = bindings.definer(name, index)
        scope[name] = None if definer is None else meanings[definer].definition
    return scope


def _signed(sign: str, statements: Sequence[Statement]) -> Sequence[int]:
    """The statements with this sign."""
    return [index for index, statement in enumerate(statements) if _sign(statement) == sign]


def _sign(statement: Statement) -> str:
    return statement.sign.type if statement.sign else ""


def _is_faulty(meaning: Meaning) -> bool:
    return bool(meaning.diagnostics or meaning.unresolved or meaning.misused)
