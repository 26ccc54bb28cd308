"""An evaluator of programs with body parts and measures, written from the law of the language alone, and random
programs for it.

It expands a movement into pieces of constant velocity and plays them one after the other. It uses none of our code.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import count
from math import copysign, inf, radians
from typing import NamedTuple

AXES = ("x", "y", "z", "yaw")
WORDS: Mapping[str, tuple[int, float]] = {
    **{word: (0, sign) for word, sign in (("forward", 1), ("backward", -1), ("rest", 0))},
    **{word: (1, sign) for word, sign in (("strafeleft", 1), ("straferight", -1))},
    **{word: (2, sign) for word, sign in (("up", 1), ("down", -1))},
    **{word: (3, sign) for word, sign in (("left", 1), ("right", -1), ("halfleft", 0.5), ("halfright", -0.5))},
}
OWN = 0.25, 0.25, 0.25, radians(92.5)
"""Meters of the base's step, along each axis, and its quarter turn."""
LENGTHS: Mapping[str, float] = {"m": 1, "cm": 0.01, "mm": 0.001}
ANGLES: Mapping[str, float] = {"deg": radians(1), "°": radians(1)}
PHRASES = "go n = forward n*1m\nspin n r = left 360deg/n radius r*50cm\nlift n = up n*2m/3\n"
ARMS = {"l_arm": "r_arm", "r_arm": "l_arm"}
TOML = """
[profiles.p]
step = 0.25
quarter_turn = 92.5
[profiles.p.body.head]
left = { joint = "yaw", degrees = 30 }
up = { joint = "pitch", degrees = -20 }
poses.aside = { left = 40, up = 10 }
[profiles.p.body.l_arm]
mirror = "r_arm"
up = { joint = "l_up", degrees = -45 }
left = { joint = "l_out", degrees = 30 }
forward = { joint = "l_reach", meters = 0.1 }
poses.high = { up = 60, left = 20 }
poses.wide = { left = 50 }
[profiles.p.body.r_arm]
up = { joint = "r_up", degrees = -45 }
left = { joint = "r_out", degrees = 30 }
strafeleft = { joint = "r_turn", degrees = 11 }
poses.wide = { left = -30 }
[profiles.p.body.arms]
parts = ["l_arm", "r_arm"]
[profiles.p.joints]
yaw = { min = -70, max = 80, start = 10 }
l_up = { min = -170, max = 60, start = -15 }
l_out = { min = -90, max = 90, start = 25 }
r_out = { min = -90, max = 90, start = -5 }
[robots.r]
profile = "p"
"""


class Drive(NamedTuple):
    """The joint of a direction, its distance per step, its start, and its limits; poses follow the joint's
    direction."""

    joint: str
    step: float
    start: float = 0.0
    least: float = -inf
    most: float = inf


def _turns(joint: str, step: float, start: float = 0.0, least: float = -inf, most: float = inf) -> Drive:
    return Drive(joint, *map(radians, (step, start, least, most)))


DRIVES: Mapping[str, Mapping[str, Drive]] = {
    "head": {"yaw": _turns("yaw", 30, 10, -70, 80), "z": _turns("pitch", -20)},
    "l_arm": {
        "z": _turns("l_up", -45, -15, -170, 60),
        "yaw": _turns("l_out", 30, 25, -90, 90),
        "x": Drive("l_reach", 0.1),
    },
    "r_arm": {"z": _turns("r_up", -45), "yaw": _turns("r_out", 30, -5, -90, 90), "y": _turns("r_turn", 11)},
}
POSES: Mapping[tuple[str, str], Mapping[str, float]] = {
    ("head", "aside"): {"yaw": radians(40), "z": radians(10)},
    ("l_arm", "high"): {"z": radians(60), "yaw": radians(20)},
    ("l_arm", "wide"): {"yaw": radians(50)},
    ("r_arm", "wide"): {"yaw": radians(-30)},
    ("r_arm", "high"): {"z": radians(60), "yaw": radians(-20)},  # the mirror image
}


