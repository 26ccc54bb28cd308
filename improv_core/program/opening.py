"""The opening of a dance: the places and kinds of its robots, the floor, and the bar."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic, likely, unknown
from improv_core.diagnostics import replace as replaced
from improv_core.program.naming import is_reserved, robots_named
from improv_core.program.numbers import product
from improv_core.robots.config import Robots
from improv_core.robots.formation import Formation, heading, on_circle
from improv_core.score.motion import Pose
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import AtPoint, BarLength, FloorSize, InFormation, Number, OfKind, Statement
from improv_core.syntax.vocabulary import UNITS
from improv_core.syntax.word import above_zero
from improv_core.text import Span

OPENING = frozenset({"AT", "IS", "ROOM", "BAR_LENGTH", "SCENE"})
"""The signs of the lines of the opening. A line that begins a scene is one because it may name the scene."""
FARTHEST = 1_000
"""The farthest place from the origin and the largest size, in meters: as in `improv.toml`."""
LONGEST_BAR = 1_000


@dataclass(frozen=True, slots=True)
class Said:
    """The content of one line of the opening, without invalid values. `poses` are in the order of its robots."""

    robots: tuple[str, ...] = ()
    poses: tuple[Pose, ...] = ()
    profile: str | None = None
    room: tuple[float, float] | None = None
    bar: int | None = None


@dataclass(frozen=True, slots=True)
class Opening:
    """The beginning of a program: the `places` of robots with a line `at`, the beats of a bar, and the size of the
    floor.

    `config` are the robots of `improv.toml` with the kinds and the floor that the program gives them. The other robots
    start in the same places as if no line placed one.
    """

    config: Robots
    places: Mapping[str, Pose] = field(default_factory=dict)
    bar: int | None = None
    room: tuple[float, float] | None = None


def open_with(config: Robots, lines: Iterable[Said]) -> Opening:
    """Return the opening of these lines with the robots of an `improv.toml`. The first line about each thing counts."""
    places: dict[str, Pose] = {}
    kinds: dict[str, str] = {}
    bar, room = None, None
    for said in lines:
        for robot, pose in zip(said.robots, said.poses, strict=False):
            places.setdefault(robot, pose)
        if said.profile and said.profile in config.profiles:
            kinds = dict.fromkeys(said.robots, said.profile) | kinds
        bar, room = bar or said.bar, room or said.room
    if kinds:
        config = config.of_kinds({robot: config.profiles[profile] for robot, profile in kinds.items()})
    if room:
        config = replace(config, world=replace(config.world, size=room))
    return Opening(config, places, bar, room)


def said_by(statement: Statement, diagnostics: list[Diagnostic]) -> Said:
    """Return the content of a line of the opening. Report wrong names and numbers."""
    if statement.kind == "SCENE":
        for head in statement.heads:
            is_reserved(head, diagnostics)
        return Said()
    robots, reader = robots_named(statement.heads, diagnostics), _Numbers(diagnostics)
    match statement.opening:
        case AtPoint(x, y, facing):
            point = reader.point(x, y)
            turned = reader.signed(facing, "this angle") if facing else Fraction(0)
            if point is None or turned is None:
                return Said(robots)
            return Said(robots, (Pose(*point, heading=heading(turned)),))
        case InFormation():
            return Said(robots, reader.formation(statement.opening, len(robots)))
        case OfKind(profile):
            return Said(robots, profile=profile.text)
        case FloorSize():
            along_x, along_y = (
                reader.size(each, "this length") for each in (statement.opening.width, statement.opening.height)
            )
            return Said(room=(along_x, along_y) if along_x and along_y else None)
        case BarLength(beats):
            return Said(bar=reader.bar(beats))
    return Said(robots)


def check_kind(statement: Statement, said: Said, robots: Robots) -> Iterator[Diagnostic]:
    """Report problems of the profile that a line gives its robots. Spans count from the start of the statement."""
    if not isinstance(statement.opening, OfKind):
        return
    profile = statement.opening.profile
    if profile.text not in robots.profiles:
        near = likely(profile.text, robots.profiles)
        otherwise = f"write `turtlebot4`, `quadrotor`, or so, or add `[profiles.{profile.text}]` to improv.toml"
        yield unknown("unknown-profile", profile.span, f"`{profile.text}` is not a profile", near, otherwise)
        return
    heads = [head for head in statement.heads if head.text in said.robots]
    for head in heads:
        robot = robots.robots.get(head.text)
        if not robot or not robot.has_profile:
            continue
        own = robot.profile.name
        whole = Span(0, len(statement.text))
        if own != profile.text:
            message = f"`{head.text}` is a `{own}` in improv.toml, which counts: change it there"
            fixes = replaced(f"Change to {own}", profile.span, own) if len(heads) == 1 else ()
            yield Diagnostic("other-profile", head.span, message, fixes)
        else:
            message = f"`{head.text}` is already a `{own}` in improv.toml: remove it here"
            only = len(statement.heads) == 1
            gone = whole if only else without(statement, head.span)
            fixes = replaced("Remove it", gone, "", safe=True)
            yield Diagnostic("no-effect", whole if only else head.span, message, fixes)


class Repeated(NamedTuple):
    """A repetition of the statement `first` in a line of the opening: its sign, and the name that it is about, if any.

    The spans are those of the names or, without one, of the signs.
    """

    sign: str
    name: str
    span: Span
    first: int
    first_span: Span


def repeated(lines: Iterable[tuple[int, Statement]]) -> Mapping[int, Sequence[Repeated]]:
    """Return the repetitions in the lines of an opening, by their indices."""
    known: dict[tuple[str, str], tuple[int, Span]] = {}
    found: dict[int, list[Repeated]] = {}
    for index, statement in lines:
        sign = statement.sign
        if not sign or (statement.opening is None and sign.type != "SCENE"):
            continue
        for token in statement.heads if sign.type in ("AT", "IS", "SCENE") else (sign,):
            name = "" if token is sign else token.text
            first, span = known.setdefault((sign.type, name), (index, token.span))
            if (first, span) != (index, token.span):
                found.setdefault(index, []).append(Repeated(sign.type, name, token.span, first, span))
    return found


def without(statement: Statement, head: Span) -> Span:
    """Return the span of a robot's name and the space after it, for removal."""
    rest = statement.text[head.end :]
    return Span(head.start, head.end + len(rest) - len(rest.lstrip()))


