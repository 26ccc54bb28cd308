"""Components of velocities in units of the floor, exact until velocities leave the compiler. Standard library only."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias, TypeVar

Coefficient: TypeAlias = Any
"""A coefficient is exact (a Fraction or an int) in a velocity, and a float in a bound of velocities."""
Value = TypeVar("Value", float, Fraction)
DEGREE = math.radians(1)


class Measure(NamedTuple):
    """A component of a velocity, per beat, that a program measures: its `steps` (quarter turns, for yaw), `meters`,
    and `degrees`, and lengths of arcs: meters of radius times quarter turns (`turning`), and times degrees (`arcs`).

    Without anything measured, a component is a plain number, so most code never meets this class.
    """

    steps: Coefficient = 0
    meters: Coefficient = 0
    degrees: Coefficient = 0
    turning: Coefficient = 0
    arcs: Coefficient = 0

    def __add__(self, other: Any) -> Any:
        if not isinstance(other, Measure):
            return self._replace(steps=self.steps + other)
        return _simplest(*(one + each for one, each in zip(self, other, strict=True)))

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __mul__(self, factor: Coefficient) -> Any:
        return _simplest(*(each * factor for each in self))

    def __neg__(self) -> Any:
        return self * -1

    def si(self, step: Value, turn: Value, degree: Value) -> Value:
        """Return the value in meters or radians, given that of a step, and a quarter turn and a degree in radians."""
        angles = (self.degrees + self.arcs) * degree + self.turning * turn
        value: Value = self.steps * step + self.meters + angles
        return value


Component: TypeAlias = Fraction | int | Measure
"""A component of a velocity, per beat."""
Bound: TypeAlias = float | Measure
"""The largest absolute value of a component."""


def _simplest(*coefficients: Coefficient) -> Any:
    steps, *measured = coefficients
    return Measure(steps, *measured) if any(measured) else steps


def in_si(component: Component | float, step: Value, turn: Value, degree: Value) -> Value:
    """Return a component, or its bound, in meters or radians, like `Measure.si`."""
    if isinstance(component, Measure):
        return component.si(step, turn, degree)
    value: Any = component
    own: Value = value * step
    return own


def bound_of(component: Component) -> Bound:
    """Return the bound of a component that keeps its value."""
    if isinstance(component, Measure):
        return Measure(*(abs(float(each)) for each in component))
    return abs(float(component))


def larger(one: Bound, other: Bound) -> Bound:
    """Return a bound of all that either bound holds."""
    if not (isinstance(one, Measure) or isinstance(other, Measure)):
        return max(one, other)
    pairs = zip(_whole(one), _whole(other), strict=True)
    return Measure(*(max(pair) for pair in pairs))


def largest(component: Component | float) -> Coefficient:
    return max(component) if isinstance(component, Measure) else component


def units_in(component: Component | float) -> list[str]:
    """Return the fields of `Measure` besides `steps` that are not 0 in a component or a bound."""
    measured = component if isinstance(component, Measure) else Measure()
    return [name for name in Measure._fields[1:] if getattr(measured, name)]


def _whole(bound: Bound) -> Measure:
    return bound if isinstance(bound, Measure) else Measure(bound)
