"""The words for a motion: those of the robot's profile where they fit, measures otherwise. Standard library only."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from improv_core.score.primitives import pace_text
from improv_core.score.profiles import Profile
from improv_core.transcription.amounts import Amounts

_WAYS = ("forward", "backward"), ("strafeleft", "straferight"), ("up", "down")
_TURNS, _HALVES = ("left", "right"), ("halfleft", "halfright")
"""The words for positive and negative amounts."""
_NEGATED = {one: other for pair in (*_WAYS, _TURNS, _HALVES) for one, other in (pair, pair[::-1])}
"""Each word that `retrograde` changes, and what it becomes."""
_MIRRORED = {one: other for one, other in _NEGATED.items() if one.endswith(("left", "right"))}
"""Each word that `reflect sagittal` changes, and what it becomes."""
_MIRROR, _RETROGRADE, _REVERSE = 1, 2, 4
TURNS = tuple(
    " ".join(word for bit, word in ((4, "reverse"), (2, "retrograde"), (1, "reflect sagittal")) if turns & bit)
    for turns in range(8)
)
"""The words that turn a phrase: each is the sum of a mirror image (1), of the way back (2), and of its reverse (4)."""
LENGTHS = tuple(Fraction(1, parts) for parts in (10, 20, 100, 1000, 10_000))
"""Meters to which a length is rounded, as people would: the coarsest that is near enough."""
ANGLES = (Fraction(15), Fraction(5), Fraction(1), Fraction(1, 2), Fraction(1, 10), Fraction(1, 100), Fraction(1, 1000))
"""Degrees to which an angle is rounded."""
_REPEAT_COST = 2.7
"""A `repeat` costs more than a `slow`, which motions beside each other can share."""
_MAX_COPIES = 24
"""The most beats of a motion that may be written as one word for each beat; a longer one is one slow word."""


class WordedVoice(NamedTuple):
    """A word that moves, with its measure in meters or degrees and its radius in meters, if it has them. With
    `frontal`, it is reflected so that it goes backward."""

    word: str
    measure: Fraction | None = None
    radius: Fraction | None = None
    frontal: bool = False

    @property
    def text(self) -> str:
        written = angle_text if self.word in _TURNS else length_text
        measure = "" if self.measure is None else f" {written(self.measure)}"
        radius = "" if self.radius is None else f" radius {length_text(self.radius)}"
        return f"{'reflect frontal ' if self.frontal else ''}{self.word}{measure}{radius}"


@dataclass(frozen=True, slots=True)
class Move:
    """Voices that move a robot together for a number of beats: in all of these, as far as otherwise in one."""

    beats: Fraction
    voices: tuple[WordedVoice, ...]


@dataclass(frozen=True, slots=True)
class NodeSeries:
    """Nodes one after another."""

    items: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Shaped:
    """A node with a transformer in front of it, such as `repeat 4` or `ease`."""

    by: str
    numbers: tuple[Fraction, ...]
    body: Node


@dataclass(frozen=True, slots=True)
class Bracketed:
    """Moves of equal length that fill one beat."""

    items: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Named:
    """A name that is defined in the program."""

    name: str


Node: TypeAlias = "Move | NodeSeries | Shaped | Bracketed | Named"
REST = Move(Fraction(1), (WordedVoice("rest"),))


def series_text(node: Node) -> str:
    """Return a node as one or more terms."""
    return " ".join(term_text(each) for each in node.items) if isinstance(node, NodeSeries) else term_text(node)


@lru_cache(maxsize=10_000)
def term_text(node: Node) -> str:
    """Return a node as one term."""
    match node:
        case Named(name):
            return name
        case Bracketed(items):
            return f"[{' '.join(map(term_text, items))}]"
        case NodeSeries():
            return f"({series_text(node)})"
        case Shaped(by, numbers, body):
            return " ".join([by, *map(str, numbers), term_text(body)])
        case Move(beats, voices):
            together = " || ".join(voice.text for voice in voices)
            one = f"({together})" if len(voices) > 1 else together
            return one if beats == 1 else f"{pace_text(beats)} {one}"


def _decimal(number: Fraction) -> str:
    return f"{float(number):.6f}".rstrip("0").rstrip(".")


def length_text(meters: Fraction) -> str:
    """Return a length as people write it: `1.5m`, `40cm`, `289mm`."""
    if meters < 1 and (meters * 100).denominator == 1:
        return f"{meters * 100}cm"
    if meters < 1 and (meters * 1000).denominator == 1:
        return f"{meters * 1000}mm"
    return f"{_decimal(meters)}m"


def angle_text(degrees: Fraction) -> str:
    return f"{_decimal(degrees)}deg"


_TOKENS = re.compile(r"[0-9.]+(?:/[0-9]+)?|\w+|\|\||[()\[\]]")


@lru_cache(maxsize=10_000)
def cost(node: Node) -> float:
    """Return how much there is to read: a word costs one, a number more the longer it is, a bracket little."""
    return cost_of_text(term_text(node))


def cost_of_text(text: str) -> float:
    total = 0.0
    for token in _TOKENS.findall(text):
        if token[0] in "()|":
            total += 0.3
        elif token[0] in "[]":  # a reader has to count what is in it
            total += 0.6
        elif token[0].isdigit():
            total += 0.8 + 0.2 * len(token)
        elif token not in ("m", "cm", "mm", "deg"):
            total += 1.0
    return total


class Rounding(NamedTuple):
    """The distance that the words of a motion may be from it in all, in meters and radians."""

    meters: float
    radians: float

    def times(self, factor: float) -> Rounding:
        return Rounding(self.meters * factor, self.radians * factor)


def moves_for(beats: Fraction, amounts: Amounts, profile: Profile, rounding: Rounding) -> tuple[Move, ...]:
    """Return the cheapest moves that make this motion, within what rounding allows: one, or one in each beat."""
    whole = [(each,) for each in _moves(beats, amounts, profile, rounding)]
    count = beats.numerator
    if beats.denominator > 1 or not 1 < count <= _MAX_COPIES:
        return min(whole, key=_cost_of_copies)
    one, near = amounts.times(1 / count), rounding.times(1 / count)
    copies = [(each,) * count for each in _moves(Fraction(1), one, profile, near)]
    return copies[0] if is_rest(copies[0][0]) else min(whole + copies, key=_cost_of_copies)


def _cost_of_copies(moves: Sequence[Move]) -> float:
    """Return what moves cost there and back, the cheaper one mostly: a way back has the words of the way there."""
    less, more = sorted((cost(moves[0]), cost(turned(_RETROGRADE, moves[0]))))
    one = 0.8 * less + 0.2 * more
    return one if len(moves) == 1 else min(one * len(moves), one + _REPEAT_COST)


def is_rest(node: Node) -> bool:
    return isinstance(node, Move) and node.voices == REST.voices


def _components(amounts: Amounts, profile: Profile, rounding: Rounding) -> Iterator[tuple[float, str, float, float]]:
    """Yield each component that is not nearly zero: its value, its word, what the plain word moves, what is allowed."""
    for value, words in zip(amounts[:3], _WAYS, strict=True):
        if abs(value) > rounding.meters:
            yield value, words[value < 0], profile.step, rounding.meters
    if abs(amounts.yaw) > rounding.radians:
        yield amounts.yaw, _TURNS[amounts.yaw < 0], profile.quarter_turn, rounding.radians


def _moves(beats: Fraction, amounts: Amounts, profile: Profile, rounding: Rounding) -> Iterator[Move]:
    """Yield moves that each make the motion in all its beats."""
    voices = [_measured(*component) for component in _components(amounts, profile, rounding)]
    yield Move(beats, tuple(voices) or (WordedVoice("rest"),))
    if abs(amounts.x) > rounding.meters and abs(amounts.yaw) > rounding.radians:
        turn, ahead = abs(amounts.yaw), abs(amounts.x)
        *beside, arc = (_measured(*each) for each in _components(amounts._replace(x=0.0), profile, rounding))
        radius = _rounded(ahead / turn, LENGTHS, rounding.meters / turn)
        yield Move(beats, (arc._replace(radius=radius, frontal=amounts.x < 0), *beside))


def _measured(value: float, word: str, unit: float, allowed: float) -> WordedVoice:
    """Return the word with a measure, or without one if it fits as it is."""
    if abs(abs(value) - unit) <= allowed:
        return WordedVoice(word)
    if word in _TURNS:
        if abs(abs(value) - unit / 2) <= allowed:
            return WordedVoice(f"half{word}")
        return WordedVoice(word, _rounded(math.degrees(abs(value)), ANGLES, math.degrees(allowed)))
    return WordedVoice(word, _rounded(abs(value), LENGTHS, allowed))


def _rounded(value: float, levels: Sequence[Fraction], allowed: float) -> Fraction:
    """Round to the coarsest level that is near enough, or else to the finest one; never to zero."""
    found = levels[-1]
    for level in levels:
        if count := round(value / level):
            found = count * level
            if abs(float(found) - value) <= allowed:
                break
    return found


def place_near(value: float, allowed: float) -> float:
    """Return a coordinate that is rounded like a length, or to 0."""
    return math.copysign(float(_rounded(abs(value), LENGTHS, allowed)), value) if abs(value) > allowed else 0.0


def amounts_of(move: Move, profile: Profile) -> Amounts:
    """Return what a move moves in all its beats."""
    total = [0.0, 0.0, 0.0, 0.0]
    for voice in move.voices:
        for place, value in enumerate(_amounts(voice, profile)):
            total[place] += value
    return Amounts(*total)


def _amounts(voice: WordedVoice, profile: Profile) -> Amounts:
    word, measure, radius, frontal = voice
    for pair, plain in ((_TURNS, profile.quarter_turn), (_HALVES, profile.quarter_turn / 2)):
        if word in pair:
            turn = math.radians(measure) if measure is not None else plain
            ahead = float(radius) * turn if radius is not None else 0.0
            return Amounts(-ahead if frontal else ahead, 0.0, 0.0, -turn if word == pair[1] else turn)
    way = float(measure) if measure is not None else profile.step
    x, y, z = (way * ((word == ahead) - (word == back)) for ahead, back in _WAYS)
    return Amounts(x, y, z, 0.0)


def turned(turns: int, node: Node) -> Node:
    """Return what `around` makes of a node: the same, without these words."""
    match node:
        case Move():
            return _turned_move(node, turns)
        case NodeSeries(items):
            return NodeSeries(turned_items(turns, items))
        case Bracketed(items):
            return Bracketed(turned_items(turns, items))
        case Shaped(by, numbers, body):
            if by in TURNS:
                return around(TURNS.index(by) ^ turns, body)
            return Shaped(by, numbers[:: _order(turns)], turned(turns, body))
        case Named():
            return around(turns, node)


def turned_items(turns: int, items: Sequence[Node]) -> tuple[Node, ...]:
    """Return the items of a series that is turned so."""
    return tuple(turned(turns, each) for each in items[:: _order(turns)])


def _order(turns: int) -> int:
    return -1 if turns & (_RETROGRADE | _REVERSE) in (_RETROGRADE, _REVERSE) else 1


@lru_cache(maxsize=20_000)
def _turned_move(node: Move, turns: int) -> Move:
    voices = []
    for word, measure, radius, frontal in node.voices:
        if turns & _MIRROR:
            word = _MIRRORED.get(word, word)
        if turns & _RETROGRADE:
            word, frontal = _NEGATED.get(word, word), frontal != (radius is not None)
        voices.append(WordedVoice(word, measure, radius, frontal))
    return replace(node, voices=tuple(voices))


def around(turns: int, node: Node) -> Node:
    """Return a node with the words before it that turn it so; none for 0."""
    return Shaped(TURNS[turns], (), node) if turns else node
