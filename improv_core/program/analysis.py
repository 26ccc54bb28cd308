"""What a program means and what is wrong with it: the one value that all editor features and the compiler read."""

from __future__ import annotations

import dataclasses
from bisect import bisect_left, bisect_right, insort
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import count

from improv_core.diagnostics import Diagnostic, Edit, Fix, Related, Severity, replace
from improv_core.program.feasibility import check_casting
from improv_core.program.meaning import Definition, Meaning, Scope, movement_of, understand
from improv_core.robots.config import Robots
from improv_core.score import movement
from improv_core.score.movement import Movement, Place
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.syntax.vocabulary import Kind, of_kind
from improv_core.text import LineIndex, Span

DEFAULT_TEMPO = Fraction(60)
NO_ROBOTS = Robots()

_MOVING = of_kind(Kind.PRIMITIVE, Kind.MIRROR, Kind.REPEAT, Kind.REFLECT, Kind.FACTOR)
_numbers = count()  # every statement of every document gets one of its own, and keeps it where it moves


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

    The lists run side by side, one entry a statement. `defined` and `used` have the indices of the statements that
    define and use a name, `beats` those with a tempo, `wrong` those about which something is to be said, `unused`
    those that define a name nobody uses; `casting` has what their robots can't do, by index.
    """

    lines: LineIndex
    starts: list[int]
    statements: list[Statement]
    numbers: list[int]
    meanings: list[Meaning]
    defined: dict[str, list[int]]
    used: dict[str, list[int]]
    beats: list[int]
    wrong: set[int]
    unused: set[int]
    nearest: dict[str, str | None]  # the known word nearest to an unknown one, as far as that has been asked
    cast: Robots  # what improv.toml says
    casting: dict[int, tuple[Diagnostic, ...]]

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
        return (self.beats and self.meanings[self.beats[0]].tempo) or DEFAULT_TEMPO

    @cached_property
    def robots(self) -> Mapping[str, Movement]:
        """What each robot plays, in order of appearance."""
        plays: dict[str, list[Movement]] = {}
        for number, meaning in zip(self.numbers, self.meanings, strict=True):
            for robot in meaning.robots:
                plays.setdefault(robot, []).append(movement.use(meaning.movement, None, number))
        return {robot: movement.series(parts) for robot, parts in plays.items()}

    @cached_property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All that is to be said about the program, in the order of the text."""
        found: list[Diagnostic] = []
        for index in self.wrong.union(self.unused, self.beats[1:], self.casting):
            found += (each.shifted(self.starts[index]) for each in self._said_of(index))
        return tuple(sorted(found, key=lambda diagnostic: diagnostic.span))

    def statement_at(self, offset: int) -> Placed | None:
        """The statement that a cursor at `offset` touches."""
        index = bisect_right(self.starts, offset) - 1
        placed = self.placed(index) if index >= 0 else None
        return placed if placed and placed.span.holds(offset) else None

    def placed(self, index: int) -> Placed:
        return Placed(index, self.starts[index], self.statements[index], self.meanings[index])

    def definition(self, name: str, before: int) -> Definition | None:
        """What a name stands for where the statement with this index stands."""
        index = self.defining(name, before)
        return None if index is None else self.meanings[index].definition

    def defining(self, name: str, before: int) -> int | None:
        """The index of the statement that defines what a name stands for in the statement `before`."""
        definers = self.defined.get(name, ())
        place = bisect_left(definers, before)
        return definers[place - 1] if place else None

    def movement(self, placed: Placed, node: Node) -> Movement:
        """What a part of a statement means where it stands."""
        return movement_of(node, self._scope(placed.index))

    def spans(self, places: Sequence[Place]) -> list[Span]:
        """Where the places of a moment are in the text."""
        starts = dict(zip(self.numbers, self.starts, strict=True))
        return [place.span.shifted(starts[place.statement]) for place in places]

    def edited(self, start: int, end: int, text: str) -> Analysis:
        """The analysis after the text from `start` to `end` has been replaced; costs what the edit touches."""
        lines = self.lines.edited(start, end, text)
        growth = len(text) - (end - start)
        # The statement before the first one touched may lack a bracket, and go on into what now stands there.
        first = max(bisect_right(self.starts, start) - 2, 0)
        begin = lines.start(lines.position(self.starts[first]).line) if self.starts[first:] else 0
        after, starts, pieces = len(self.starts), [], []
        for offset, piece in split(lines.text, begin if first else 0):
            # Where a statement begins behind the edit as one did before, all goes on as before.
            if offset >= start + len(text):
                known = bisect_left(self.starts, offset - growth)
                if offset - growth > end and known < after and self.starts[known] == offset - growth:
                    after = known
                    break
            starts.append(offset)
            pieces.append(piece)
        rest = [offset + growth for offset in self.starts[after:]] if growth else self.starts[after:]
        all_starts = self.starts[:first] + starts + rest
        statements = [parse_statement(piece) for piece in pieces]
        while statements and first < after and statements[0] is self.statements[first]:
            del statements[0]
            first += 1
        while statements and first < after and statements[-1] is self.statements[after - 1]:
            del statements[-1]
            after -= 1
        if len(statements) == after - first:
            return _with_others(self, lines, all_starts, first, statements)
        # Statements came or went: every index changes, but what is as it was is not understood again.
        return _assembled(
            lines,
            all_starts,
            self.statements[:first] + statements + self.statements[after:],
            self.numbers[:first] + [next(_numbers) for _ in statements] + self.numbers[after:],
            self.cast,
            self,
        )

    def with_robots(self, robots: Robots) -> Analysis:
        """The same program for other robots."""
        new = dataclasses.replace(self, cast=robots, casting={})
        _cast_again(new, range(len(self.statements)))
        return new

    def _scope(self, index: int) -> Scope:
        return {name: self.definition(name, index) for name in self.statements[index].uses}

    def _said_of(self, index: int) -> Iterator[Diagnostic]:
        """The diagnostics of one statement; spans count from its start."""
        statement, meaning = self.statements[index], self.meanings[index]
        yield from meaning.diagnostics
        yield from self.casting.get(index, ())
        if index in self.unused:
            head = statement.heads[0]
            message = f"use `{head.text}` below, or remove this line: nothing plays it"
            line = self._whole_line(index)
            yield Diagnostic("unused-name", head.span, message, (Fix("Remove the definition", (Edit(line, ""),)),))
        if statement.sign and statement.sign.type == "BEAT" and index != self.beats[0]:
            first = self.starts[self.beats[0]]
            message = f"remove this `beat`: line {self._line(self.beats[0])} has one already"
            related = Related(self._relative(Span(first, first + len("beat")), index), "the first `beat`")
            fixes = (Fix("Remove it", (Edit(self._whole_line(index), ""),)),)
            yield Diagnostic("duplicate-beat", Span(0, len(statement.text)), message, fixes, (related,))
        for node in meaning.unresolved:
            yield self._unresolved(index, node)

    def _unresolved(self, index: int, node: nodes.Name) -> Diagnostic:
        name = node.text
        if name not in self.defined:
            return self._unknown(node)
        later = self.defined[name][0]
        head = self.statements[later].heads[0].span.shifted(self.starts[later])
        related = Related(self._relative(head, index), f"`{name}` is defined here")
        line = self._line(later)
        if later == index:
            message = f"define `{name}` above this line (line {line}) before using it in its own definition"
            return Diagnostic("used-before-definition", node.span, message, (), (related,))
        message = f"move the definition of `{name}` (line {line}) above this line"
        here = self._relative(Span(self.starts[index], self.starts[index]), index)
        above = self.lines.position(self.starts[index]).line
        line_end = self.text[self.lines.end(above) : self.lines.start(above + 1)]
        moved = (Edit(here, self.statements[later].text + line_end), Edit(self._whole_line(later, index), ""))
        fixes = (Fix(f"Move the definition of {name} up", moved),)
        return Diagnostic("used-before-definition", node.span, message, fixes, (related,))

    def _unknown(self, node: nodes.Name) -> Diagnostic:
        name = node.text
        if name not in self.nearest:
            self.nearest[name] = _nearest(name, self.defined)
        near = self.nearest[name]
        if near is None:
            return Diagnostic("unknown-name", node.span, f"`{name}` is not known: define it above: `{name} = …`")
        message = f"`{name}` is not known: did you mean `{near}`?"
        return Diagnostic("unknown-name", node.span, message, replace(f"Write {near}", node.span, near))

    def _line(self, index: int) -> int:
        """The line a statement begins in, as people count."""
        return self.lines.position(self.starts[index]).line + 1

    def _whole_line(self, index: int, seen_from: int | None = None) -> Span:
        """The lines of a statement with their end, to be removed; counted from the start of a statement."""
        start = self.starts[index]
        first = self.lines.position(start).line
        last = self.lines.position(start + len(self.statements[index].text)).line
        whole = Span(self.lines.start(first), self.lines.start(last + 1))
        return self._relative(whole, index if seen_from is None else seen_from)

    def _relative(self, span: Span, index: int) -> Span:
        return span.shifted(-self.starts[index])


