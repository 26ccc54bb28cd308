"""Hovers for the lines of the opening: the places and kinds of robots, the floor, and the bar."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import starts_of
from improv_core.program.program import Placed
from improv_core.program.timing import in_seconds, written
from improv_core.score.motion import Pose
from improv_core.score.profiles import MOTIONS, Profile
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import OfKind
from improv_core.text import Span

MAX_PLACES = 12
"""The most robots of a formation whose places are listed."""
TOGETHER = 0.001
"""The distance in meters up to which robots share one place."""


class About(NamedTuple):
    """A description of the text at `span`: a word, its effect, and facts."""

    span: Span
    word: str
    about: str
    facts: tuple[str, ...] = ()


def about_opening(analysis: Analysis, placed: Placed, token: Token) -> About | None:
    """Describe a token of a line of the opening; None for a robot's name, and for a line with an error. Spans count
    from the start of the statement."""
    statement, said, sign = placed.statement, placed.meaning.said, placed.statement.sign
    if not said or not sign or not statement.opening or token in statement.heads:
        return None
    after = Span(sign.start, statement.tokens[-1].end)
    if isinstance(statement.opening, OfKind):
        profile = analysis.config.profiles.get(statement.opening.profile.text)
        return About(statement.opening.profile.span, profile.name, f": {kind(profile)}") if profile else None
    if said.room:
        width, height = said.room
        ends = f"x from {-width / 2:g} to {width / 2:g} m, y from {-height / 2:g} to {height / 2:g} m"
        return About(after, f"room {width:g} {height:g}", ": the floor, with walls around it", (ends,))
    if said.bar:
        beats = "1 beat" if said.bar == 1 else f"{said.bar:,} beats"
        return About(
            after,
            f"bar {said.bar}",
            f": {beats} a bar, {in_seconds(said.bar, analysis.tempo)} at beat {written(analysis.tempo)}",
        )
    if not said.poses:
        return None
    if len(said.robots) == 1:
        robot = said.robots[0]
        about = f": {printable(robot)} starts at {stand_at(said.poses[0])}"
        return About(after, "at", about, tuple(_neighbors(analysis, robot)))
    return About(after, "at", f": {len(said.robots):,} robots start here", tuple(_places(said.robots, said.poses)))


def stand_at(pose: Pose) -> str:
    """Describe a place: `x -1 m, y 0.5 m, facing 90°`."""
    heading = round(math.degrees(pose.heading), 1) + 0.0
    return f"x {_meters(pose.x)} m, y {_meters(pose.y)} m, facing {heading:g}°"


def kind(profile: Profile) -> str:
    """Describe a profile in one line: `step 0.2 m, radius 0.171 m, up to 0.306 m/s; forward, turn`."""
    speed = f", up to {profile.max_linear:g} m/s" if profile.max_linear else ""
    motions = "all motions" if len(profile.motions) == len(MOTIONS) else ", ".join(profile.motions)
    return f"step {profile.step:g} m, radius {profile.radius:g} m{speed}; {motions}"


def _places(robots: tuple[str, ...], poses: tuple[Pose, ...]) -> Iterator[str]:
    shown = list(zip(robots, poses, strict=True))[:MAX_PLACES]
    for robot, pose in shown:
        yield f"{printable(robot)}: {stand_at(pose)}"
    if len(robots) > len(shown):
        yield f"and {len(robots) - len(shown):,} more"


def _neighbors(analysis: Analysis, robot: str) -> Iterator[str]:
    """Name the robots at the same place, or else the nearest one."""
    if robot not in analysis.all_robots:
        return
    starts = starts_of(analysis)
    far = {name: starts[robot].apart(starts[name])[0] for name in analysis.all_robots if name != robot}
    if together := [printable(name) for name, distance in far.items() if distance <= TOGETHER]:
        yield f"here too: {', '.join(together[:MAX_PLACES])}"
    elif far:
        name = min(far, key=far.__getitem__)
        yield f"nearest: {printable(name)}, {_meters(far[name])} m away"


def _meters(length: float) -> str:
    return f"{round(length, 3) + 0.0:g}"
