"""An evaluator of measures, made from the text of the law alone: it knows neither the parser nor the compiler.

It draws movements, writes each as text, and computes the velocities that the law gives it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple

from hypothesis import strategies as st

STEP, QUARTER = 0.25, 92.5
"""Meters of a step, and degrees of a quarter turn, of the robot."""
TOML = f"[robots.a]\nprofile = 'own'\n[profiles.own]\nstep = {STEP}\nquarter_turn = {QUARTER}\n"
PHRASES = "go n = forward n*1m\nspin n r = left 360deg/n radius r*50cm\nlift n = up n*2m/3\n"

Vector = tuple[float, float, float, float]
Piece = tuple[Fraction, Vector]


class Drawn(NamedTuple):
    """A movement: its text, and its velocities in m/s and rad/s at one beat a second, each with its beats."""

    text: str
    pieces: Sequence[Piece]


_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "deg": math.radians(1), "°": math.radians(1)}
_AXES = {"forward": 0, "backward": 0, "strafeleft": 1, "straferight": 1, "up": 2, "down": 2, "left": 3, "right": 3}
_BACK = {"backward", "straferight", "down", "right", "halfright"}


def _measure(units: Sequence[str]) -> st.SearchStrategy[tuple[str, float]]:
    """Draw a product in which one number has a unit, and its value."""
    literals = ["1", "2", "3", "1.5", ".5", "40", "7"]

    def made(factors: list[tuple[str, str]], marked: int, unit: str) -> tuple[str, float]:
        marked %= len(factors)
        text, value = "", 1.0
        for place, (sign, number) in enumerate(factors):
            text += (sign if place else "") + number + (unit if place == marked else "")
            value = value / float(number) if place and sign == "/" else value * float(number)
        return text, value * _UNITS[unit]

    factors = st.lists(st.tuples(st.sampled_from("*/"), st.sampled_from(literals)), min_size=1, max_size=3)
    return st.builds(made, factors, st.integers(0, 2), st.sampled_from(units))


LENGTHS, ANGLES = _measure(["m", "cm", "mm"]), _measure(["deg", "°"])


def _word(word: str, measure: tuple[str, float] | None, radius: tuple[str, float] | None) -> Drawn:
    half = word.startswith("half")
    axis = _AXES[word.removeprefix("half")]
    own = math.radians(QUARTER) if axis == 3 else STEP
    value = measure[1] if measure else own / 2 if half else own
    vector = [0.0, 0.0, 0.0, 0.0]
    vector[axis] = -value if word in _BACK else value
    text = f"{word} {measure[0]}" if measure else word
    if radius:
        vector[0] = radius[1] * abs(value)
        text += f" radius {radius[0]}"
    x, y, z, yaw = vector
    return Drawn(text, [(Fraction(1), (x, y, z, yaw))])


_GOING = st.sampled_from([word for word, axis in _AXES.items() if axis < 3])
_SIDES = st.sampled_from(["left", "right"])


def _phrase(name: str, values: Sequence[str]) -> Drawn:
    n = float(Fraction(values[0]))
    vector = (n, 0.0, 0.0, 0.0)
    if name == "spin":
        turn = math.radians(360) / n
        vector = (float(Fraction(values[1])) / 2 * turn, 0.0, 0.0, turn)
    elif name == "lift":
        vector = (0.0, 0.0, n * 2 / 3, 0.0)
    return Drawn(" ".join([name, *values]), [(Fraction(1), vector)])


_SMALL = st.sampled_from(["1", "2", "3", "1/2", "5"])
LEAVES = st.one_of(
    st.builds(_word, _GOING, st.none() | LENGTHS, st.none()),
    st.builds(_word, _SIDES, st.none() | ANGLES, st.none() | LENGTHS),
    st.builds(_word, st.sampled_from(["halfleft", "halfright"]), st.none(), st.none() | LENGTHS),
    st.builds(lambda n: _phrase("go", [n]), _SMALL | st.just("0")),
    st.builds(lambda n, r: _phrase("spin", [n, r]), _SMALL, _SMALL | st.just("0")),
    st.builds(lambda n: _phrase("lift", [n]), _SMALL),
)


def _series(items: Sequence[Drawn]) -> Drawn:
    return Drawn(f"({' '.join(each.text for each in items)})", [piece for each in items for piece in each.pieces])


def _squeezed(items: Sequence[Drawn]) -> Drawn:
    return Drawn(f"[{' '.join(each.text for each in items)}]", _faster(_series(items).pieces, Fraction(len(items))))


def _voices(one: Drawn, other: Drawn) -> Drawn:
    made: list[Piece] = []
    rest = [list(one.pieces), list(other.pieces)]
    while all(rest):
        beats = min(each[0][0] for each in rest)
        x, y, z, yaw = (sum(values) for values in zip(*(each[0][1] for each in rest), strict=True))
        made.append((beats, (x, y, z, yaw)))
        for voice in rest:
            left, vector = voice[0]
            voice[:1] = [(left - beats, vector)] if left > beats else []
    return Drawn(f"({one.text}||{other.text})", made)


def _faster(pieces: Sequence[Piece], rate: Fraction) -> list[Piece]:
    return [(beats / rate, _by(vector, *[float(rate)] * 4)) for beats, vector in pieces]


def _by(vector: Vector, x: float, y: float, z: float, yaw: float) -> Vector:
    return vector[0] * x, vector[1] * y, vector[2] * z, vector[3] * yaw


def _scaled(pieces: Sequence[Piece], *factors: float) -> list[Piece]:
    x, y, z, yaw = factors
    return [(beats, _by(vector, x, y, z, yaw)) for beats, vector in pieces]


def _around(before: str, change: Callable[[Sequence[Piece]], Sequence[Piece]]) -> Callable[[Drawn], Drawn]:
    return lambda inner: Drawn(f"{before} {inner.text}", change(inner.pieces))


_WORDS: Sequence[Callable[[Drawn], Drawn]] = (
    _around("fast 3/2", lambda pieces: _faster(pieces, Fraction(3, 2))),
    _around("slow 2", lambda pieces: _faster(pieces, Fraction(1, 2))),
    _around("scale 3", lambda pieces: _scaled(pieces, 3, 3, 3, 3)),
    _around("repeat 2", lambda pieces: [*pieces, *pieces]),
    _around("reverse", lambda pieces: pieces[::-1]),
    _around("retrograde", lambda pieces: _scaled(pieces[::-1], -1, -1, -1, -1)),
    _around("reflect YZ", lambda pieces: _scaled(pieces, 1, -1, 1, -1)),
    _around("reflect frontal", lambda pieces: _scaled(pieces, -1, 1, 1, 1)),
    _around("fit 3", lambda pieces: _faster(pieces, sum((beats for beats, _ in pieces), Fraction(0)) / 3)),
)


def _larger(inner: st.SearchStrategy[Drawn]) -> st.SearchStrategy[Drawn]:
    several = st.lists(inner, min_size=1, max_size=4)
    return st.one_of(
        several.map(_series),
        several.map(_squeezed),
        st.builds(_voices, inner, inner),
        st.builds(lambda change, each: change(each), st.sampled_from(_WORDS), inner),
    )


MOVEMENTS = st.recursive(LEAVES, _larger, max_leaves=8)
