"""What a movement is: a velocity over time, exact. Standard library only.

A movement lasts `duration` beats (an exact fraction, or `ENDLESS`) and has a velocity in the robot's own frame, in
steps per beat and quarter turns per beat. Nothing costs time or memory in proportion to a repeat count.

Each kind of movement is a class in `algebra`, `dice`, `ramps`, or `reactions`. It says what its parts are, what else
makes it (`FIELDS`), how it is made (`make`), how long it lasts if senses decide, which throw each part begins with, and
how it plays. All that walks, measures, compares, writes, or performs movements asks that, and knows no kinds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, NamedTuple, TypeAlias, TypeVar

from improv_core.score.throws import Dice, T
from improv_core.text import Span

ENDLESS = math.inf
Exact: TypeAlias = Fraction | int  # whole numbers are int: most are whole, and int is many times faster
Duration: TypeAlias = Fraction | int | float  # the only float is ENDLESS, and its type is the quickest way to tell
NORMAL = Fraction(1)
"""The rate of a movement without Pace. It is a Fraction, because dividing two ints gives a float."""


class Velocity(NamedTuple):
    """Forward, left, and up in steps per beat; yaw in quarter turns per beat, counterclockwise."""

    x: Exact = 0
    y: Exact = 0
    z: Exact = 0
    yaw: Exact = 0

    def plus(self, other: Velocity) -> Velocity:
        return Velocity(self.x + other.x, self.y + other.y, self.z + other.z, self.yaw + other.yaw)

    def times(self, other: Velocity) -> Velocity:
        """Each component times the same component of `other`. Most are zero and need no arithmetic."""
        if other is SAME:
            return self
        return Velocity(
            self.x and self.x * other.x,
            self.y and self.y * other.y,
            self.z and self.z * other.z,
            self.yaw and self.yaw * other.yaw,
        )


STILL = Velocity()
SAME = Velocity(1, 1, 1, 1)
SILENT = Velocity(0, 0, 0, 0)
"""The gain of what stands still."""
DIRECTIONS = Velocity._fields


def exact(number: Fraction) -> Exact:
    """The same number, as an int if it is whole."""
    return number if number.denominator != 1 else number.numerator


FINEST = 1_000_000
"""Positions in beats are rounded to this many parts of a beat."""


LARGEST = 10**100
"""The most beats, steps per beat, quarter turns per beat, and items per beat of a movement.

With any tempo and step, the product of any two of them stays below the largest float (1.8e308).
"""
MOST_BITS = 4096
"""The most bits of the exact fractions of a movement: nested odd factors multiply."""
MOST_VOICES = 250
"""How many voices may play at once, including those within names: each is walked by itself."""
MOST_DEPTH = 250
"""How deeply walks may be nested. Each level costs two of Python's levels of recursion."""
MOST_THROWS = 2**MOST_BITS
"""The most throws of one stream: their number is written into each throw's key."""


LONGEST_WRITTEN = 4096
"""The most bits of a number that is written in full: Python refuses to write integers of more than 4,300 digits."""


def near(beat: float) -> Exact:
    """A beat rounded to an exact number with few digits."""
    return exact(Fraction(round(beat * FINEST), FINEST))


def brief(number: Exact) -> Exact:
    """A number short enough to write: itself, or the nearest with a denominator up to `FINEST`.

    The statements of one robot may add up to fractions of any length.
    """
    return number if bits(number) <= LONGEST_WRITTEN else exact(Fraction(number).limit_denominator(FINEST))


def all_by(factor: Exact) -> Velocity:
    """The gain that multiplies every component by `factor`."""
    return Velocity(factor, factor, factor, factor)


class Peak(NamedTuple):
    """Bounds: the largest absolute components of the velocity, and the shortest item in beats."""

    x: float
    y: float
    z: float
    yaw: float
    shortest: float


class Asked(NamedTuple):
    """What a word asks of a body part: a direction, which is a component of the velocity, or a pose; neither if it is
    the word for the part itself.

    `part` is "" under no part. It is `mirrored` in an odd number of reflections that swap left and right.
    """

    part: str
    mirrored: bool = False
    direction: str = ""
    pose: str = ""


class BodyWords(NamedTuple):
    """What is asked of body parts in a movement, and the bounds of how fast they move, as `Bounds.peak` has them."""

    asked: frozenset[Asked]
    peak: Peak

    @property
    def parts(self) -> frozenset[str]:
        """The words for body parts."""
        return frozenset(each.part for each in self.asked if each.part)

    @property
    def has_poses(self) -> bool:
        return any(each.pose for each in self.asked)

    @property
    def loose_poses(self) -> Sequence[str]:
        """The poses that stand under no part."""
        return sorted(each.pose for each in self.asked if not each.part)


