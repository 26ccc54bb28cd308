"""Describe words with measures: `1.5 m forward in 1 beat`."""

from __future__ import annotations

from fractions import Fraction

from improv_core.program.numbers import product
from improv_core.program.timing import written
from improv_core.syntax.nodes import MeasuredWord, Number
from improv_core.syntax.vocabulary import RADIUS

_WAYS = {"strafeleft": "to the left", "straferight": "to the right", "halfleft": "left", "halfright": "right"}


def written_measures(node: MeasuredWord) -> str:
    """Return a word with its measures, as they are usually written: `left 90deg radius 60cm`."""
    measure = [node.measure.text] if node.measure else []
    radius = [RADIUS, node.radius.text] if node.radius else []
    return " ".join([node.word.text, *measure, *radius])


def about_measures(node: MeasuredWord) -> str:
    """Describe the effect of a word with its measures, whatever its robot's profile is."""
    way = _WAYS.get(node.word.text, node.word.text)
    far = _shown(node.measure) if node.measure else "an eighth of a turn" if way != node.word.text else "a quarter turn"
    circle = f", along a circle with a radius of {_shown(node.radius)}" if node.radius else ""
    return f"{far} {way} in 1 beat{circle}"


def _shown(measure: Number) -> str:
    """`1.5 m`, `72°`, or `side*1 m` if arguments decide."""
    unit = measure.units[0].text if measure.units else ""
    value = None if any(measure.parameters) else product(measure.tokens, {})
    number = written(value) if isinstance(value, Fraction) else measure.text.replace(unit, "", 1)
    return f"{number}{'°' if unit in ('deg', '°') else f' {unit}' if unit else ''}"
