"""Movements: velocities over time, exact. Standard library only.

A movement lasts `duration` beats (an exact fraction, or `ENDLESS`) and has a velocity in the robot's own frame, in
steps per beat and quarter turns per beat. Nothing costs time or memory in proportion to a repeat count.

Each kind of movement is a class in `algebra`, `dice`, `ramps`, or `reactions`. It defines its parts, its other fields
(`FIELDS`), the function that makes it (`make`), its length if senses decide it, the throws of its parts, and the way it
plays. Code that walks, measures, compares, writes, or performs movements uses these, and knows no kinds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar, NamedTuple, TypeAlias, TypeVar

from improv_core.score.measured import Bound, Component
from improv_core.score.throws import Dice, T
from improv_core.text import Span
from improv_core.values import value

ENDLESS = math.inf
Exact: TypeAlias = Fraction | int  # whole numbers are int: most are whole, and int is many times faster
Duration: TypeAlias = Fraction | int | float  # the only float is ENDLESS, and its type is the quickest way to tell
NORMAL = Fraction(1)
"""The rate of a movement without Pace. It is a Fraction, because dividing two ints gives a float."""


class Factors(NamedTuple):
    """The factors by which the components of velocities are multiplied."""

    x: Exact = 1
    y: Exact = 1
    z: Exact = 1
    yaw: Exact = 1

    def times(self, other: Factors) -> Factors:
        if other is SAME:
            return self
        return Factors(self.x * other.x, self.y * other.y, self.z * other.z, self.yaw * other.yaw)


class Velocity(NamedTuple):
    """Forward, left, and up in steps per beat; yaw in counterclockwise quarter turns; unless they are `Measure`."""

    x: Component = 0
    y: Component = 0
    z: Component = 0
    yaw: Component = 0

    def plus(self, other: Velocity) -> Velocity:
        return Velocity(self.x + other.x, self.y + other.y, self.z + other.z, self.yaw + other.yaw)

    def times(self, factors: Factors) -> Velocity:
        """Return each component times its factor. Most are zero and need no arithmetic."""
        if factors is SAME:
            return self
        return Velocity(
            self.x and self.x * factors.x,
            self.y and self.y * factors.y,
            self.z and self.z * factors.z,
            self.yaw and self.yaw * factors.yaw,
        )


STILL = Velocity()
SAME = Factors()
DIRECTIONS = Velocity._fields


def exact(number: Fraction) -> Exact:
    """Return the same number, as an int if it is whole."""
    return number if number.denominator != 1 else number.numerator


FINEST = 1_000_000
"""Positions in beats are rounded to this many parts of a beat."""
LARGEST = 10**100
"""The most beats, steps per beat, quarter turns per beat, and items per beat of a movement. With any tempo and step,
the product of any two of them stays below the largest float (1.8e308)."""
MAX_BITS = 4096
"""The most bits of the exact fractions of a movement: nested odd factors multiply."""
MAX_VOICES = 250
"""The most voices that may play at once, including those within names: each is walked by itself."""
MAX_DEPTH = 250
"""The deepest nesting of walks. Each level costs two of Python's levels of recursion."""
MAX_THROWS = 2**MAX_BITS
"""The most throws of one stream: their number is written into each throw's key."""


def near(beat: float) -> Exact:
    """Return a beat rounded to an exact number with few digits."""
    return exact(Fraction(round(beat * FINEST), FINEST))


def all_by(factor: Exact) -> Factors:
    """Return the gain that multiplies every component by `factor`."""
    return Factors(factor, factor, factor, factor)


class Peak(NamedTuple):
    """Bounds: the largest absolute components of the velocity, per beat, and the shortest item in beats."""

    x: Bound
    y: Bound
    z: Bound
    yaw: Bound
    shortest: float


class Asked(NamedTuple):
    """A word for a body part: a direction, which is a component of the velocity, or a pose; neither if it is the word
    for the part itself.

    `part` is "" under no part. It is `mirrored` in an odd number of reflections that swap left and right. A direction
    that a program measures is also listed with each kind of `unit`, a field of `Measure`.
    """

    part: str
    mirrored: bool = False
    direction: str = ""
    pose: str = ""
    unit: str = ""