NO_BODY_WORDS = BodyWords(frozenset(), Peak(0.0, 0.0, 0.0, 0.0, math.inf))


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """What bounds a movement. Thousands of movements share a few, so they are compared by identity.

    `peak` bounds all moments. `width` is how many voices may play at once. `bits` is how many bits the factors around
    its moments may add to their fractions. `depth` is how deeply walks are nested (in voices, ramps, and all that is
    open). `dice` tells whether a word of dice stands in it, even if it is never reached. `throws` is how many throws of
    its stream it takes. `open` tells whether senses decide what is performed (see `reactions`). All of this is about
    the base; `body` is about what stands under words for body parts.
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
    """What surrounds a part that plays: its rate and gain, the statement it is written in, and the words around it."""

    rate: Fraction = NORMAL
    gain: Velocity = SAME
    statement: int = NOWHERE
    sources: tuple[Source, ...] = ()

    def at(self, span: Span | None) -> tuple[Source, ...]:
        """The words that play, with one that is written at `span` here."""
        return (*self.sources, Source(self.statement, span)) if span else self.sources


NOTHING_AROUND = Around()


class Visit(NamedTuple):
    """A part that plays, from which of its beats on, whether backward, and the dice at its beginning if it has any."""

    part: Movement
    at: Duration
    backward: bool
    dice: Dice | None


Piece: TypeAlias = tuple[Exact, Velocity, tuple[Source, ...]]
"""Beats of constant velocity, and the words that play."""


class Lengths(NamedTuple):
    """The shortest and the longest that a movement lasts, in beats.

    What senses cut short has no shortest length, so `shortest` is 0 then. Only if it `may_be_empty` can it take no time
    at all, as one side of an `if` may.
    """

    shortest: Duration
    longest: Duration
    may_be_empty: bool

    @property
    def is_fixed(self) -> bool:
        return self.shortest == self.longest


def one_after_another(items: Sequence[Lengths]) -> Lengths:
    """How long movements last in series."""
    return Lengths(
        sum(each.shortest for each in items),
        sum(each.longest for each in items),
        all(each.may_be_empty for each in items),
    )


class JsonForm(NamedTuple):
    """How a value is written as JSON, and read. Reading raises an exception if the value is wrong."""

    write: Callable[[Any], Any]
    read: Callable[[Any], Any]


WHERE = frozenset({"span", "statement"})
"""The fields that only say where a movement is written."""


class KnownLengths(dict[Fraction, "Lengths"]):
    """How long an open movement lasts at some rates. If its lengths `scale`, they are half as long at twice the rate:
    nowhere in it does a robot stand until a whole beat."""

    scale = True


class _Measured:
    """Keeps how long it lasts, once somebody has asked. That is no field of a movement: it follows from them."""

    __slots__ = ("_lengths",)
    _lengths: KnownLengths

    @property
    def known_lengths(self) -> KnownLengths:
        try:
            return self._lengths
        except AttributeError:
            object.__setattr__(self, "_lengths", KnownLengths())  # a movement is frozen
            return self._lengths


@dataclass(frozen=True, slots=True, eq=False)
class Movement(_Measured):
    """A movement. Made by the functions beside each kind, never directly.

    `uniform` is its velocity if that never changes. `FIELDS` are what makes it besides its parts. `make` makes one of
    its kind from parts and the values of these fields, and raises an exception if they don't fit.
    """

    duration: Duration
    uniform: Velocity | None
    bounds: Bounds

    NAME: ClassVar[str]
    FIELDS: ClassVar[tuple[tuple[str, JsonForm], ...]] = ()
    make: ClassVar[Callable[..., Movement]]

    @property
    def parts(self) -> tuple[Movement, ...]:
        """The movements directly inside."""
        return ()

    def made_of(self, parts: Sequence[Movement]) -> Movement:
        """The same, made of other parts."""
        return self.make(parts, *(getattr(self, name) for name, _ in self.FIELDS))

    def within(self, around: Around) -> Around:
        """What surrounds its parts, by what surrounds itself."""
        return around

    def throw_of(self, index: int, throw: T) -> T:
        """The throw with which part `index` begins, by the one with which the whole begins."""
        return throw

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        """How long it lasts if it is open, by how long its parts last."""
        return one_after_another(parts)

    @property
    def waits(self) -> bool:
        """Whether that includes standing until a whole beat, which takes as long at any rate."""
        return False

    @property
    def peak(self) -> Peak:
        return self.bounds.peak

    @property
    def width(self) -> int:
        return self.bounds.width

    @property
    def bits(self) -> int:
        return self.bounds.bits

    @property
    def depth(self) -> int:
        return self.bounds.depth

    @property
    def dice(self) -> bool:
        return self.bounds.dice

    @property
    def throws(self) -> int:
        return self.bounds.throws

    @property
    def open(self) -> bool:
        return self.bounds.open

    @property
    def body_words(self) -> BodyWords:
        return self.bounds.body


@dataclass(frozen=True, slots=True, eq=False)
class Single(Movement):
    """A movement made of one other movement."""

    body: Movement

    @property
    def parts(self) -> tuple[Movement, ...]:
        return (self.body,)


@dataclass(frozen=True, slots=True, eq=False)
class Several(Movement):
    """A movement made of several others."""

    items: tuple[Movement, ...]

    @property
    def parts(self) -> tuple[Movement, ...]:
        return self.items


class Through(Movement):
    """A movement in whose place one of its parts plays."""

    __slots__ = ()

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        """The part that plays from beat `at` on, or back from there."""
        (body,) = self.parts
        return Visit(body, at, backward, dice)


class InTurn(Movement):
    """A movement whose parts play one after another."""

    __slots__ = ()

    def visits(self, at: Duration, backward: bool, dice: Dice | None) -> Iterator[Visit]:
        """The parts that play from beat `at` on, or back from there, in the order they play."""
        raise NotImplementedError


class Piecewise(Movement):
    """A movement whose pieces are computed from those of its parts."""

    __slots__ = ()

    def pieces(
        self, at: Duration, backward: bool, dice: Dice | None, walk: Callable[[Visit], Iterator[Piece]]
    ) -> Iterator[Piece]:
        """The pieces from beat `at` on, or back from there. `walk` gives those of a part."""
        raise NotImplementedError


F = TypeVar("F", bound=Callable[..., Movement])


def makes(kind: type[Movement]) -> Callable[[F], F]:
    """Marks the function that makes a kind of movement: of one part, or of a sequence of them."""

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
    """The number of bits of an exact number, where 1 and -1 have none."""
    above, below = number.as_integer_ratio()  # one call, where `numerator` and `denominator` of a fraction are two
    return above.bit_length() + below.bit_length() - 2
