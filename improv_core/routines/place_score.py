"""Scores with which robots drive to their places: slowly, corrected by their poses, and with all rules for stopping.

Lengths are in meters, angles in radians, times in seconds. Pure functions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from improv_core.routines.place_plan import DrivePath, Point
from improv_core.score.algebra import hold, series, stand
from improv_core.score.faults import FaultRules
from improv_core.score.following import refusal
from improv_core.score.motion import Pose
from improv_core.score.movement import Movement, Velocity, near
from improv_core.score.profiles import Profile, slow_speeds
from improv_core.score.score import Part, Score

LEG = 0.5
"""Meters that a robot drives before its pose is read again, if nothing pulls it back to its path meanwhile."""
BACKWARD = 0.3
"""Meters. To a point behind it within this distance, a robot drives backward."""
LOOK = 1.0
"""Seconds for which robots stand to find out their poses."""
TEMPO = Fraction(60)
"""Makes a beat last a second."""
RULES = FaultRules({"off_path": "stop", "jumped": "stop", "stuck": "stop", "gone": "stop"}, distance=0.15)
"""While robots drive, any fault stops all of them, because people needn't watch them closely."""


ANYWHERE = FaultRules(distance=1e6, angle=math.pi)
"""While robots only stand to find out their poses, they may be anywhere."""


def looking(score: Score) -> Score:
    """A score in which all robots stand for a moment, so that their poses become known."""
    return _placing(score, {robot: part.start for robot, part in score.parts.items()}, {}, LOOK, ANYWHERE)


def driving(score: Score, poses: Mapping[str, Pose], paths: Mapping[str, DrivePath]) -> Score:
    """A score in which robots drive their paths from where they are, and all others stand."""
    movements = {
        robot: series([*_movements(score.parts[robot].profile, poses[robot], path)]) for robot, path in paths.items()
    }
    return _placing(score, poses, movements, max(float(each.duration) for each in movements.values()), RULES)


def undrivable(part: Part) -> str | None:
    """The reason why a robot can't drive to its place, and what to do; None if it can."""
    if not part.odom or part.odom_frame != "world":
        return 'its poses are not in the world: add `odom`, and `odom_frame = "world"`'
    if not part.profile.drives_anywhere:
        return "it can't turn on the spot and drive forward: move it by hand"
    return None


def _placing(
    score: Score, poses: Mapping[str, Pose], movements: Mapping[str, Movement], seconds: float, rules: FaultRules
) -> Score:
    rest = stand(near(seconds))
    parts = {
        robot: replace(
            part,
            scenes=(movements.get(robot, rest),),
            start=poses[robot],
            reset=None,
            senses={},
            editions=(),
            follow=refusal(part.profile) is None,
        )
        for robot, part in score.parts.items()
    }
    safety = replace(score.safety, faults=rules, sight=True)
    return Score(TEMPO, parts, world=score.world, safety=safety, publish=score.publish)


def _movements(profile: Profile, pose: Pose, path: DrivePath) -> Iterator[Movement]:
    """Yield movements that turn toward each point and drive to it, and then turn to the heading. Lengths here are in
    meters and seconds; movements are in steps and quarter turns."""
    speed, turning = slow_speeds(profile)
    linear, angular = speed / profile.step, turning / profile.quarter_turn
    points = _shortened(pose, path.points, math.inf if refusal(profile) is None else LEG)
    x, y, heading = pose.x, pose.y, pose.heading
    for to_x, to_y in points:
        far, toward = math.hypot(to_x - x, to_y - y), math.atan2(to_y - y, to_x - x)
        turn = math.remainder(toward - heading, math.tau)
        back = far <= BACKWARD and abs(turn) > math.pi / 2
        if back:
            turn = math.remainder(turn + math.pi, math.tau)
        yield from _moved("yaw", turn / profile.quarter_turn, angular)
        yield from _moved("x", (-far if back else far) / profile.step, linear)
        x, y, heading = to_x, to_y, heading + turn
    if path.heading is not None and points == [*path.points]:
        yield from _moved("yaw", math.remainder(path.heading - heading, math.tau) / profile.quarter_turn, angular)


def _moved(direction: str, amount: float, speed: float) -> Iterator[Movement]:
    """A movement of this many steps or quarter turns at a speed; none for 0."""
    seconds = near(abs(amount) / speed)
    if seconds:
        yield hold(Velocity(**{direction: Fraction(amount).limit_denominator(10**9) / seconds}), seconds)


def _shortened(pose: Pose, points: Sequence[Point], longest: float) -> list[Point]:
    """The beginning of a path, at most this long."""
    at, left, found = (pose.x, pose.y), longest, list[Point]()
    for point in points:
        if (far := math.dist(at, point)) > left:
            share = left / far
            return [*found, (at[0] + share * (point[0] - at[0]), at[1] + share * (point[1] - at[1]))]
        found.append(point)
        at, left = point, left - far
    return found