class BodyWords(NamedTuple):
    """The words for body parts in a movement, and the bounds of their velocities, as in `Bounds.peak`."""

    asked: frozenset[Asked]
    peak: Peak

    @property
    def parts(self) -> frozenset[str]:
        """The words for body parts."""
        return frozenset(each.part for each in self.asked if each.part)

    @property
    def has_poses(self) -> bool:
        return bool(self.asked) and any(each.pose for each in self.asked)

    @property
    def loose_poses(self) -> Sequence[str]:
        """Return the poses that are under no part."""
        return sorted([each.pose for each in self.asked if not each.part])


NO_BODY_WORDS = BodyWords(frozenset(), Peak(0.0, 0.0, 0.0, 0.0, math.inf))


@value(frozen=True, slots=True, eq=False)
class Bounds:
    """The bounds of a movement. Thousands of movements share a few, so they are compared by identity.

    `peak` bounds all moments. `width` is the number of voices that may play at once, `bits` that of the bits that the
    factors around its moments may add to their fractions, and `depth` that of nested walks (in voices, ramps, and open
    movements). With `dice`, it contains a word of dice, even one that is never reached, and it takes `throws` throws of
    its stream. If it is `open`, senses decide what is performed. `body` is about the words for body parts.
    """

    peak: Peak
    width: int
    bits: int
    depth: int
    dice: bool
    throws: int
    open: bool = False
    body: BodyWords = NO_BODY_WORDS


NOWHERE = -1
"""The statement ID of movements outside all statements."""


class Source(NamedTuple):
    """A span that counts from the start of its statement, and that statement's ID.

    Movements stay valid while the statements before them change, so they hold no offsets in the document.
    """

    statement: int
    span: Span


class Around(NamedTuple):
    """The context of a part that plays: its rate and gain, the statement it is written in, and the words around it."""

    rate: Fraction = NORMAL
    gain: Factors = SAME
    statement: int = NOWHERE
    sources: tuple[Source, ...] = ()

    def at(self, span: Span | None) -> tuple[Source, ...]:
        """Return the words that play, including one that is written at `span` here."""
        return (*self.sources, Source(self.statement, span)) if span else self.sources


NOTHING_AROUND = Around()


class Visit(NamedTuple):
    """A part that plays from its beat `at` on, perhaps backward, and the dice at its beginning if it has any."""

    part: Movement
    at: Duration
    backward: bool
    dice: Dice | None


Piece: TypeAlias = tuple[Exact, Velocity, tuple[Source, ...]]
"""The beats of a constant velocity, that velocity, and the words that play."""


class Lengths(NamedTuple):
    """The shortest and the longest that a movement lasts, in beats.

    A movement that senses cut short has no shortest length, so `shortest` is 0 then. Only if it `may_be_empty` can it
    take no time at all, as one side of an `if` may.
    """

    shortest: Duration
    longest: Duration
    may_be_empty: bool

    @property
    def is_fixed(self) -> bool:
        return self.shortest == self.longest


def one_after_another(items: Sequence[Lengths]) -> Lengths:
    """Return the lengths of movements in series."""
    return Lengths(
        sum(each.shortest for each in items),
        sum(each.longest for each in items),
        all(each.may_be_empty for each in items),
    )


class JsonForm(NamedTuple):
    """The way in which a value is written as JSON, and read. Reading raises an exception if the value is wrong."""

    write: Callable[[Any], Any]
    read: Callable[[Any], Any]


@dataclass(slots=True)
class KnownResults:
    """Results about a movement, kept since somebody asked for them. Few movements of a long program have any."""

    lengths: dict[Fraction, Lengths] = field(default_factory=dict)  # those of an open movement at some rates
    scale: bool = True  # True if they are half as long at twice the rate: it never waits for a whole beat
    ends: Sequence[Duration] | None = None  # the beat at which each item of a series ends