def analyze(text: str, robots: Robots = NO_ROBOTS) -> Analysis:
    """Read a whole program, for these robots. Never raises."""
    starts, statements = [], []
    for start, piece in split(text):
        starts.append(start)
        statements.append(parse_statement(piece))
    return _assembled(LineIndex(text), starts, statements, [next(_numbers) for _ in statements], robots)


def users_behind(analysis: Analysis, name: str, index: int) -> Sequence[int]:
    """The statements that use a name as the statement `index` leaves it; -1 stands for the document's start."""
    users, definers = analysis.used.get(name, []), analysis.defined.get(name, [])
    following = bisect_right(definers, index)
    last = definers[following] if following < len(definers) else len(analysis.statements)
    return users[bisect_right(users, index) : bisect_right(users, last)]


def _assembled(
    lines: LineIndex,
    starts: list[int],
    statements: list[Statement],
    numbers: list[int],
    cast: Robots,
    old: Analysis | None = None,
) -> Analysis:
    """All statements in their order; what `old` knows of them, by number, is kept where their scope is what it was."""
    known = dict(zip(old.numbers, old.meanings, strict=True)) if old else {}
    current: dict[str, Definition] = {}
    meanings: list[Meaning] = []
    defined: dict[str, list[int]] = {}
    used: dict[str, list[int]] = {}
    for index, (statement, number) in enumerate(zip(statements, numbers, strict=True)):
        scope = {name: current.get(name) for name in statement.uses}
        meaning = known.get(number)
        if meaning is None or meaning.scope != tuple(scope.values()):
            meaning = understand(statement, number, scope)
        meanings.append(meaning)
        for name in statement.uses:
            used.setdefault(name, []).append(index)
        if meaning.definition:
            current[meaning.definition.name] = meaning.definition
            defined.setdefault(meaning.definition.name, []).append(index)
    beats = [index for index, statement in enumerate(statements) if _is_beat(statement)]
    wrong = {index for index, meaning in enumerate(meanings) if meaning.diagnostics or meaning.unresolved}
    unused = {index for name in defined for index in _unused(name, defined, used)}
    new = Analysis(lines, starts, statements, numbers, meanings, defined, used, beats, wrong, unused, {}, cast, {})
    if old and old.tempo == new.tempo:
        said = {old.numbers[index]: diagnostics for index, diagnostics in old.casting.items()}
        new.casting.update((index, said[number]) for index, number in enumerate(numbers) if number in said)
        others = (index for index, number in enumerate(numbers) if known.get(number) is not meanings[index])
        _cast_again(new, others)
    else:
        _cast_again(new, range(len(statements)))
    return new