@dataclass(frozen=True)
class Pose:
    """A pose that is being reached: the same one in all pieces with its number."""

    number: int
    name: str
    rate: Fraction = Fraction(1)
    mirrored: bool = False


@dataclass(frozen=True)
class Does:
    """The motion of one performer in a piece: along each axis its own steps, then meters or radians, a beat."""

    velocity: tuple[float, ...] = (0.0,) * 8
    poses: tuple[Pose, ...] = ()

    def plus(self, other: Does) -> Does:
        pairs = zip(self.velocity, other.velocity, strict=True)
        return Does(tuple(one + another for one, another in pairs), self.poses + other.poses)

    def times(self, *factors: float) -> Does:
        pairs = zip(self.velocity, factors * 2, strict=True)
        return replace(self, velocity=tuple(each * factor for each, factor in pairs))


class Piece(NamedTuple):
    """A piece of a movement: "" performs all of it, and named body parts perform their own."""

    beats: Fraction
    who: Mapping[str, Does]


Pieces = list[Piece]
_numbers = count()


class Term(NamedTuple):
    """The text of a term, and its pieces, made again each time that it is performed."""

    text: str
    pieces: Callable[[], Pieces]


def _each(pieces: Pieces, change: Callable[[Does], Does]) -> Pieces:
    return [Piece(beats, {name: change(does) for name, does in who.items()}) for beats, who in pieces]


def _together(one: Mapping[str, Does], other: Mapping[str, Does]) -> Mapping[str, Does]:
    return {name: one.get(name, Does()).plus(other.get(name, Does())) for name in {**one, **other}}


def _paced(pieces: Pieces, rate: Fraction) -> Pieces:
    def change(does: Does) -> Does:
        poses = tuple(replace(pose, rate=pose.rate * rate) for pose in does.poses)
        return replace(does.times(*[float(rate)] * 4), poses=poses)

    return [Piece(beats / rate, who) for beats, who in _each(pieces, change)]


def beats_of(pieces: Pieces) -> Fraction:
    return sum((each.beats for each in pieces), Fraction(0))


def _parallel(one: Pieces, other: Pieces) -> Pieces:
    found, waiting = [], (list(one), list(other))
    while all(waiting):
        (mine, *_), (yours, *_) = waiting
        beats = min(mine.beats, yours.beats)
        found.append(Piece(beats, _together(mine.who, yours.who)))
        for voice in waiting:
            left = voice[0].beats - beats
            voice[:1] = [voice[0]._replace(beats=left)] if left else []
    return found


def _reflected(pieces: Pieces) -> Pieces:
    """Reflect pieces across YZ."""

    def mirrored(name: str, does: Does) -> tuple[str, Does]:
        does = does.times(1, -1, 1, -1)
        if name in ARMS:
            return ARMS[name], does
        return name, replace(does, poses=tuple(replace(pose, mirrored=not pose.mirrored) for pose in does.poses))

    return [Piece(beats, dict(mirrored(*each) for each in who.items())) for beats, who in pieces]


def _by(parts: Sequence[str], pieces: Pieces) -> Pieces:
    def performed(who: Mapping[str, Does]) -> Mapping[str, Does]:
        named = {name: does for name, does in who.items() if name}
        return _together(dict.fromkeys(parts, who[""]) if "" in who else {}, named)

    return [Piece(beats, performed(who)) for beats, who in pieces]


def movement(dice: random.Random, depth: int, part: str = "", poses: bool = True) -> Term:
    """Return a random movement."""
    voices = [_series(dice, depth, part, poses) for _ in range(1 if dice.random() < 0.7 else 2)]
    return _parallel_term(voices)


def _parallel_term(voices: Sequence[Term]) -> Term:
    if len(voices) == 1:
        return voices[0]
    one, other = voices
    return Term(f"{one.text} || {other.text}", lambda: _parallel(one.pieces(), other.pieces()))