@value(frozen=True, slots=True, eq=False)
class Movement:
    """A movement. Made by the functions beside each kind, never directly.

    `uniform` is its velocity if that never changes. `FIELDS` are its fields besides its parts. `make` makes a movement
    of its kind from parts and the values of these fields, and raises an exception if they don't fit.
    """

    duration: Duration
    uniform: Velocity | None
    bounds: Bounds
    _known: KnownResults = field(init=False, repr=False)
    """A cache, which is not set before it is asked for: the other fields decide what is in it."""

    NAME: ClassVar[str]
    FIELDS: ClassVar[tuple[tuple[str, JsonForm], ...]] = ()
    make: ClassVar[Callable[..., Movement]]

    @property
    def parts(self) -> tuple[Movement, ...]:
        """The movements directly inside."""
        return ()

    def made_of(self, parts: Sequence[Movement]) -> Movement:
        return self.make(parts, *(getattr(self, name) for name, _ in self.FIELDS))

    def within(self, around: Around) -> Around:
        """Return the surroundings of its parts, given its own."""
        return around

    def throw_of(self, index: int, throw: T) -> T:
        """Return the throw with which part `index` begins, given the one with which the whole begins."""
        return throw

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        """Return its lengths if it is open, given those of its parts."""
        return one_after_another(parts)

    @property
    def waits(self) -> bool:
        """True if that includes standing until a whole beat, which takes as long at any rate."""
        return False

    @property
    def known(self) -> KnownResults:
        try:
            return self._known
        except AttributeError:
            object.__setattr__(self, "_known", KnownResults())  # a movement is frozen
            return self._known

    @property
    def dice(self) -> bool:
        return self.bounds.dice

    @property
    def open(self) -> bool:
        return self.bounds.open

    @property
    def body_words(self) -> BodyWords:
        return self.bounds.body


@value(frozen=True, slots=True, eq=False)
class Single(Movement):
    """A movement made of one other movement."""

    body: Movement

    @property
    def parts(self) -> tuple[Movement, ...]:
        return (self.body,)


@value(frozen=True, slots=True, eq=False)
class Several(Movement):
    """A movement made of several others."""

    items: tuple[Movement, ...]

    @property
    def parts(self) -> tuple[Movement, ...]:
        return self.items


class Through(Movement):
    """A movement in which one of its parts plays in its place."""

    __slots__ = ()

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        """Return the part that plays from beat `at` on, or back from there."""
        (body,) = self.parts
        return Visit(body, at, backward, dice)


class InTurn(Movement):
    """A movement whose parts play one after another."""

    __slots__ = ()

    def visits(self, at: Duration, backward: bool, dice: Dice | None) -> Iterator[Visit]:
        """Yield the parts that play from beat `at` on, or back from there, in the order they play."""
        raise NotImplementedError


class Piecewise(Movement):
    """A movement whose pieces are computed from those of its parts."""

    __slots__ = ()

    def pieces(
        self, at: Duration, backward: bool, dice: Dice | None, walk: Callable[[Visit], Iterator[Piece]]
    ) -> Iterator[Piece]:
        """Yield the pieces from beat `at` on, or back from there. `walk` yields those of a part."""
        raise NotImplementedError


F = TypeVar("F", bound=Callable[..., Movement])


def makes(kind: type[Movement]) -> Callable[[F], F]:
    """Mark the function that makes a kind of movement: of one part, or of a sequence of them."""

    def marked(make: F) -> F:
        def of_parts(parts: Sequence[Movement], *values: Any) -> Movement:
            return make(*parts, *values)

        kind.make = staticmethod(make if issubclass(kind, Several) else of_parts)
        return make

    return marked


def require_end(body: Movement) -> None:
    """Raise ValueError if a movement is endless, or if senses decide when it ends."""
    if isinstance(body.duration, float) or body.open:
        raise ValueError("a movement that is endless or open has no end that is known")


def bits(number: Exact) -> int:
    """Return the number of bits of an exact number, where 1 and -1 have none."""
    # Most are whole, and bits are counted for each statement.
    return number.bit_length() - 1 if type(number) is int else sum(map(int.bit_length, number.as_integer_ratio())) - 2
