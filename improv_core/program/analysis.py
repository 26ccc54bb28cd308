"""The meaning of a program and its errors: the one value that all editor features and the compiler read."""

from __future__ import annotations

import dataclasses
import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from heapq import heappop, heappush
from itertools import count, islice

from improv_core.diagnostics import Diagnostic, Severity
from improv_core.plain import message
from improv_core.program.bindings import Bindings, bind
from improv_core.program.definitions import Definition, ReadNodes, Scope, predefined
from improv_core.program.diagnosis import diagnose, diagnose_statement
from improv_core.program.feasibility import check_casting, check_names
from improv_core.program.idle import Alone, Idle, find_alone, find_idle
from improv_core.program.limbs import check_bodies, check_pose_names, check_units
from improv_core.program.meaning import FOR_ALL, Meaning, movement_of, not_understood, reader_of, understand
from improv_core.program.opening import OPENING, Opening, check_kind
from improv_core.program.program import Placed, Program, Unusual, opening_of
from improv_core.program.sensing import check_senses
from improv_core.robots.config import Robots
from improv_core.score.bounds import is_measured
from improv_core.score.movement import Movement
from improv_core.slices import checkpoint, in_slices
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.text import LineIndex, Span, difference
from improv_core.values import value

NO_ROBOTS = Robots()
LONGEST_PROGRAM = 10_000_000
"""The most characters of a program that is analyzed."""
MAX_PARSED = 5_000
"""The most characters of edited statements that are parsed before the next key is read: about 10 ms."""
_TOO_LONG = Diagnostic("syntax", Span(0, 0), f"split this program: it has more than {LONGEST_PROGRAM:,} characters")

_new_ids = count()  # every statement of every document has an ID of its own and keeps it when it moves


