"""The handle of a movement on the floor, and what becomes of its word when somebody drags the handle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from itertools import chain, islice
from typing import NamedTuple

from improv_core.diagnostics import Edit
from improv_core.ide.cursor import cursor
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import ENDLESS, Source, Velocity
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, Score, in_axes, twist
from improv_core.score.walk import walk
from improv_core.syntax import nodes
from improv_core.syntax.vocabulary import UNITS
from improv_core.text import Span

MAX_MOMENTS = 2_000
"""The moments of a part in which a word is looked for."""
MAX_GHOSTS = 100
"""The places that are shown where the same word ends, too."""
LENGTHS, ANGLES = (Fraction(1, 10), Fraction(1, 100)), (Fraction(15), Fraction(1))
"""The meters and degrees to which a handle snaps, and those to which it moves freely."""
_TRIED = 60
_HALVINGS = 20
_SAME = 1e-6
_WORDS = (("forward", "backward"), ("strafeleft", "straferight"), ("up", "down"), ("left", "right"))
"""The words that move a robot along and against each axis."""


Ends = tuple[float, float, float, float]
"""The place of a movement's end on the floor, which is ahead of the robot for a turn, and that of the robot then, in
meters."""


class Handle(NamedTuple):
    """The end of a movement, whose words are in a span. The same words end at `others`, too."""

    robot: str
    span: Span
    text: str
    place: Ends
    others: Sequence[Ends]


@dataclass(frozen=True, slots=True)
class _Performance:
    """A word as a robot once plays it: from a pose on, in stretches of one velocity, each with its seconds."""

    robot: str
    profile: Profile
    start: Pose
    legs: Sequence[tuple[Twist, float]]
    amounts: Twist  # what the word itself moves, in meters and radians

    @property
    def turns(self) -> bool:
        """True if the robot stays where it is."""
        return not any(moving.x or moving.y for moving, _ in self.legs)

    def end(self, factor: float = 1.0) -> Pose:
        """Return the pose at its end, if the word moves this many times as far."""
        pose = self.start
        mine = self.amounts
        for moving, seconds in self.legs:
            axes = zip((moving.x, moving.y, moving.z, moving.yaw), (mine.x, mine.y, mine.z, mine.yaw), strict=True)
            pose = pose.after(Twist(*(each * factor if own else each for each, own in axes)), seconds)
        return pose

    def place(self, factor: float = 1.0) -> tuple[float, float]:
        pose = self.end(factor)
        if self.turns:
            pose = pose.then(Pose(self._arm))
        return pose.x, pose.y

    @property
    def ends(self) -> Ends:
        pose = self.end()
        return *self.place(), pose.x, pose.y

    @property
    def _arm(self) -> float:
        return max(self.profile.step / 2, 2 * self.profile.radius)

    def factor_for(self, to: tuple[float, float]) -> float:
        """Return how many times as far the word has to move so that its handle comes nearest to a place."""
        mine = self.amounts
        if self.turns:
            here = self.end()
            off = math.remainder(math.atan2(to[1] - here.y, to[0] - here.x) - here.heading, math.tau)
            turned = math.fsum(moving.yaw * seconds for moving, seconds in self.legs)
            return 1 + off / turned

        if mine.yaw:  # an arc goes around once at most, and not backward
            return _least(lambda factor: math.dist(self.place(factor), to), 0.0, math.tau / abs(mine.yaw))
        zero, one = self.place(0.0), self.place(1.0)  # its end is on a line, even while other words turn it
        along = complex(*one) - complex(*zero)
        if abs(along) < _SAME:
            return 1.0
        return ((complex(*to) - complex(*zero)) / along).real


def handle_at(analysis: Analysis, offset: int) -> Handle | None:
    """Return the handle of the movement at an offset; None if the word there moves no robot on the floor, or if its
    measure is computed."""
    if not (found := _word_at(analysis, offset)):
        return None
    span, _, played = found
    first = next(played)
    others = [other.ends for other in islice(played, MAX_GHOSTS)]
    return Handle(first.robot, span, analysis.text[slice(*span)], first.ends, others)


def bent(analysis: Analysis, offset: int, to: tuple[float, float], freely: bool) -> tuple[Edit, ...]:
    """Return the edit of the movement at an offset after somebody has dragged its handle to a place; none if it has no
    handle, or nothing changes. It snaps to the first of `LENGTHS` and `ANGLES`, or `freely` to the second."""
    return _edited(analysis, offset, freely, lambda played, amount, level: amount * played.factor_for(to))


def lengthened(analysis: Analysis, offset: int, steps: int, freely: bool) -> tuple[Edit, ...]:
    """Return the edit that moves the handle at an offset by this many of the amounts to which it snaps."""

    def wanted(played: _Performance, amount: float, level: Fraction) -> float:
        along = math.copysign(1, amount)
        passed = abs(amount) / level
        whole = math.floor(passed + _SAME) if steps > 0 else math.ceil(passed - _SAME)
        return along * (whole + steps or steps) * level

    return _edited(analysis, offset, freely, wanted)


def _edited(
    analysis: Analysis, offset: int, freely: bool, wanted: Callable[[_Performance, float, Fraction], float]
) -> tuple[Edit, ...]:
    if not (found := _word_at(analysis, offset)):
        return ()
    span, node, performances = found
    played = next(performances)
    axis, amount = _axis(played)
    level = (ANGLES if axis == 3 else LENGTHS)[freely]
    before = analysis.text[slice(*span)]
    after = _written(before, node, played, wanted(played, amount, level), level)
    return () if after == before else (Edit(span, after),)


Word = nodes.Primitive | nodes.MeasuredWord


def _word_at(analysis: Analysis, offset: int) -> tuple[Span, Word, Iterator[_Performance]] | None:
    """Return the word at an offset with its span and its performances, of which there is at least one."""
    found = cursor(analysis, offset)
    if found and not isinstance(found.node, Word):  # a bracket, perhaps behind a word
        found = cursor(analysis, offset, before=True)
    node = found.node if found else None
    if not found or not isinstance(node, Word) or not analysis.ok:
        return None
    if any(isinstance(each, nodes.PartTerm) for each in found.around):
        return None
    if any(len(number.tokens) != 1 + len(number.units) for number in nodes.numbers(node)):
        return None  # a product, perhaps with a parameter
    uniform = analysis.movement(found.placed, node).uniform
    if uniform is None or not (uniform.x or uniform.y or uniform.yaw):
        return None
    source = Source(analysis.statement_ids[found.placed.index], node.span)
    score, line = score_of(analysis), analysis.played.get(found.placed.index)
    if line:  # others don't play its words
        robots = dict(line.parts)
        score = replace(score, parts={name: part for name, part in score.parts.items() if name in robots})
    played = _performances(score, source, lambda profile: Twist(*in_axes(uniform, profile)))
    first = next(played, None)
    return (node.span.shifted(found.placed.start), node, chain([first], played)) if first else None


def _performances(score: Score, word: Source, moves: Callable[[Profile], Twist]) -> Iterator[_Performance]:
    """Yield a word each time that a robot plays it, as if no sense ever held."""
    for name, part in score.parts.items():
        amounts = moves(part.profile)
        whole = abs(amounts.yaw) or math.hypot(amounts.x, amounts.y)
        start, legs, done = part.start, list[tuple[Twist, float]](), 0.0
        for is_word, pose, moving, seconds in _moments(score, part, word):
            if seconds == math.inf:
                break
            start = start if legs else pose
            if not is_word:
                if done:
                    yield _Performance(name, part.profile, start, legs, amounts)
                legs, done = [], 0.0
                continue
            legs.append((moving, seconds))
            done += abs(moving.yaw if amounts.yaw else math.hypot(moving.x, moving.y)) * seconds
            if done >= whole * (1 - _SAME):
                yield _Performance(name, part.profile, start, legs, amounts)
                legs, done = [], 0.0


def poses_at(score: Score, word: Source) -> dict[str, Pose]:
    """Return where each robot that plays a word begins it first, as if no sense ever held."""
    moments = {name: _moments(score, part, word) for name, part in score.parts.items()}
    first = {name: next((pose for is_word, pose, *_ in each if is_word), None) for name, each in moments.items()}
    return {name: pose for name, pose in first.items() if pose}


def _moments(score: Score, part: Part, word: Source) -> Iterator[tuple[bool, Pose, Twist, float]]:
    """Yield the moments of a part: whether a word plays, the pose before it, the velocity, and the seconds."""
    pose = part.start
    moving_at = cache(partial(twist, profile=part.profile, tempo=score.tempo))  # most moments have few velocities
    for moment in islice(walk(part.movement), MAX_MOMENTS):
        moving, seconds = moving_at(moment.velocity), score.seconds(moment.duration)
        yield word in moment.sources, pose, moving, seconds
        if moment.duration == ENDLESS:
            return
        pose = pose.after(moving, seconds)


def _axis(played: _Performance) -> tuple[int, float]:
    """Return the axis by which a word is measured, as an index into `_WORDS`, and its signed amount: degrees of a turn,
    otherwise meters."""
    mine = played.amounts
    if mine.yaw:
        return 3, math.degrees(mine.yaw)
    return (0, mine.x) if mine.x else (1, mine.y)


def _written(text: str, node: Word, played: _Performance, amount: float, level: Fraction) -> str:
    """Return the word that moves by a signed amount, rounded to a level but never to 0, in place of a text: with a
    measure, if it had one or no word moves so far."""
    axis, _ = _axis(played)
    rounded = round(amount / level) * level or level
    word, far = _WORDS[axis][rounded < 0], abs(rounded)
    number = node.measure if isinstance(node, nodes.MeasuredWord) else None
    if isinstance(node, nodes.Primitive):
        for plain in (word, f"half{word}"):
            if plain in PRIMITIVES and abs(_plain(PRIMITIVES[plain], played.profile, axis) - far) < _SAME:
                return plain
    unit = "m" if far >= 1 else "cm"
    if axis == 3:
        unit = number.units[0].text if number and number.units else "deg"
    rest = text[number.span.end - node.span.start :] if number else text[_word_end(node) - node.span.start :]
    return f"{word} {float(far / UNITS[unit].size):.10g}{unit}{rest}"


def _word_end(node: Word) -> int:
    return (node.primitive if isinstance(node, nodes.MeasuredWord) else node).span.end


def _plain(velocity: Velocity, profile: Profile, axis: int) -> float:
    """Return how far a word without a measure moves along its axis, in meters or degrees."""
    far = abs(in_axes(velocity, profile)[axis])
    return math.degrees(far) if axis == 3 else far


def _least(cost: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function is least, by trying some places and halving around the best one."""
    step = (high - low) / _TRIED
    best = min((low + step * each for each in range(_TRIED + 1)), key=cost)
    for _ in range(_HALVINGS):
        best = min((best - step, best, best + step), key=cost)
        step /= 2
    return min(max(best, low), high)
