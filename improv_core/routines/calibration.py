"""Calibration: two dances to play, and the profile settings that follow from measuring them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from fractions import Fraction
from statistics import fmean, stdev

from improv_core.protocol.robot_messages import MeasuredRobot
from improv_core.robots.limits import excess
from improv_core.score.motion import Pose
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.profiles import Profile

QUARTERS = 8
"""The quarter turns of the turning dance. Two full turns add up the errors, and the robot faces its line again."""
MIN_ROUNDS, MAX_ROUNDS = 3, 8
PRECISION = 0.005
"""The standard error, as a share, at which a setting counts as known: 1 cm in 2 m, half a degree in a quarter turn."""
PATIENCE = 0.3
"""Seconds that may lack poses, at the beginning of a dance and at the end of its final rest."""


@dataclass(frozen=True, slots=True)
class MeasuredSettings:
    """The keys of a profile that calibration sets, in meters, in radians, and as a ratio."""

    commanded_step: float
    commanded_quarter_turn: float
    left_right: float


@dataclass(frozen=True, slots=True)
class Goal:
    """The intended result of the dances: a number of steps straight ahead, and `QUARTERS` quarter turns."""

    steps: int
    step: float
    quarter_turn: float

    @property
    def distance(self) -> float:
        return self.steps * self.step

    @property
    def turn(self) -> float:
        return QUARTERS * self.quarter_turn


@dataclass(frozen=True, slots=True)
class Straight:
    """The result of the straight dance: meters along the robot's path, and radians that it turned left."""

    distance: float
    bend: float


@dataclass(frozen=True, slots=True)
class Round:
    """The measured results of both dances. `turn` is in radians to the left, on the spot."""

    straight: Straight
    turn: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """The settings that follow from some rounds, and the standard error of each; infinite after one round."""

    settings: MeasuredSettings
    error: MeasuredSettings

    @property
    def is_known(self) -> bool:
        """True if the settings are precise enough to need no more rounds."""
        pairs = zip(astuple(self.error), astuple(self.settings), strict=True)
        return all(error / value <= PRECISION for error, value in pairs)


def goal_in(room: float, profile: Profile) -> Goal:
    """The goal with as many steps as fit into this many meters of free floor."""
    return Goal(math.floor(room / room_for(profile) + 1e-9), profile.step, profile.quarter_turn)


def room_for(profile: Profile) -> float:
    """The meters of floor that a step takes: its intended or its commanded length, whichever is longer."""
    return profile.step * max(profile.linear_scale, 1.0)


def settings_of(profile: Profile) -> MeasuredSettings:
    """The current calibration in a profile."""
    step, turn = profile.step * profile.linear_scale, profile.quarter_turn * profile.angular_scale
    return MeasuredSettings(step, turn, profile.left_right)


def with_settings(profile: Profile, settings: MeasuredSettings) -> Profile:
    """Return this profile with these settings."""
    linear, angular = settings.commanded_step / profile.step, settings.commanded_quarter_turn / profile.quarter_turn
    return replace(profile, linear_scale=linear, angular_scale=angular, left_right=settings.left_right)


def straight_dance(robot: str, profile: Profile, goal: Goal, tempo: int) -> str:
    """The program of the straight dance, at this tempo if the robot's limits allow it."""
    return _program(robot, profile, f"repeat {goal.steps} forward", "forward", tempo)


def turning_dance(robot: str, profile: Profile, tempo: int) -> str:
    """The program of the turning dance, at this tempo if the robot's limits allow it."""
    return _program(robot, profile, f"repeat {QUARTERS} left", "left", tempo)


def _program(robot: str, profile: Profile, movement: str, word: str, tempo: int) -> str:
    """The program of a dance. It ends with a rest of at least a second, in which a base slows down and stops."""
    if over := excess(PRIMITIVES[word], profile, Fraction(tempo)):
        tempo = over.tempo or 1
    return f"beat {tempo}\n{robot} $ {movement}{' rest' * math.ceil(tempo / 60)}\n"


def straight_by_tape(ahead: float, aside: float) -> Straight:
    """Compute the result from the robot's final place: meters ahead of its start and to the left of its line.

    Its path is an arc that begins along the line. The angle between chord and tangent is half the arc's.
    """
    return _arc(math.hypot(ahead, aside), 2 * math.atan2(aside, ahead))