@value(frozen=True, slots=False)
class Analysis(Program):
    """One version of a document, with its errors. Made by `analyze`, or by `edited` from the previous version.

    If it has an `earlier` version, its own text hasn't been read yet: it has no statements, and `settled` makes them
    from those of the earlier version.
    """

    earlier: Analysis | None = None

    @property
    def ok(self) -> bool:
        """True if it may play: neither the program nor `improv.toml` has an error."""
        return self.config.ok and all(each.severity is not Severity.ERROR for each in self.diagnostics)

    @cached_property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics of the program, in the order of the text."""
        return (_TOO_LONG,) if len(self.text) > LONGEST_PROGRAM else diagnose(self, self._idle, self._alone)

    def diagnostics_of(self, index: int) -> Iterator[Diagnostic]:
        """The diagnostics of one statement. Spans count from its start."""
        return diagnose_statement(self, index, self._idle, self._alone)

    @cached_property
    def lacks(self) -> Mapping[int, str]:
        """The first error in each statement whose movement lacks something because of it, or in a definition that the
        statement uses: "`lft` in line 3 is not defined"."""
        found: dict[int, str] = {}
        for fault in in_slices(sorted(self.unusual.faulty)):
            meaning, waiting = self.meanings[fault], [] if self.meanings[fault].ok else [fault]
            line, unknown = f"line {self.line_number(fault)}", meaning.unresolved
            why = message(f"`{unknown[0].text}` in {line} is not defined") if unknown else f"{line} has an error"
            while waiting:
                index = waiting.pop()
                if index not in found:
                    found[index] = why
                    defined = self.statements[index].defines
                    waiting += self.bindings.users(defined, index) if defined else ()
        return found

    @cached_property
    def predefined(self) -> Mapping[str, Definition]:
        """Definitions of the words for body parts, and of `to`, which apply if nothing above defines these words."""
        return predefined(self.config)

    @cached_property
    def _idle(self) -> Mapping[int, Idle]:
        return find_idle(self)

    @cached_property
    def _alone(self) -> Alone | None:
        return find_alone(self)

    def movement(self, placed: Placed, node: Node) -> Movement:
        """Return the movement of a node of a statement, as its first robot plays it."""
        return movement_of(node, self._scope(placed.index), len(placed.meaning.robots))

    def reader(self, index: int, robot: int = 0) -> ReadNodes:
        """Return a reader that has read the movement of a statement, as one of its robots plays it."""
        return reader_of(self.meanings[index], self._scope(index), self.statement_ids[index], robot)

    def edited(self, start: int, end: int, text: str) -> Analysis:
        """Return the analysis after `text` replaced the text from `start` to `end`. Costs as much as the edit
        touches."""
        return self.touched(start, end, text).settled()

    def touched(self, start: int, end: int, text: str) -> Analysis:
        """Do the same, but let the statements that the edit touches wait for `settled`.

        If it touches more than a few statements, all statements wait, and not even their text is parsed.
        """
        lines = self.lines.edited(start, end, text)
        if self.earlier:
            return _unread(lines, self.earlier)
        return self._touched(lines, start, end, MAX_PARSED) or _unread(lines, self)

    def _touched(self, lines: LineIndex, start: int, end: int, most: float) -> Analysis | None:
        """Return the analysis of these lines, in which the text from `start` to `end` was replaced; statements that
        this touches wait.

        None if more than `most` characters must be parsed.
        """
        if len(lines.text) > LONGEST_PROGRAM:
            return _begun(lines, self.config) if most == math.inf else None
        growth = len(lines.text) - len(self.text)
        replaced = end + growth
        # The statement before the first one touched may lack a bracket and continue into the new text.
        first = max(bisect_right(self.offsets, start) - 2, 0)
        begin = lines.start(lines.position(self.offsets[first]).line) if self.offsets[first:] else 0
        after, offsets, pieces = len(self.offsets), [], []
        length = 0
        for offset, piece in split(lines.text, begin if first else 0):
            # If a statement after the edit starts where one started before, nothing changes from there on.
            if offset >= replaced:
                known = bisect_left(self.offsets, offset - growth)
                if offset - growth > end and known < after and self.offsets[known] == offset - growth:
                    after = known
                    break
            length += len(piece)
            if length > most:
                return None
            offsets.append(offset)
            pieces.append(piece)
            checkpoint()
        rest = [offset + growth for offset in self.offsets[after:]] if growth else self.offsets[after:]
        all_offsets = [*self.offsets[:first], *offsets, *rest]
        statements = []
        for piece in pieces:
            checkpoint()
            statements.append(parse_statement(piece))
        while statements and first < after and statements[0] is self.statements[first]:
            del statements[0]
            first += 1
        while statements and first < after and statements[-1] is self.statements[after - 1]:
            del statements[-1]
            after -= 1
        changed = (*self.statements[first:after], *statements)
        if len(statements) == after - first and FOR_ALL.isdisjoint([each.kind for each in changed]):
            return _with_others(self, lines, all_offsets, first, statements)
        # All indices change, or all statements may, but unchanged ones keep their meanings.
        return _assembled(
            lines,
            all_offsets,
            [*self.statements[:first], *statements, *self.statements[after:]],
            [*self.statement_ids[:first], *islice(_new_ids, len(statements)), *self.statement_ids[after:]],
            self,
        )

    @property
    def is_settled(self) -> bool:
        """True if nothing waits for `settled`."""
        return not (self.waiting or self.earlier)

    @property
    def is_understood(self) -> bool:
        """True if every statement has been understood, perhaps with older definitions of its names."""
        return not self.earlier and all(self.meanings[index].is_known for index in self.waiting)

    def is_settled_to(self, offset: int) -> bool:
        """Return whether all statements that begin before an offset are up to date."""
        return not self.earlier and (not self.waiting or self.offsets[self.waiting[0]] > offset)

    def settled(self, enough: Callable[[], bool] | None = None, until: int | None = None) -> Analysis:
        """Bring waiting statements up to date: all, those up to the offset `until`, or one or more until `enough`
        returns true. With `enough`, the first call on an unread text only reads it.

        It takes them in the order of the text, so those near an edit come first.
        """
        if self.earlier:
            start, end, _ = difference(self.earlier.text, self.text)
            read = self.earlier._touched(self.lines, start, end, math.inf)
            assert read
            return read if enough else read.settled(until=until)  # reading is the first slice of the work
        last = len(self.offsets) if until is None else bisect_right(self.offsets, until) - 1
        if not self.waiting or self.waiting[0] > last:
            return self
        meanings, waiting, infeasible = list(self.meanings), list(self.waiting), dict(self.infeasible)
        waits: set[int] = set()  # the same statements; made when it is needed, because each slice would pay for it
        done: list[int] = []
        while waiting and waiting[0] <= last and not (done and enough and enough()):
            checkpoint()
            done.append(index := heappop(waiting))
            scope = _scope(self.statements[index], index, self.bindings, meanings, self.predefined)
            before = meanings[index]
            if not before.is_known or before.scope != tuple(scope.values()):
                now = meanings[index] = understand(self.statements[index], self.statement_ids[index], scope)
                for name in {each.name for each in (before.definition, now.definition) if each}:
                    users = [each for each in self.bindings.users(name, index) if meanings[each].is_known]
                    waits = waits or set(waiting if users else ())  # the users that aren't known wait anyway
                    for user in users:
                        if user not in waits:
                            waits.add(user)
                            heappush(waiting, user)
            if problems := self._problems(index, meanings[index]):
                infeasible[index] = problems
            else:
                infeasible.pop(index, None)
        return dataclasses.replace(
            self,
            meanings=meanings,
            unusual=self.unusual.updated(meanings, done),
            infeasible=infeasible,
            waiting=waiting,
        )

    def _problems(self, index: int, meaning: Meaning) -> tuple[Diagnostic, ...]:
        """Return the problems of a statement's robots."""
        statement = self.statements[index]
        if meaning.said:
            named = check_names(statement, meaning.said.robots, self.config)
            return (*named.values(), *check_kind(statement, meaning.said, self.config))
        config = self.opening.config
        bounds = meaning.movement.bounds
        problems = check_casting(statement, meaning, config, self.tempo) if meaning.robots else ()
        if "to" in statement.uses and meaning.body:
            problems = (*problems, *check_pose_names(meaning.body, self.config))
        if meaning.robots and bounds.body.asked:
            problems = (*problems, *check_bodies(statement, meaning, config))
        if meaning.robots and is_measured(bounds):
            problems = (*problems, *check_units(statement, meaning, config))
        if statement.has_senses or (meaning.robots and bounds.open):
            problems = (*problems, *check_senses(statement, meaning, config))
        return problems

    def with_robots(self, robots: Robots) -> Analysis:
        """Return the same program for other robots. Everything that robots play waits for `settled`."""
        made = dataclasses.replace(self.cast_with(robots), earlier=self.earlier and self.earlier.with_robots(robots))
        words = {*self.predefined, *made.predefined}
        return made._doubted(index for word in words for index in self.bindings.used.get(word, ()))

    def cast_with(self, robots: Robots) -> Analysis:
        """Return the same program for other robots, without checking anything."""
        return dataclasses.replace(self, config=robots, opening=opening_of(robots, self.openings, self.meanings))

    def _doubted(self, others: Iterable[int] = ()) -> Analysis:
        """Let everything that robots play wait for another check, and the lines of the opening and others too."""
        pairs = enumerate(zip(self.statements, self.meanings, strict=True))
        found = (index for index, (each, meaning) in pairs if meaning.robots or each.has_senses or meaning.said)
        return dataclasses.replace(self, waiting=sorted({*self.waiting, *found, *others}))

    def _scope(self, index: int) -> Scope:
        return _scope(self.statements[index], index, self.bindings, self.meanings, self.predefined)