def _series(dice: random.Random, depth: int, part: str, poses: bool, squeezed: bool = False) -> Term:
    terms = [_term(dice, depth - 1, part, poses) for _ in range(dice.choice([1, 2, 2, 3]))]
    text = " ".join(each.text for each in terms)
    rate = Fraction(len(terms) if squeezed else 1)
    return Term(text, lambda: _paced([piece for each in terms for piece in each.pieces()], rate))


def _term(dice: random.Random, depth: int, part: str, poses: bool) -> Term:
    if depth <= 0 or dice.random() < 0.3:
        return _word(dice, part, poses)
    kind = dice.choice(("()", "[]", "rate", "fit", "repeat", "scale", "backward", "plane", *["YZ"] * 2, *["part"] * 3))
    if kind == "()":
        inner = movement(dice, depth - 1, part, poses)
        return Term(f"({inner.text})", inner.pieces)
    if kind == "[]":
        inner = _parallel_term([_series(dice, depth - 1, part, poses, True) for _ in range(dice.choice([1, 1, 2]))])
        return Term(f"[{inner.text}]", inner.pieces)
    if kind == "part":
        name = dice.choice(["head", "l_arm", "r_arm", "arms"])
        inner = _term(dice, depth - 1, name, poses)
        parts = ["l_arm", "r_arm"] if name == "arms" else [name]
        return Term(f"{name} {inner.text}", lambda: _by(parts, inner.pieces()))
    inner = _term(dice, depth - 1, part, poses and kind in ("rate", "fit", "repeat", "YZ"))
    number = dice.choice([2, 3])
    if kind == "rate":
        word, rate = dice.choice([("fast", Fraction(number)), ("slow", Fraction(1, number))])
        return Term(f"{word} {number} {inner.text}", lambda: _paced(inner.pieces(), rate))
    if kind == "fit":
        return Term(f"fit 3 {inner.text}", lambda: _paced(pieces := inner.pieces(), beats_of(pieces) / 3))
    if kind == "repeat":
        return Term(f"repeat {number} {inner.text}", lambda: [p for _ in range(number) for p in inner.pieces()])
    if kind == "scale":
        return Term(
            f"scale {number} {inner.text}", lambda: _each(inner.pieces(), lambda does: does.times(*[number] * 4))
        )
    if kind == "backward":
        word, sign = dice.choice([("reverse", 1), ("retrograde", -1)])
        return Term(f"{word} {inner.text}", lambda: _each(inner.pieces(), lambda does: does.times(*[sign] * 4))[::-1])
    if kind == "YZ":
        return Term(f"reflect YZ {inner.text}", lambda: _reflected(inner.pieces()))
    plane, signs = dice.choice([("XZ", (-1, 1, 1, 1)), ("frontal", (-1, 1, 1, 1)), ("XY", (1, 1, -1, 1))])
    return Term(f"reflect {plane} {inner.text}", lambda: _each(inner.pieces(), lambda does: does.times(*signs)))


def _word(dice: random.Random, part: str, poses: bool) -> Term:
    if part and poses and dice.random() < 0.5:
        name = dice.choice(["aside", "start"] if part == "head" else ["high", "wide", "start"])
        return Term(f"to {name}", lambda: [Piece(Fraction(1), {"": Does(poses=(Pose(next(_numbers), name),))})])
    if not part and dice.random() < 0.2:
        return _phrase(dice)
    word = dice.choice([*WORDS])
    axis, steps = WORDS[word]
    text, own, measured = word, [0.0] * 4, [0.0] * 4
    units = {} if "half" in word or word == "rest" else _units(part, AXES[axis])
    if units and dice.random() < 0.4:
        measure, value = _measure(dice, units)
        text, measured[axis] = f"{word} {measure}", steps * value
    else:
        own[axis] = steps
    if axis == 3 and not part and dice.random() < 0.3:
        radius, value = _measure(dice, LENGTHS)
        text, measured[0] = f"{text} radius {radius}", value * abs(own[3] * OWN[3] + measured[3])
    return _moves(text, *own, *measured)


def _moves(text: str, *velocity: float) -> Term:
    return Term(text, lambda: [Piece(Fraction(1), {"": Does(velocity)})])