@dataclass(frozen=True, slots=True)
class _Numbers:
    """Reads the numbers of a line; returns None for a wrong one and reports it."""

    diagnostics: list[Diagnostic]

    def formation(self, node: InFormation, robots: int) -> tuple[Pose, ...]:
        shape = node.shape.text
        size = self.size(node.size, "this radius" if shape == "circle" else "this distance")
        middle = self.point(*node.around) if node.around else (0.0, 0.0)
        if size is None or middle is None:
            return ()
        facing = node.facing.text if node.facing else "in"
        is_circle = shape == "circle"
        poses = on_circle(size, robots, facing) if is_circle else Formation(shape, size, facing).poses(robots)
        x, y = middle
        return tuple([Pose(x + pose.x, y + pose.y, heading=pose.heading) for pose in poses])

    def point(self, x: Number, y: Number) -> tuple[float, float] | None:
        found = [self.signed(number, "this place", FARTHEST) for number in (x, y)]
        return (float(found[0]), float(found[1])) if found[0] is not None and found[1] is not None else None

    def signed(self, number: Number, what: str, most: int | None = None) -> Fraction | None:
        first, *rest = number.tokens
        sign = -1 if first.text[0] == "-" else 1
        value = _value([first._replace(text=first.text.lstrip("+-")), *rest])
        if most is not None and isinstance(value, Fraction) and value > most:
            value = f"in meters, from {-most:,} to {most:,}"
        return sign * value if (value := self._right(number, what, value)) is not None else None

    def size(self, number: Number, what: str) -> float | None:
        value = _value(number.tokens)
        if isinstance(value, Fraction):
            value = above_zero(value) or (f"in meters, up to {FARTHEST:,}" if value > FARTHEST else value)
        return float(value) if (value := self._right(number, what, value)) is not None else None

    def bar(self, number: Number) -> int | None:
        value = product(number.tokens, {})
        if isinstance(value, Fraction) and (value.denominator > 1 or not 1 <= value <= LONGEST_BAR):
            value = f"as a whole number of beats, from 1 to {LONGEST_BAR:,}"
        return int(value) if (value := self._right(number, "this", value)) is not None else None

    def _right(self, number: Number, what: str, value: Fraction | str | None) -> Fraction | None:
        if isinstance(value, str):
            self.diagnostics.append(Diagnostic("bad-number", number.span, f"write {what} {value}"))
            return None
        return value


def _value(tokens: Sequence[Token]) -> Fraction | str | None:
    """Return the value of a number in meters or degrees, like `product`."""
    value = product(tokens, {})
    sizes = [UNITS[token.text].size for token in tokens if token.type == "UNIT"]
    return value * sizes[0] if sizes and isinstance(value, Fraction) else value