def analyze(text: str, robots: Robots = NO_ROBOTS) -> Analysis:
    """Analyze a whole program for these robots; nothing of one that is too long. Never raises."""
    return unread(text, robots).settled()


def unread(text: str, robots: Robots = NO_ROBOTS) -> Analysis:
    """Return the analysis of a whole program in which everything waits for `settled`."""
    return _unread(LineIndex(text), _begun(LineIndex(""), robots))


def _unread(lines: LineIndex, earlier: Analysis) -> Analysis:
    """Return the analysis of a text in which no statement has been parsed yet."""
    return dataclasses.replace(_begun(lines, earlier.config), earlier=earlier)


def _begun(lines: LineIndex, config: Robots) -> Analysis:
    """Return the analysis of a text without its statements."""
    return Analysis(lines, (), (), (), (), bind(()), (), (), (), Unusual(), config, Opening(config), {})


def _assembled(
    lines: LineIndex,
    offsets: Sequence[int],
    statements: Sequence[Statement],
    statement_ids: Sequence[int],
    old: Analysis,
) -> Analysis:
    """Return the analysis of these statements. They keep their meanings from `old`; those whose scope differs wait."""
    known = dict(zip(old.statement_ids, old.meanings, strict=True))
    waited = {old.statement_ids[index] for index in old.waiting}
    current: dict[str, Definition] = {}
    words = old.predefined
    meanings: list[Meaning] = []
    waiting: list[int] = []
    for index, (statement, statement_id) in enumerate(zip(statements, statement_ids, strict=True)):
        scope = {name: current.get(name) or words.get(name) for name in statement.uses}
        if statement_id in known:
            meaning = known[statement_id]
        else:
            checkpoint()
            meaning = not_understood(statement, statement_id, scope)
            waited.add(statement_id)
        if not meaning.is_known or meaning.scope != tuple(scope.values()) or statement_id in waited:
            waiting.append(index)
        meanings.append(meaning)
        if meaning.definition:
            current[meaning.definition.name] = meaning.definition
    found = {old.statement_ids[index]: diagnostics for index, diagnostics in old.infeasible.items()}
    kinds = [each.kind for each in statements]
    openings = [index for index, kind in enumerate(kinds) if kind in OPENING]
    assembled = Analysis(
        lines=lines,
        offsets=offsets,
        statements=statements,
        statement_ids=statement_ids,
        meanings=meanings,
        bindings=bind(statements),
        tempos=[index for index, kind in enumerate(kinds) if kind == "BEAT"],
        scenes=[index for index in openings if kinds[index] == "SCENE"],
        openings=openings,
        unusual=Unusual().updated(meanings, range(len(meanings))),
        config=old.config,
        opening=opening_of(old.config, openings, meanings),
        infeasible={index: found[each] for index, each in enumerate(statement_ids) if each in found},
        waiting=waiting,
    )
    # Everything that robots play waits if the limits or the tempo differ from before.
    is_like = assembled.tempo == old.tempo and assembled.opening.config.kinds == old.opening.config.kinds
    return assembled if is_like else assembled._doubted()


