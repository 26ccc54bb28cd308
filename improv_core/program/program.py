"""A program: its statements, the meaning of each, and what robots play together."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.program.bindings import Bindings
from improv_core.program.definitions import Definition
from improv_core.program.meaning import Meaning
from improv_core.program.opening import Opening, Repeated, open_with, repeated
from improv_core.robots.config import Robots
from improv_core.score import algebra, dice
from improv_core.score.lengths import lengths, scene_lengths
from improv_core.score.movement import ENDLESS, MAX_BITS, Exact, Lengths, Movement
from improv_core.score.score import performance, scene_begins
from improv_core.slices import checkpoint, in_slices
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Node, Statement
from improv_core.text import LineIndex, Span
from improv_core.values import value

DEFAULT_TEMPO = Fraction(60)
EVEN = 1_000
"""Lengths with denominators up to this can always be added: all of these have a common one of 1,439 bits."""
MAX_SCENES = 500
"""The most scenes of a program: each robot has a movement for each."""


@value(frozen=True, slots=False)
class Program:
    """One version of a document.

    The sequences are parallel, with one entry for each statement: its offset, tree, ID, and meaning. The others hold
    indices of statements: `tempos` of those that set a tempo, `scenes` of the lines `---`, and `openings` of all lines
    of the opening (`---` too, because it may name a scene), which together are the `opening`, and `unusual` as
    `Unusual` describes. `infeasible` lists, by index, what the robots of a statement can't do. `waiting` is a
    heap of statements that have changed, or may depend on a change, until `settled` reaches them. Until then they keep
    their old meanings, and new ones have none. `selected` are the lines that play, if not all of them do.
    """

    lines: LineIndex
    offsets: Sequence[int]
    statements: Sequence[Statement]
    statement_ids: Sequence[int]
    meanings: Sequence[Meaning]
    bindings: Bindings
    tempos: Sequence[int]
    scenes: Sequence[int]
    openings: Sequence[int]
    unusual: Unusual
    config: Robots  # from improv.toml; `opening.config` has the program's changes
    opening: Opening
    infeasible: Mapping[int, tuple[Diagnostic, ...]]
    waiting: Sequence[int] = ()
    selected: Sequence[Line] | None = None

    @property
    def text(self) -> str:
        return self.lines.text

    @cached_property
    def tempo(self) -> Fraction:
        """Beats per minute."""
        return (self.meanings[self.tempos[0]].tempo if self.tempos else None) or DEFAULT_TEMPO

    @cached_property
    def played(self) -> Mapping[int, Line]:
        """Lines that robots play, by index.

        Each begins, for all its robots, at the furthest throw that any of them has reached.
        """
        lines = {}
        throws: dict[str, int] = {}
        for index, (statement_id, meaning) in enumerate(zip(self.statement_ids, self.meanings, strict=True)):
            if not meaning.robots or index in self.too_uneven:
                continue
            checkpoint()
            scene = min(bisect_left(self.breaks, index), MAX_SCENES - 1) if self.scenes else 0
            throw = max([throws.get(robot, 0) for robot in meaning.robots]) if throws else 0
            lines[index] = Line(meaning.parts, statement_id, scene, throw)
            if throw or meaning.movement.bounds.throws:
                throws.update(dict.fromkeys(meaning.robots, throw + meaning.movement.bounds.throws))
        return lines

    @cached_property
    def parts(self) -> Mapping[str, tuple[Movement, ...]]:
        """The movements of each robot in each scene, in order of appearance."""
        plays: dict[str, dict[int, list[Movement]]] = {}
        for line in self._lines:
            for robot, part in line.parts:
                checkpoint()
                begun = algebra.from_statement(dice.throwing(part, line.throw), None, line.statement)
                plays.setdefault(robot, {}).setdefault(line.scene, []).append(begun)
        return {
            robot: tuple([algebra.series(parts.get(scene, ())) for scene in range(self.scene_count)])
            for robot, parts in plays.items()
        }

    @property
    def _lines(self) -> Iterable[Line]:
        return self.played.values() if self.selected is None else self.selected

    @cached_property
    def breaks(self) -> Sequence[int]:
        """Lines `---` that begin a scene: all except one that names the first."""
        return [index for index in self.scenes if index != self._first_name]

    @property
    def scene_count(self) -> int:
        return min(len(self.breaks) + 1, MAX_SCENES)

    @cached_property
    def scene_names(self) -> Sequence[str]:
        """The names of the scenes; "" for one without a name."""
        names = [""] * (len(self.breaks) + 1)
        for index in self.scenes:
            if heads := self.statements[index].heads:
                names[bisect_right(self.breaks, index)] = heads[0].text
        return names[:MAX_SCENES]

    @cached_property
    def _first_name(self) -> int | None:
        """The last line `---` with a name above the first line that plays."""
        named = [index for index in self.scenes if self.statements[index].heads]
        if not named:
            return None
        first = next((index for index, statement in enumerate(self.statements) if statement.kind == "DOLLAR"), 0)
        above = bisect_left(named, first)
        return named[above - 1] if above else None

    @cached_property
    def robots(self) -> Mapping[str, Movement]:
        """The whole movement of each robot, in order of appearance."""
        return {robot: performance(scenes, self.begins) for robot, scenes in self.parts.items()}

    @cached_property
    def all_robots(self) -> Sequence[str]:
        """All robots: those that play something, in order of appearance, then those that only have a place."""
        playing = (robot for line in self._lines for robot, _ in line.parts)
        return list(dict.fromkeys([*playing, *self.opening.places]))

    @cached_property
    def begins(self) -> Sequence[Exact]:
        """The beats at which the scenes begin, up to one that never ends."""
        return scene_begins(self.parts.values())

    @cached_property
    def lengths(self) -> Mapping[str, Lengths]:
        """The lengths of the robots' parts, with all scenes."""
        return dict(zip(self.parts, self._scene_lengths[1], strict=True))

    def scene_begin(self, scene: int) -> Lengths | None:
        """Return the beat at which a scene begins, at the earliest and at the latest; None if it never begins."""
        begins = self._scene_lengths[0]
        return begins[scene] if scene < len(begins) and begins[scene].shortest < ENDLESS else None

    def statement_at(self, offset: int) -> Placed | None:
        """Return the statement that a cursor at `offset` touches."""
        index = bisect_right(self.offsets, offset) - 1
        placed = self.placed(index) if index >= 0 else None
        return placed if placed and placed.span.holds(offset) else None

    def line_number(self, index: int) -> int:
        """Return the line on which a statement starts, counted from 1."""
        return self.lines.number(self.offsets[index])

    def placed(self, index: int) -> Placed:
        meaning = self.meanings[index]
        return Placed(index, self.offsets[index], meaning.statement, meaning)

    def definition(self, name: str, before: int) -> Definition | None:
        """Return the definition of a name that applies at the statement `before`."""
        index = self.bindings.definer(name, before)
        return None if index is None else self.meanings[index].definition

    @cached_property
    def too_uneven(self) -> frozenset[int]:
        """Statements whose length can't be added to those above it for the same robot: the sum is too long."""
        commons: dict[str, int] = {}
        found = set()
        for index in in_slices(sorted(self.unusual.uneven)):
            meaning = self.meanings[index]
            for robot in meaning.robots:
                common = math.lcm(commons.get(robot, 1), _denominator(meaning.movement))
                if common.bit_length() > MAX_BITS:
                    found.add(index)
                else:
                    commons[robot] = common
        return frozenset(found)

    @cached_property
    def repeated(self) -> Mapping[int, Sequence[Repeated]]:
        """Repetitions in lines of the opening of lines above them, by index."""
        return repeated((index, self.statements[index]) for index in self.openings)

    @cached_property
    def near_named(self) -> Mapping[int, Mapping[Token, Sequence[str]]]:
        """Robots with a place that never play, by line, with those that play and whose names differ in case only."""
        placing = [index for index in self.openings if (said := self.meanings[index].said) and said.poses]
        playing = {robot for meaning in self.meanings for robot in meaning.robots} if placing else set()
        alike: dict[str, list[str]] = {}
        for robot in sorted(playing):
            alike.setdefault(robot.lower(), []).append(robot)
        found: dict[int, dict[Token, Sequence[str]]] = {}
        for index in placing:
            for head in self.statements[index].heads:
                others = alike.get(head.text.lower(), ())
                if others and head.text not in playing and head.text not in self.config.robots:
                    found.setdefault(index, {})[head] = others
        return found

    @cached_property
    def alike(self) -> Mapping[int, Mapping[str, str]]:
        """Names that look like names above, each with that name, by the first statements that have them."""
        first: dict[str, str] = {}
        found: dict[int, dict[str, str]] = {}
        spellings = self.bindings.spellings
        tables = (self.bindings.defined, self.bindings.used)
        at = {name: min(index for table in tables for index in table.get(name, ())) for name in spellings}
        for name in sorted(spellings, key=lambda each: (at[each], each)):
            other = first.setdefault(spellings[name], name)
            if other != name:
                found.setdefault(at[name], {})[name] = other
        return found

    @cached_property
    def plays_nothing(self) -> bool:
        """True if no line has robots."""
        return not any(meaning.robots for meaning in self.meanings)

    @cached_property
    def any_robot(self) -> str:
        """A robot for examples: a listed one, else the first that plays, else turtlesim's."""
        playing = (robot for meaning in self.meanings for robot in meaning.robots)
        return next(chain(self.config.robots, playing, self.opening.places), "turtle1")

    @cached_property
    def _scene_lengths(self) -> tuple[Sequence[Lengths], Sequence[Lengths]]:
        return scene_lengths(list(self.parts.values()))


