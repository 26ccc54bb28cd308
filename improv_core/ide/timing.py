"""How times and distances are written for people."""

from __future__ import annotations

import math
from fractions import Fraction

from improv_core.movement import ENDLESS, Duration, Movement
from improv_core.path import extent
from improv_core.profiles import Profile


def beats(duration: Duration) -> str:
    """`1 beat`, `3.5 beats`, `7/3 beats`, `∞`."""
    if duration == ENDLESS:
        return "∞"
    return f"{number(Fraction(duration))} beat{'' if duration == 1 else 's'}"


def number(value: Fraction) -> str:
    """The shortest exact way to write a number: a decimal where three places will do, else a fraction."""
    if 1000 % value.denominator:
        return str(value)
    return f"{float(value):.3f}".rstrip("0").rstrip(".") if value.denominator > 1 else str(value.numerator)


def seconds(duration: Duration, tempo: Fraction) -> str:
    """`4.0 s`, or longer units where those read better."""
    total = float(duration * 60 / tempo)
    if total < 120:
        return f"{total:.1f} s" if total >= 1 or total == 0 else f"{total:.2f} s"
    if total < 7200:
        return f"{total / 60:.1f} min"
    if total < 172_800:
        return f"{total / 3600:.1f} h"
    return f"{total / 86_400:,.0f} days"


def lasting(movement: Movement, tempo: Fraction) -> str:
    """`16.0 s at beat 30`, `endless at beat 30`."""
    length = "endless" if movement.duration == ENDLESS else seconds(movement.duration, tempo)
    return f"{length} at beat {number(tempo)}"


def timing(movement: Movement, tempo: Fraction) -> str:
    """`8 beats, 16.0 s at beat 30`."""
    return f"{beats(movement.duration)}, {lasting(movement, tempo)}"


def way(movement: Movement, profile: Profile) -> str:
    """How far a movement goes and how much it turns: `8.0 m, turns 360° left`."""
    measured = extent(movement)
    if not measured:
        return "goes on for ever" if movement.duration == ENDLESS else "too long a way to be measured"
    meters = measured.steps * profile.step
    degrees = round(math.degrees(measured.turns * profile.quarter_turn), 1)
    turn = f"turns {abs(degrees):,g}° {'left' if degrees > 0 else 'right'}" if degrees else "no turn"
    return f"{meters:,.1f} m, {turn}"
