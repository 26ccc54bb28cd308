"""The meaning of a program and its errors: the one value that all editor features and the compiler read."""

from __future__ import annotations

import dataclasses
import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import count, islice, pairwise
from typing import NamedTuple

from improv_core.diagnostics import MOST_SHOWN, Diagnostic, Edit, Fix, Related, Severity, replace
from improv_core.program.bindings import Bindings, bind
from improv_core.program.feasibility import check_casting
from improv_core.program.fixes import give_arguments, move_canon
from improv_core.program.meaning import Meaning, is_valid_robot, movement_of, reader_of, understand
from improv_core.program.reader import Definition, Reader, Scope
from improv_core.program.sensing import check_senses
from improv_core.robots.config import Robots
from improv_core.score import dice, movement
from improv_core.score.lengths import Lengths, lengths, scene_lengths
from improv_core.score.movement import Exact, Movement
from improv_core.score.scenes import performance, scene_begins
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.slips import MEANT, is_like_a_robot, number_first
from improv_core.syntax.statements import split
from improv_core.text import LineIndex, Span

DEFAULT_TEMPO = Fraction(60)
EVEN = 1_000
"""Lengths with denominators up to this can always be added: all of these have a common one of 1,439 bits."""
NO_ROBOTS = Robots()
MOST_SCENES = 500
"""The most scenes of a program: each robot has a movement for each."""
LONGEST_PROGRAM = 10_000_000
"""Characters of a program that is analyzed."""
_TOO_LONG = Diagnostic("syntax", Span(0, 0), f"split this program: it has more than {LONGEST_PROGRAM:,} characters")

_new_ids = count()  # every statement of every document gets its own and keeps it when it moves


@dataclass(frozen=True, slots=True)
class Placed:
    """A statement with its index and its offset in the text."""

    index: int
    start: int
    statement: Statement
    meaning: Meaning

    @property
    def span(self) -> Span:
        return Span(self.start, self.start + len(self.statement.text))


class Line(NamedTuple):
    """What robots play in a scene (from 0), each from the same throw of the dice on, and the statement it is from."""

    parts: Sequence[tuple[str, Movement]]
    statement: int
    scene: int = 0
    throw: int = 0