def _with_others(
    old: Analysis, lines: LineIndex, starts: list[int], first: int, others: Sequence[Statement]
) -> Analysis:
    """The analysis with as many other statements from `first` on: no index changes, and only what depends is read."""
    changed = {first + place: statement for place, statement in enumerate(others)}
    statements, numbers, meanings = old.statements.copy(), old.numbers.copy(), old.meanings.copy()
    defined, used = old.defined.copy(), old.used.copy()
    names: set[str] = set()  # whose definitions or uses have changed
    for index, statement in changed.items():
        for table, before, now in (
            (defined, _defines(statements[index]), _defines(statement)),
            (used, statements[index].uses, statement.uses),
        ):
            names.update(before, now)
            for name in set(before) - set(now):
                _take_out(table, name, index)
            for name in set(now) - set(before):
                _put_in(table, name, index)
        statements[index], numbers[index] = statement, next(_numbers)
    beats = old.beats
    if any(_is_beat(statement) or index in beats for index, statement in changed.items()):
        beats = [index for index, statement in enumerate(statements) if _is_beat(statement)]
    unused = old.unused
    if names:
        unused = {index for index in unused if names.isdisjoint(_defines(old.statements[index]))}
        unused.update(*(_unused(name, defined, used) for name in names if name in defined))
    nearest = old.nearest if defined.keys() == old.defined.keys() else {}
    wrong = old.wrong.copy()
    new = Analysis(
        lines,
        starts,
        statements,
        numbers,
        meanings,
        defined,
        used,
        beats,
        wrong,
        unused,
        nearest,
        old.cast,
        old.casting.copy(),
    )
    again = _understand_again(new, changed)
    _cast_again(new, again if new.tempo == old.tempo else range(len(statements)))
    return new


