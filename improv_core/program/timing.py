"""Write times and distances for people."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import islice

from improv_core.robots.limits import top_speed
from improv_core.score.movement import ENDLESS, FINEST, Duration, Exact, Lengths, Movement, bits, exact
from improv_core.score.path import MAX_MEASURED_THROWS, displacement, extent
from improv_core.score.profiles import Profile
from improv_core.score.reactions import reactions

LONGEST_WRITTEN = 4096
"""The most bits of a number that is written in full."""


def in_beats(length: Duration | Lengths) -> str:
    """`1 beat`, `3.5 beats`, `∞`; if senses decide: `2 to 5 beats`, `at most 8 beats`, `4 beats or more`."""
    if isinstance(length, Lengths):
        return _ranged(length, in_beats) or "any number of beats"
    if length == ENDLESS:
        return "∞"
    return f"{written(Fraction(length))} beat{'' if length == 1 else 's'}"


def _ranged(length: Lengths, write: Callable[[Duration], str]) -> str:
    """`2 to 5 beats`; empty if everything is possible."""
    shortest, longest = length.shortest, length.longest
    if shortest == longest:
        return write(longest)
    if longest == ENDLESS:
        return f"{write(shortest)} or more" if shortest else ""
    if not shortest:
        return f"at most {write(longest)}"
    return f"{write(shortest).split()[0]} to {write(longest)}"


def written(value: Fraction) -> str:
    """Write a number exactly: as a decimal if three places are enough, otherwise as a fraction."""
    if 1000 % value.denominator:
        return str(brief(value))
    return f"{float(value):.3f}".rstrip("0").rstrip(".") if value.denominator > 1 else str(value.numerator)


def brief(number: Exact) -> Exact:
    """Return a number short enough to write: itself, or the nearest with a denominator up to `FINEST`. The statements
    of one robot may add up to fractions of any length, and Python writes integers of at most 4,300 digits."""
    return number if bits(number) <= LONGEST_WRITTEN else exact(Fraction(number).limit_denominator(FINEST))


def decimal(value: float, digits: int = 2) -> str:
    """Write a number with up to `digits` digits after the point, and a comma between thousands."""
    return f"{value:,.{digits}f}".rstrip("0").rstrip(".")


def moment(passed: float) -> str:
    """Write the moment after this many beats, counted from 1 as people count: `beat 1.79` is 0.79 beats after the
    beginning."""
    return f"beat {decimal(passed + 1)}"


def end_after(passed: float) -> str:
    """Write the end of something that lasts this many beats: `the end of beat 8`."""
    return f"the end of beat {decimal(passed)}" if passed == int(passed) else moment(passed)


def in_seconds(length: Duration | Lengths, tempo: Fraction) -> str:
    """`4.0 s`, or a longer unit if that reads better; `endless`; if senses decide: `2.0 to 5.0 s`."""
    if isinstance(length, Lengths):
        return _ranged(length, lambda each: in_seconds(each, tempo)) or "any time"
    if length == ENDLESS:
        return "endless"
    duration = length
    total = float(duration * 60 / tempo)
    if total < 120:
        return f"{total:.1f} s" if total >= 1 or total == 0 else f"{total:.2f} s"
    if total < 7200:
        return f"{total / 60:.1f} min"
    if total < 172_800:
        return f"{total / 3600:.1f} h"
    return f"{total / 86_400:,.0f} days"


def lasting(length: Lengths, tempo: Fraction) -> str:
    """`16.0 s at beat 30`, `endless at beat 30`."""
    return f"{in_seconds(length, tempo)} at beat {written(tempo)}"


def timing(length: Lengths, tempo: Fraction) -> str:
    """`8 beats, 16.0 s at beat 30`."""
    if not length.shortest and length.longest == ENDLESS:
        return in_beats(length)
    return f"{in_beats(length)}, {lasting(length, tempo)}"


MAX_CONDITIONS = 3
"""The most words of senses that are listed."""


def deciding(movement: Movement) -> str:
    """Name the words that decide an open movement's length: `until near and pause bump decide`; empty if it is
    closed."""
    words = dict.fromkeys(str(each) for each in islice(reactions(movement), MAX_MOMENTS))
    shown = [f"`{word}`" for word in list(words)[:MAX_CONDITIONS]]
    if len(words) > MAX_CONDITIONS:
        shown.append("others")
    return f"{' and '.join(shown)} decide{'s' if len(shown) == 1 else ''}" if shown else ""


MAX_MOMENTS = 1_000
"""The most moments of parallel voices that are measured: more would take too long."""


def path_length(movement: Movement, profile: Profile) -> str:
    """Describe the distance and the turn of a movement: `8.0 m, turns 360° left`."""
    measured = extent(movement, profile)
    if not measured:
        return "continues forever" if movement.duration == ENDLESS else "too long to measure"
    degrees = round(math.degrees(measured.turn), 1)
    turn = f"turns {abs(degrees):,g}° {'left' if degrees > 0 else 'right'}" if degrees else "no turn"
    return f"{measured.length:,.1f} m, {turn}"


def ends(movement: Movement, profile: Profile) -> str:
    """Describe the end of a movement: `ends 2.0 m ahead, 1.0 m left, facing 90° left`; empty if it is unknown."""
    if isinstance(movement.duration, float):  # endless
        return ""
    pose = displacement(movement, movement.duration, profile, MAX_MEASURED_THROWS)
    if pose is None:
        return ""
    sides = (("ahead", "behind", pose.x), ("left", "right", pose.y), ("up", "down", pose.z))
    parts = [f"{abs(far):,.1f} m {one if far > 0 else other}" for one, other, far in sides if abs(far) >= 0.05]
    degrees = round(math.degrees(math.remainder(pose.heading, math.tau)), 1)
    facing = f"facing {abs(degrees):g}° {'left' if degrees > 0 else 'right'}" if degrees else ""
    if not parts:
        return f"ends where it began{facing and ', ' + facing}"
    return f"ends {', '.join([*parts, facing] if facing else parts)}"


def fastest(movement: Movement, profile: Profile, tempo: Fraction) -> str:
    """Describe the top speeds and the robot's limits: `top speed 0.2 of 0.22 m/s, 1.57 rad/s`; empty if unknown."""
    found = top_speed(movement, profile, tempo, MAX_MOMENTS)
    if found is None:
        return ""
    speeds = ((found.linear, profile.max_linear, "m/s"), (found.angular, profile.max_angular, "rad/s"))
    parts = [f"{value:.3g}{'' if limit is None else f' of {limit:g}'} {unit}" for value, limit, unit in speeds if value]
    return f"top speed {', '.join(parts)}" if parts else "stands still"


def times_as_fast(rate: Fraction) -> str:
    """`twice as fast`, `half as fast`, `3/2 times as fast`."""
    words = {2: "twice", Fraction(1, 2): "half"}
    return f"{words.get(rate) or f'{written(rate)} times'} as fast"