def straight_by_poses(start: Pose, end: Pose) -> Straight:
    """Compute the result from the robot's poses before and after the dance."""
    bend = math.remainder(end.heading - start.heading, math.tau)
    return _arc(math.dist((start.x, start.y), (end.x, end.y)), bend)


def _arc(chord: float, bend: float) -> Straight:
    half = abs(bend) / 2
    return Straight(chord * half / math.sin(half) if half > 1e-9 else chord, bend)


def turn_by_poses(start: Pose, end: Pose, goal: Goal) -> float:
    """The radians that a robot turned on the spot, if that is less than half a turn off."""
    return goal.turn + math.remainder(end.heading - start.heading - goal.turn, math.tau)


def are_whole(first: MeasuredRobot, last: MeasuredRobot, seconds: float) -> bool:
    """Return whether poses in a single frame covered a dance of this many seconds, judging by its first and last
    pose."""
    begun, ended = first["performed"] <= PATIENCE, last["performed"] >= seconds - PATIENCE
    return begun and ended and first["aligned"] == last["aligned"]


def doubtful_distance(straight: Straight, told: float) -> str | None:
    """The reason why the measurement of a straight drive of `told` meters can't be right, or None."""
    if not 0.5 * told <= straight.distance <= 1.5 * told:
        return f"{straight.distance:.2f} m can't be right for {told:.2f} m"
    if abs(straight.bend) > math.pi / 2:
        return f"{_degrees(abs(straight.bend))} off a straight line can't be right"
    return None


def doubtful_turn(turn: float, told: float) -> str | None:
    """The reason why the measurement of a turn on the spot, in radians, can't be right, or None."""
    return None if 0.5 * told <= turn <= 1.5 * told else f"{_degrees(turn)} can't be right for {_degrees(told)}"


def calibrate(now: MeasuredSettings, goal: Goal, rounds: Sequence[Round], separation: float) -> Calibration:
    """The settings that take a robot to its goal, from rounds that it played with its settings of `now`.

    `separation` is that of its wheels, in meters, as in `Profile.wheel_separation`.
    """
    each = [_settings(now, goal, played, separation) for played in rounds]
    columns = zip(*map(astuple, each), strict=True)
    few = len(rounds) < 2
    means, errors = zip(
        *((fmean(column), math.inf if few else stdev(column) / math.sqrt(len(column))) for column in columns),
        strict=True,
    )
    return Calibration(MeasuredSettings(*means), MeasuredSettings(*errors))


def _settings(now: MeasuredSettings, goal: Goal, played: Round, separation: float) -> MeasuredSettings:
    """The settings that follow from one round.

    For each meter, a base also turns by `c` because of its wheels, and by the `bend_of(left_right)` that `left_right`
    adds. The latter comes out multiplied by `gain`, as all turns do. So the bend per meter is c + gain * bend_of(now),
    and the new `left_right` makes that 0.
    """
    told = goal.steps * now.commanded_step
    gain = played.turn / (QUARTERS * now.commanded_quarter_turn)
    bend = _bend_of(now.left_right, separation) - played.straight.bend / told / gain
    return MeasuredSettings(
        now.commanded_step * goal.distance / played.straight.distance,
        now.commanded_quarter_turn * goal.turn / played.turn,
        (2 + bend * separation) / (2 - bend * separation),
    )


def _bend_of(left_right: float, separation: float) -> float:
    """The radians to the left that `Twist.balanced` adds to each meter."""
    return 2 / separation * (left_right - 1) / (left_right + 1)


def errors(goal: Goal, rounds: Sequence[Round]) -> str:
    """A robot's average deviations from the goal, in words."""
    distance = fmean(played.straight.distance for played in rounds)
    bend = fmean(played.straight.bend for played in rounds)
    turn = fmean(played.turn for played in rounds)
    side = "left" if bend > 0 else "right"
    return (
        f"{distance:.3f} m instead of {goal.distance:.3f} m, {_degrees(abs(bend))} to the {side};"
        f" {_degrees(turn)} instead of {_degrees(goal.turn)}"
    )


def _degrees(radians: float) -> str:
    return f"{math.degrees(radians):.1f}°"