@dataclass(frozen=True)
class Analysis:
    """The meaning of one version of a document. Made by `analyze`, or by `edited` from the previous version.

    The sequences are parallel, with one entry for each statement: its offset, tree, ID, and meaning. `tempos` has the
    indices of the statements that set a tempo, `scenes` those of the statements that begin a scene, `faulty` those of
    the statements whose meaning has diagnostics or names that are undefined or have wrong arguments, and `uneven` those
    that play something whose length has a denominator over `EVEN`. `infeasible` lists, by index, what the robots of a
    statement can't do. `waiting` is a heap of statements that may use what has changed and that `settled` has not come
    to yet: until then, they mean what they meant before. `selected` are the lines that play, if not all of them do.
    """

    lines: LineIndex
    offsets: Sequence[int]
    statements: Sequence[Statement]
    statement_ids: Sequence[int]
    meanings: Sequence[Meaning]
    bindings: Bindings
    tempos: Sequence[int]
    scenes: Sequence[int]
    faulty: frozenset[int]
    uneven: frozenset[int]
    cast: Robots  # from improv.toml
    infeasible: Mapping[int, tuple[Diagnostic, ...]]
    waiting: Sequence[int] = ()
    selected: Sequence[Line] | None = None

    @property
    def text(self) -> str:
        return self.lines.text

    @property
    def ok(self) -> bool:
        """Whether it may play: neither the program nor `improv.toml` has an error."""
        return self.cast.ok and all(each.severity is not Severity.ERROR for each in self.diagnostics)

    @property
    def tempo(self) -> Fraction:
        """Beats per minute."""
        return _tempo(self.tempos, self.meanings)

    @cached_property
    def played(self) -> Mapping[int, Line]:
        """The lines that robots play, by index.

        Each begins, for all its robots, at the furthest throw that any of them has reached.
        """
        lines = {}
        throws: dict[str, int] = {}
        for index, (statement_id, meaning) in enumerate(zip(self.statement_ids, self.meanings, strict=True)):
            if not meaning.robots or index in self._too_uneven:
                continue
            scene = min(bisect_left(self.scenes, index), MOST_SCENES - 1) if self.scenes else 0
            throw = max([throws.get(robot, 0) for robot in meaning.robots]) if throws else 0
            lines[index] = Line(meaning.parts, statement_id, scene, throw)
            if throw or meaning.movement.throws:
                throws.update(dict.fromkeys(meaning.robots, throw + meaning.movement.throws))
        return lines

    @cached_property
    def parts(self) -> Mapping[str, tuple[Movement, ...]]:
        """What each robot plays in each scene, in order of appearance."""
        plays: dict[str, dict[int, list[Movement]]] = {}
        for line in self.played.values() if self.selected is None else self.selected:
            for robot, part in line.parts:
                begun = movement.use(dice.throwing(part, line.throw), None, line.statement)
                plays.setdefault(robot, {}).setdefault(line.scene, []).append(begun)
        scenes = range(min(len(self.scenes) + 1, MOST_SCENES))
        return {
            robot: tuple([movement.series(parts.get(scene, ())) for scene in scenes]) for robot, parts in plays.items()
        }

    @cached_property
    def robots(self) -> Mapping[str, Movement]:
        """All that each robot plays, in order of appearance."""
        return {robot: performance(scenes, self.begins) for robot, scenes in self.parts.items()}

    @cached_property
    def begins(self) -> Sequence[Exact]:
        """The beats at which the scenes begin, up to one that never ends."""
        return scene_begins(self.parts.values())

    @cached_property
    def lengths(self) -> Mapping[str, Lengths]:
        """How long the parts of the robots last, with all scenes."""
        return dict(zip(self.parts, self._scene_lengths[1], strict=True))

    def scene_begin(self, scene: int) -> Lengths | None:
        """The beat at which a scene begins, at the earliest and at the latest; None if it never begins."""
        begins = self._scene_lengths[0]
        return begins[scene] if scene < len(begins) and begins[scene].shortest < movement.ENDLESS else None

    @cached_property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics of the program, in the order of the text."""
        if len(self.text) > LONGEST_PROGRAM:
            return (_TOO_LONG,)
        serious = self.faulty.union(self.tempos[1:], self.scenes[MOST_SCENES - 1 :], self.infeasible, self._too_uneven)
        indices = [*sorted(serious), *sorted(self.bindings.unused.union(self._scene_hints) - serious)]
        reported = ((index, each) for index in indices for each in self.diagnostics_of(index))
        found = [each.shifted(self.offsets[index]) for index, each in islice(reported, MOST_SHOWN)]
        if next_one := next(reported, None):
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
        """The definition of a name that applies at the statement `before`."""
        index = self.bindings.definer(name, before)
        return None if index is None else self.meanings[index].definition

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
        tempo = _tempo(self.tempos, meanings)
        known, doubtful = (self.infeasible, again) if tempo == tempo_before else ({}, range(len(meanings)))
        return dataclasses.replace(
            self,
            meanings=meanings,
            faulty=self.faulty.difference(again).union(index for index in again if _is_faulty(meanings[index])),
            uneven=self.uneven.difference(again).union(index for index in again if _is_uneven(meanings[index])),
            infeasible=_infeasible(meanings, self.statements, self.cast, tempo, known, doubtful),
            waiting=waiting,
        )

    def with_robots(self, robots: Robots) -> Analysis:
        """The same program for other robots."""
        return dataclasses.replace(
            self, cast=robots, infeasible=_infeasible(self.meanings, self.statements, robots, self.tempo)
        )

    @cached_property
    def _scene_lengths(self) -> tuple[Sequence[Lengths], Sequence[Lengths]]:
        return scene_lengths(list(self.parts.values()))

    @cached_property
    def _too_uneven(self) -> frozenset[int]:
        """The statements whose length can't be added to those above it for the same robot: the sum is too long."""
        commons: dict[str, int] = {}
        found = set()
        for index in sorted(self.uneven):
            meaning = self.meanings[index]
            for robot in meaning.robots:
                common = math.lcm(commons.get(robot, 1), _denominator(meaning.movement))
                if common.bit_length() > movement.MOST_BITS:
                    found.add(index)
                else:
                    commons[robot] = common
        return frozenset(found)

    @cached_property
    def _scene_hints(self) -> Mapping[int, Diagnostic]:
        """Hints about scenes in which nothing plays, and about lines below a scene that never ends, by statement."""
        if not self.scenes:
            return {}
        found: dict[int, Diagnostic] = {}
        bounds = [-1, *self.scenes, len(self.statements)]
        endless = 0  # the number of the first scene that never ends
        for scene, (first, last) in enumerate(pairwise(bounds)):
            playing = [index for index in range(first + 1, last) if self.meanings[index].robots]
            if not playing and first < 0:
                found[last] = self._idle_scene(last, "no robot plays above this line: remove it")
            elif not playing:
                found[first] = self._idle_scene(first, "no robot plays in this scene: remove this line")
            for index in playing if endless else ():
                whole = Span(0, len(self.statements[index].text))
                message = f"scene {endless} above never ends, so this is never performed: give its `repeat` a number"
                found[index] = Diagnostic("never-performed", whole, message)
            if not endless and any(_never_ends(self.meanings[index].movement) for index in playing):
                endless = scene + 1
        return found

    def _idle_scene(self, index: int, message: str) -> Diagnostic:
        fixes = replace("Remove it", self._whole_line(index), "", safe=True)
        return Diagnostic("no-effect", Span(0, len(self.statements[index].text)), message, fixes)

    @cached_property
    def _plays_nothing(self) -> bool:
        return not any(meaning.robots for meaning in self.meanings)

    def _scope(self, index: int) -> Scope:
        return _scope(self.statements[index], index, self.bindings, self.meanings)

    def diagnostics_of(self, index: int) -> Iterator[Diagnostic]:
        """The diagnostics of one statement. Spans count from its start."""
        statement, meaning = self.statements[index], self.meanings[index]
        for each in meaning.diagnostics:
            yield each if each.code != "misplaced-canon" else self._misplaced(index, each)
        yield from self.infeasible.get(index, ())
        if statement.sign and statement.sign.type == "SCENE" and index in self.scenes[MOST_SCENES - 1 :]:
            message = f"this program has more than {MOST_SCENES} scenes: remove some"
            yield Diagnostic("too-large", Span(0, len(statement.text)), message)
        if index in self._scene_hints:
            yield self._scene_hints[index]
        if index in self.bindings.unused:
            yield self._unused(index)
        if statement.sign and statement.sign.type == "BEAT" and index != self.tempos[0]:
            first = self.offsets[self.tempos[0]]
            message = f"line {self._line(self.tempos[0])} already sets the tempo: remove this `beat`"
            related = Related(self._relative(Span(first, first + len("beat")), index), "the first `beat`")
            repeats = meaning.tempo == self.meanings[self.tempos[0]].tempo
            fixes = replace("Remove it", self._whole_line(index), "", safe=repeats)
            yield Diagnostic("duplicate-beat", Span(0, len(statement.text)), message, fixes, (related,))
        if index in self._too_uneven and statement.body:
            message = "use simpler numbers: with the lines above, they make a fraction too long to compute exactly"
            yield Diagnostic("bad-number", statement.body.span, message)
        for node in meaning.unresolved:
            yield self._unresolved(index, node)
        for use in meaning.misused:
            yield self._misused(index, use)

    def _more(self, hidden: Sequence[int]) -> Diagnostic:
        """What stands for the diagnostics of the statements that are not shown."""
        tempos = frozenset([*self.tempos[1:], *self.scenes[MOST_SCENES - 1 :]])
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
            return self._unknown(index, node)
        later = self.bindings.defined[name][0]
        head = self.statements[later].heads[0].span.shifted(self.offsets[later])
        related = Related(self._relative(head, index), f"`{name}` is defined here")
        line = self._line(later)
        if later == index:
            message = f"`{name}` is used in its own definition: define it first, above line {line}"
            return Diagnostic("used-before-definition", node.span, message, (), (related,))
        message = f"`{name}` is not defined until line {line}: move its definition above this line"
        above = Edit(Span(0, 0), self.statements[later].text + self._line_end(index))
        moved = (above, Edit(self._whole_line(later, index), ""))
        fixes = (Fix(f"Move the definition of {name} up", moved),)
        return Diagnostic("used-before-definition", node.span, message, fixes, (related,))

    def _misused(self, index: int, node: nodes.Name | nodes.Call) -> Diagnostic:
        """The diagnostic about a use whose arguments are not as the head of its definition says."""
        name, numbers = (node, ()) if isinstance(node, nodes.Name) else (node.name, node.numbers)
        found = self.definition(name.text, index) if name.text in self.bindings.defined else None
        is_parameter = name.text in (each.name for each in self.statements[index].parameters)
        if is_parameter or not found or not found.phrase:
            span = Span(numbers[0].span.start, numbers[-1].span.end)
            remove = replace("Remove it", span, "")
            if len(numbers) > 1 or any(numbers[0].parameters):
                return Diagnostic("arguments", span, f"`{name.text}` takes no number: remove it", remove)
            term = Token("NAME", name.text, *name.span)
            message, fixes = number_first(numbers[0].text, term, True, Span(name.span.end, span.end))
            return Diagnostic("arguments", span, f"`{name.text}` takes no number: {message}", (*fixes, *remove))
        movements = node.movements if isinstance(node, nodes.Call) else ()
        takes = _counted(len(found.phrase.numbers), len(found.phrase.movements))
        given = f", not {_counted(len(numbers), len(movements))}" if numbers or movements else ""
        message = f"`{name.text}` takes {takes}{given}: write `{found.head}`"
        if len(numbers) > len(found.phrase.numbers) and len(movements) < len(found.phrase.movements):
            first = found.phrase.movements[0].name
            message = f"`{name.text}` takes {takes}{given}: for a number, write `{first}` without brackets in its head"
        definer = self.bindings.definer(name.text, index)
        assert definer is not None
        head = self.statements[definer].heads[0].span.shifted(self.offsets[definer])
        related = Related(self._relative(head, index), f"`{found.head}` is defined here")
        sign = self.statements[definer].sign
        assert sign
        declared = self._relative(Span(head.end, self.offsets[definer] + sign.start), index)
        fixes = give_arguments(node, found.phrase, declared)
        return Diagnostic("arguments", name.span, message, fixes, (related,))

    def _misplaced(self, index: int, problem: Diagnostic) -> Diagnostic:
        """The diagnostic about a `canon` in a definition, with its fixes."""
        statement, body = self.statements[index], self.meanings[index].body
        found = (each for each in nodes.nodes(body) if isinstance(each, nodes.Apply)) if body else ()
        canon = next((each for each in found if each.word.span == problem.span and each.numbers), None)
        if not canon:
            return problem
        users = self.bindings.users(statement.defines, index) if statement.defines else ()
        uses = [
            self._relative(name.span.shifted(self.offsets[user]), index).start
            for user in users
            for name in nodes.names(self.meanings[user].body or canon)
            if name.text == statement.defines
        ]
        movable = (
            canon is body and not any(canon.numbers[0].parameters) and all(self.meanings[user].robots for user in users)
        )
        fixes = move_canon(canon, statement.text, uses if movable else None)
        return dataclasses.replace(problem, fixes=tuple(fixes))

    def _unused(self, index: int) -> Diagnostic:
        statement = self.statements[index]
        head, sign = statement.heads[0], statement.sign
        assert sign
        message = f"nothing uses `{head.text}`: use it below or remove this line"
        fixes = [Fix("Remove the definition", (Edit(self._whole_line(index), ""),))]
        if statement.parameters or not is_valid_robot(head.text):
            return Diagnostic("unused-name", head.span, message, tuple(fixes))
        fixes += replace(f"Play it: {head.text} $ …", sign.span, "$")
        if self._plays_nothing or head.text in self.cast.robots or is_like_a_robot(head.text):
            message = f"nothing uses `{head.text}`: if it is a robot, write `{head.text} $ …`"
            fixes.reverse()
        return Diagnostic("unused-name", head.span, message, tuple(fixes))

    def _unknown(self, index: int, node: nodes.Name) -> Diagnostic:
        name = node.text
        if meant := MEANT.get(name.lower()):
            message = f"`{name}` is not defined: did you mean {' or '.join(f'`{word}`' for word in meant)}?"
            fixes = tuple(fix for word in meant for fix in replace(f"Change to {word}", node.span, word))
            return Diagnostic("unknown-name", node.span, message, fixes)
        near = self.bindings.nearest(name)
        if near is None:
            message = f"`{name}` is not defined: write `{name} = …` above this line"
            fixes = replace(f"Define {name} as rest above", Span(0, 0), f"{name} = rest{self._line_end(index)}")
            return Diagnostic("unknown-name", node.span, message, fixes)
        message = f"`{name}` is not defined: did you mean `{near}`?"
        return Diagnostic("unknown-name", node.span, message, replace(f"Change to {near}", node.span, near))

    def _line_end(self, index: int) -> str:
        """What ends the line on which a statement starts."""
        line = self.lines.position(self.offsets[index]).line
        return self.text[self.lines.end(line) : self.lines.start(line + 1)] or "\n"

    def _line(self, index: int) -> int:
        """The line on which a statement starts, counted from 1."""
        return self.lines.position(self.offsets[index]).line + 1

    def _whole_line(self, index: int, seen_from: int | None = None) -> Span:
        """The whole lines of a statement, for removal. Offsets count from the start of the statement `seen_from`."""
        start = self.offsets[index]
        first = self.lines.position(start).line
        last = self.lines.position(start + len(self.statements[index].text)).line
        whole = Span(self.lines.start(first), self.lines.start(last + 1))
        return self._relative(whole, index if seen_from is None else seen_from)

    def _relative(self, span: Span, index: int) -> Span:
        return span.shifted(-self.offsets[index])


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
        scenes=_signed("SCENE", statements),
        faulty=frozenset(index for index, meaning in enumerate(meanings) if _is_faulty(meaning)),
        uneven=frozenset(index for index, meaning in enumerate(meanings) if _is_uneven(meaning)),
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
    """What robots can't do, by statement: `known`, with the `doubtful` statements (default: all) checked again."""
    found = dict(known or {})
    for index in range(len(statements)) if doubtful is None else doubtful:
        statement, meaning = statements[index], meanings[index]
        problems = check_casting(statement, meaning, cast, tempo) if meaning.robots else ()
        if statement.has_senses or meaning.is_open:
            problems = (*problems, *check_senses(statement, meaning, cast))
        if problems:
            found[index] = problems
        else:
            found.pop(index, None)
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


def _tempo(tempos: Sequence[int], meanings: Sequence[Meaning]) -> Fraction:
    return (meanings[tempos[0]].tempo if tempos else None) or DEFAULT_TEMPO


def _sign(statement: Statement) -> str:
    return statement.sign.type if statement.sign else ""


def _is_faulty(meaning: Meaning) -> bool:
    return bool(meaning.diagnostics or meaning.unresolved or meaning.misused)


def _counted(numbers: int, movements: int) -> str:
    """`1 number`, `2 numbers and 1 movement`."""
    kinds = ((numbers, "number"), (movements, "movement"))
    counts = [f"{count} {kind}{'' if count == 1 else 's'}" for count, kind in kinds if count]
    return " and ".join(counts)


def _never_ends(played: Movement) -> bool:
    return isinstance(played.duration, float) and (not played.open or lengths(played).shortest == movement.ENDLESS)


def _is_uneven(meaning: Meaning) -> bool:
    return bool(meaning.robots) and _denominator(meaning.movement) > EVEN


def _denominator(played: Movement) -> int:
    return played.duration.denominator if isinstance(played.duration, Fraction) else 1