def _with_others(
    old: Analysis, lines: LineIndex, offsets: Sequence[int], first: int, others: Sequence[Statement]
) -> Analysis:
    """Replace movements of an analysis from `first` on by others; the new ones wait. Indices stay."""
    changed = dict(enumerate(others, first))
    statements, statement_ids, meanings = list(old.statements), list(old.statement_ids), list(old.meanings)
    statements[first : first + len(others)] = others
    statement_ids[first : first + len(others)] = islice(_new_ids, len(others))
    bindings = old.bindings.edited({index: old.statements[index] for index in changed}, changed)
    waiting = {*old.waiting, *changed}
    for index, statement in changed.items():
        scope = _scope(statement, index, bindings, meanings, old.predefined)
        # Until it is understood, it keeps its old definition, so that nothing below it changes twice.
        definition = meanings[index].definition
        meanings[index] = not_understood(statement, statement_ids[index], scope, definition)
        if definition and meanings[index].is_known:
            waiting.update(bindings.users(definition.name, index))
    return dataclasses.replace(
        old,
        lines=lines,
        offsets=offsets,
        statements=statements,
        statement_ids=statement_ids,
        meanings=meanings,
        bindings=bindings,
        unusual=old.unusual.updated(meanings, changed),
        infeasible={index: each for index, each in old.infeasible.items() if index not in changed},
        waiting=sorted(waiting),
    )


def _scope(
    statement: Statement,
    index: int,
    bindings: Bindings,
    meanings: Sequence[Meaning],
    words: Mapping[str, Definition],
) -> Scope:
    scope = {}
    for name in statement.uses:
        definer = bindings.definer(name, index)
        scope[name] = words.get(name) if definer is None else meanings[definer].definition
    return scope