def scene_ids(program: Program) -> frozenset[int]:
    """Return the IDs of the statements that begin scenes."""
    return frozenset(program.statement_ids[index] for index in program.breaks)


@value(frozen=True, slots=True)
class Placed:
    """A statement with its index and its offset in the text."""

    index: int
    start: int
    statement: Statement
    meaning: Meaning

    @property
    def span(self) -> Span:
        return Span(self.start, self.start + len(self.statement.text))

    @property
    def body(self) -> Node | None:
        """The movement, with every use of a phrase together with its arguments."""
        return self.meaning.body or self.statement.body


class Line(NamedTuple):
    """The movements of robots in a scene (from 0), all from the same throw of the dice on, and their statement."""

    parts: Sequence[tuple[str, Movement]]
    statement: int
    scene: int = 0
    throw: int = 0


def opening_of(config: Robots, openings: Sequence[int], meanings: Sequence[Meaning]) -> Opening:
    """Return the opening that these statements make with the robots of an `improv.toml`."""
    return open_with(config, [said for index in openings if (said := meanings[index].said)])


class Unusual(NamedTuple):
    """Statements, by index, of which programs have few: `faulty` ones, lines whose lengths are hard to add (`uneven`),
    and lines that are `endless` for some robot."""

    faulty: frozenset[int] = frozenset()
    uneven: frozenset[int] = frozenset()
    endless: frozenset[int] = frozenset()

    def updated(self, meanings: Sequence[Meaning], indices: Collection[int]) -> Unusual:
        """Return the same after the statements at these indices have got other meanings."""
        others = [each.difference(indices) for each in self]
        lines = [index for index in indices if meanings[index].robots]
        found = (
            [index for index in indices if meanings[index].is_faulty],
            [index for index in lines if _denominator(meanings[index].movement) > EVEN],
            [index for index in lines if any(map(never_ends, (meanings[index].movement, *meanings[index].others)))],
        )
        return Unusual(*map(frozenset.union, others, found))


def never_ends(played: Movement) -> bool:
    """Return whether a movement never ends, whatever senses decide."""
    if not isinstance(played.duration, float):
        return False
    return not played.open or lengths(played).shortest == ENDLESS


def _denominator(played: Movement) -> int:
    return played.duration.denominator if isinstance(played.duration, Fraction) else 1