def _phrase(dice: random.Random) -> Term:
    """Return a use of a phrase with numbers that its measures take."""
    number, radius = (dice.choice(["1", "2", "3", "1/2", "5"]) for _ in range(2))
    n, turn = float(Fraction(number)), radians(360) / float(Fraction(number))
    text, x, z, yaw = dice.choice(
        [
            (f"go {number}", n, 0.0, 0.0),
            ("go 0", 0.0, 0.0, 0.0),
            (f"lift {number}", 0.0, n * 2 / 3, 0.0),
            (f"spin {number} {radius}", float(Fraction(radius)) / 2 * turn, 0.0, turn),
        ]
    )
    return _moves(text, *[0.0] * 4, x, 0.0, z, yaw)


def _units(part: str, axis: str) -> Mapping[str, float]:
    """Return the units of measures along an axis, none if no joint of the part takes it."""
    if not part:
        return ANGLES if axis == "yaw" else LENGTHS
    drives = [DRIVES[each][axis] for each in (ARMS if part == "arms" else [part]) if axis in DRIVES[each]]
    return {} if not drives else LENGTHS if drives[0].joint == "l_reach" else ANGLES


def _measure(dice: random.Random, units: Mapping[str, float]) -> tuple[str, float]:
    """Return a product in which one number has a unit, and its value."""
    unit = dice.choice([*units])
    numbers = dice.choices(["1", "2", "3", "1.5", ".5", "40", "7"], k=dice.choice([1, 2, 3]))
    marked, text, value = dice.randrange(len(numbers)), "", units[unit]
    for place, number in enumerate(numbers):
        sign = dice.choice("*/") if place else ""
        text += sign + number + unit * (place == marked)
        value = value / float(number) if sign == "/" else value * float(number)
    return text, value


class Stretch(NamedTuple):
    """A stretch from one beat to another, the velocities of the base and of the joints in it, and the positions of
    these at its end."""

    begin: float
    end: float
    base: Sequence[float]
    velocities: Mapping[str, float]
    positions: Mapping[str, float]


def performed(pieces: Pieces) -> list[Stretch]:
    """Return the motion of the base and the joints, at one beat a second."""
    drives = {drive.joint: drive for part in DRIVES.values() for drive in part.values()}
    positions = {joint: drive.start for joint, drive in drives.items()}
    reaching: dict[tuple[int, str], Mapping[str, float]] = {}
    found, at = [], Fraction(0)
    for beats, who in pieces:
        velocities = dict.fromkeys(positions, 0.0)
        for part, does in who.items():
            for axis, drive in DRIVES.get(part, {}).items():
                steps, measured = does.velocity[AXES.index(axis) :: 4]
                velocities[drive.joint] += steps * drive.step + copysign(measured, measured * drive.step)
            for pose in does.poses if part else ():
                if (pose.number, part) not in reaching:
                    reaching[pose.number, part] = _velocities_to(part, pose, positions)
                for joint, speed in reaching[pose.number, part].items():
                    velocities[joint] += speed
        for joint, speed in velocities.items():
            drive = drives[joint]
            positions[joint] = min(max(positions[joint] + speed * float(beats), drive.least), drive.most)
        base = who.get("", Does()).velocity
        speeds = [steps * own + measured for steps, own, measured in zip(base[:4], OWN, base[4:], strict=True)]
        found.append(Stretch(float(at), float(at + beats), speeds, velocities, dict(positions)))
        at += beats
    return found


def _velocities_to(part: str, pose: Pose, positions: Mapping[str, float]) -> Mapping[str, float]:
    """Return the velocities of a part's joints toward a pose."""
    found = {}
    for axis, drive in DRIVES[part].items():
        if pose.name == "start":
            goal = drive.start
        elif axis in POSES.get((part, pose.name), {}):
            sign = -1 if pose.mirrored and axis in ("y", "yaw") else 1
            goal = sign * POSES[part, pose.name][axis] * (1 if drive.step > 0 else -1)
        else:
            continue
        found[drive.joint] = (goal - positions[drive.joint]) * float(pose.rate)
    return found