def _cast_again(new: Analysis, indices: Iterable[int]) -> None:
    """Look again at what the robots of some statements can do."""
    tempo = new.tempo
    for index in indices:
        meaning = new.meanings[index]
        said = check_casting(new.statements[index], meaning, new.cast, tempo) if meaning.robots else ()
        if said:
            new.casting[index] = said
        else:
            new.casting.pop(index, None)


def _understand_again(new: Analysis, changed: Mapping[int, Statement]) -> list[int]:
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
        before = new.meanings[index]
        scope = new._scope(index)
        if index not in changed and before.scope == tuple(scope.values()):
            continue
        meaning = understand(new.statements[index], new.numbers[index], scope)
        new.meanings[index] = meaning
        again.append(index)
        (new.wrong.add if meaning.diagnostics or meaning.unresolved else new.wrong.discard)(index)
        for definition in (before.definition, meaning.definition):
            if definition:
                for user in users_behind(new, definition.name, index):
                    heappush(waiting, user)
    return again


def _unused(name: str, defined: Mapping[str, list[int]], used: Mapping[str, list[int]]) -> Iterator[int]:
    """The definitions of a name that nothing uses before the next one (which may use it itself) has come."""
    definers, users = defined[name], used.get(name, [])
    if users and users[0] <= definers[0]:
        return  # it is wanted further up: that has been said
    for place, definer in enumerate(definers):
        user = bisect_right(users, definer)
        if user == len(users) or (place + 1 < len(definers) and users[user] > definers[place + 1]):
            yield definer


def _nearest(name: str, names: Iterable[str]) -> str | None:
    """The known word that is most like an unknown one."""
    # Comparing all of thousands of names in full would be felt at every key.
    known = [*_MOVING, *(each for each in names if len(set(each) ^ set(name)) < 4)]
    near = get_close_matches(name, known, n=1) or get_close_matches(name.lower(), known, n=1)
    return near[0] if near else None


def _defines(statement: Statement) -> tuple[str, ...]:
    return (statement.defines,) if statement.defines else ()


def _is_beat(statement: Statement) -> bool:
    return bool(statement.sign and statement.sign.type == "BEAT")


def _put_in(table: dict[str, list[int]], name: str, index: int) -> None:
    indices = table.get(name, []).copy()
    insort(indices, index)
    table[name] = indices


def _take_out(table: dict[str, list[int]], name: str, index: int) -> None:
    indices = [each for each in table[name] if each != index]
    if indices:
        table[name] = indices
    else:
        del table[name]
