"""Draws the movements of robots' joints: a small chart for each joint, with its limits. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from html import escape
from itertools import islice

from improv_core.score.body import Joint
from improv_core.score.joints import JointMoment, joint_moments, limbs_of
from improv_core.score.score import Score

MIN_WIDTH = 316.0
"""The least width in pixels at which charts can be read: two beside each other."""
_WIDE, _HIGH = 150.0, 48.0
"""Pixels: the least width of a chart, and the height of its curve."""
_GAP, _TITLE = 16.0, 16.0
_QUIET, _HELD = "#808080", "#e03131"


@dataclass(slots=True)
class Curve:
    """The positions of a joint: its `points` are beats and positions in radians or meters, with straight lines between
    them. `held` are the stretches in which it should move beyond a limit: the first beat, the last, and the
    position."""

    robot: str
    joint: Joint
    points: list[tuple[float, float]] = field(default_factory=list)
    held: list[tuple[float, float, float]] = field(default_factory=list)

    def follow(self, moment: JointMoment, beats: float, end: float) -> None:
        """Add its movement in a moment, at this many `beats` a second. Nothing is drawn after beat `end`."""
        begin, velocity = moment.begin[self.joint.name], moment.velocities[self.joint.name]
        start = float(moment.moment.start)
        long = min(float(moment.moment.duration), end - start)
        until = self.joint.within(begin + velocity * long / beats)
        moves = (until - begin) / velocity * beats if velocity else long
        self.points += [(start, begin), (start + moves, until), (start + long, until)]
        if velocity and moves < long - _SAME:
            self.held.append((start + moves, start + long, until))


_SAME = 1e-6  # beats


def curves(score: Score, beats: float, most_moments: int) -> list[Curve]:
    """Return the joints that move up to a beat, in the order of robots and their bodies. Senses decide nothing here."""
    per_second = float(score.tempo / Fraction(60))
    found = []
    for name, part in score.parts.items():
        for limb in limbs_of(part, score.tempo):
            own = {drive.joint: Curve(name, limb.body.joint[drive.joint]) for drive in limb.part.drives}
            moved: set[str] = set()
            for moment in islice(joint_moments(part.movement, limb), most_moments):
                if moment.moment.start >= beats:
                    break
                moved |= {joint for joint, velocity in moment.velocities.items() if velocity}
                for curve in own.values():
                    curve.follow(moment, per_second, beats)
            found += [curve for joint, curve in own.items() if joint in moved]
    return found


def charts(
    drawn: Sequence[Curve], colors: Mapping[str, str], beats: float, left: float, top: float, width: float
) -> tuple[list[str], float]:
    """Return the charts of curves, in as many columns as there is room for, and their height. Lengths are in pixels."""
    columns = max(int((width + _GAP) // (_WIDE + _GAP)), 1)
    wide = (width + _GAP) / columns - _GAP
    shapes = []
    for place, curve in enumerate(drawn):
        row, column = divmod(place, columns)
        x, y = left + column * (wide + _GAP), top + row * (_HIGH + _TITLE + _GAP)
        shapes.append(
            f'<g transform="translate({x:.1f} {y:.1f})">{_chart(curve, colors[curve.robot], beats, wide)}</g>'
        )
    return shapes, math.ceil(len(drawn) / columns) * (_HIGH + _TITLE + _GAP)


def _chart(curve: Curve, color: str, beats: float, wide: float) -> str:
    joint = curve.joint
    positions = [position for _, position in curve.points]
    limits = [each for each in (joint.min, joint.max) if each is not None]
    least, most = min([*positions, *limits]), max([*positions, *limits])
    scale = _HIGH / (most - least or 1.0)

    def place(beat: float, position: float) -> str:
        return f"{beat / beats * wide:.1f} {_TITLE + (most - position) * scale:.1f}"

    named = f'<text y="{_TITLE - 5:g}" fill="{color}">{escape(f"{curve.robot} {joint.name}")}</text>'
    labels = "".join(
        f'<text x="{wide:.1f}" y="{_TITLE + (most - position) * scale + below:.1f}" fill="{_QUIET}" font-size="9"'
        f' text-anchor="end">{joint.shown(position)}</text>'
        for position, below in ((most, 9), (least, -2))
    )
    lines = "".join(f"M{place(0.0, limit)}L{place(beats, limit)}" for limit in limits)
    edges = f'<path d="{lines}" stroke="{_QUIET}" stroke-dasharray="3 3"/>' if lines else ""
    start = f'<path d="M{place(0.0, joint.start)}L{place(beats, joint.start)}" stroke="{_QUIET}" stroke-opacity="0.4"/>'
    line = "L".join(dict.fromkeys(place(beat, position) for beat, position in curve.points))
    path = f'<path d="M{line}" fill="none" stroke="{color}" stroke-width="2" stroke-linejoin="round"/>'
    held = "".join(f"M{place(since, position)}L{place(until, position)}" for since, until, position in curve.held)
    marked = f'<path d="{held}" stroke="{_HELD}" stroke-width="4"/>' if held else ""
    return named + edges + start + marked + path + labels
