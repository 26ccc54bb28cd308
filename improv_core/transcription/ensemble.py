"""Finds what robots do together: in unison, in canon, and in formation. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import dropwhile

from improv_core.robots.formation import Formation, on_circle
from improv_core.score.motion import Pose
from improv_core.transcription.wording import REST, Node, Rounding, is_rest


@dataclass(frozen=True, slots=True)
class SharedLine:
    """Robots and the theme that they perform together. With `apart`, it is a canon after some `rests`: each robot
    begins that many beats after the one before, and all end with the `coda` together."""

    robots: tuple[str, ...]
    theme: tuple[Node, ...]
    apart: int = 0
    rests: int = 0
    coda: tuple[Node, ...] = ()

    @property
    def parts(self) -> list[tuple[Node, ...]]:
        """Parts that are written by themselves."""
        return [each for each in (self.theme, self.coda) if each]


def lines_of(parts: Mapping[str, Sequence[Node]]) -> list[SharedLine]:
    """Return the lines of a program in which each robot performs its part, without rests at its end: it stands then."""
    left = {robot: tuple(dropwhile(is_rest, part[::-1]))[::-1] for robot, part in parts.items()}
    lines = []
    while left:
        line = _canon(left) or _unison(left)
        lines.append(line)
        for robot in line.robots:
            del left[robot]
    return lines


def _unison(parts: Mapping[str, tuple[Node, ...]]) -> SharedLine:
    first = next(iter(parts.values()))
    return SharedLine(tuple(robot for robot, part in parts.items() if part == first), first)


def _rests(part: Sequence[Node]) -> int:
    return next((place for place, each in enumerate(part) if each != REST), len(part))


def _canon(parts: Mapping[str, tuple[Node, ...]]) -> SharedLine | None:
    """Return the canon of the first robot and those that follow it; None if there is none."""
    first, theme = next(iter(parts.items()))
    lead = _rests(theme)
    bodies = {robot: (_rests(part) - lead, part[_rests(part) :]) for robot, part in parts.items() if part}
    followers = sorted(
        (robot for robot, (late, body) in bodies.items() if late > 0 and body[:1] == theme[lead : lead + 1]),
        key=lambda robot: bodies[robot][0],
    )
    for count in range(len(followers), 0, -1):
        robots = (first, *followers[:count])
        apart = bodies[robots[1]][0]
        if any(bodies[robot][0] != place * apart for place, robot in enumerate(robots)):
            continue
        found = _theme([bodies[robot][1] for robot in robots], apart)
        if found is not None:
            return SharedLine(robots, found[0], apart, lead, found[1])
    return None


def _theme(bodies: Sequence[tuple[Node, ...]], apart: int) -> tuple[tuple[Node, ...], tuple[Node, ...]] | None:
    """Return what the voices of a canon share, and what all perform after it."""
    last = len(bodies) - 1
    for size in range(min(map(len, bodies)), 0, -1):
        body, tail = bodies[-1][:size], bodies[-1][size:]
        if all(
            each[:size] == body and each[size:] == ((REST,) * (apart * (last - place)) + tail if tail else ())
            for place, each in enumerate(bodies)
        ):
            return body, tail
    return None


def formation_of(starts: Mapping[str, Pose], rounding: Rounding) -> tuple[Sequence[str], str] | None:
    """Return the robots in the order of a formation, and its words after `at`; None if they stand in none."""
    if len(starts) < 3:
        return None
    x, y = (math.fsum(values) / len(starts) for values in zip(*((p.x, p.y) for p in starts.values()), strict=True))
    for center in dict.fromkeys((round(x, digits) + 0.0, round(y, digits) + 0.0) for digits in (1, 3)):
        moved = {robot: Pose(p.x - center[0], p.y - center[1], p.z, p.heading) for robot, p in starts.items()}
        around = "" if center == (0, 0) else f" around {center[0]:g} {center[1]:g}"
        for words, poses in _shapes(moved):
            if order := _order(moved, poses, rounding):
                return order, words + around
    return None


def _shapes(starts: Mapping[str, Pose]) -> list[tuple[str, list[Pose]]]:
    """Return the formations that these robots may stand in, around the origin: their words, and their poses."""
    count = len(starts)
    radius = math.fsum(math.hypot(pose.x, pose.y) for pose in starts.values()) / count
    nearest = min(math.dist((a.x, a.y), (b.x, b.y)) for a in starts.values() for b in starts.values() if a is not b)
    found = []
    for digits in (1, 2, 3, 4):
        for facing in ("in", "out"):
            words = f"circle {round(radius, digits):g}" + (" facing out" if facing == "out" else "")
            found.append((words, on_circle(round(radius, digits), count, facing)))
        for shape in ("line", "grid"):
            distance = round(nearest, digits)
            found.append((f"{shape} {distance:g}", Formation(shape, distance, "in").poses(count)))
    return found


def _order(starts: Mapping[str, Pose], poses: Sequence[Pose], rounding: Rounding) -> list[str] | None:
    """Return the robots in the order of the poses at which they stand; None if one stands elsewhere."""
    left, order = dict(starts), []
    for pose in poses:
        robot = min(left, key=lambda robot: left[robot].apart(pose)[0])
        far, turned = left.pop(robot).apart(pose)
        if far > rounding.meters or turned > rounding.radians:
            return None
        order.append(robot)
    return order
