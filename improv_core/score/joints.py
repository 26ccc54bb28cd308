"""From beats to joints: the speeds and positions of a robot's joints. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from improv_core.score.algebra import Parallel
from improv_core.score.body import Body, BodyPart, Drive, Joint
from improv_core.score.budget import Budget
from improv_core.score.measured import DEGREE, Component, Measure
from improv_core.score.movement import STILL, Duration, Movement, Velocity
from improv_core.score.path import Outcomes, PlayedPart
from improv_core.score.projection import Reach, project
from improv_core.score.score import Part
from improv_core.score.smoothing import smoothed
from improv_core.score.traversal import outer_first
from improv_core.score.walk import Moment, walk

REACHED = 1e-9
"""Radians or meters to a limit at which a joint counts as being there: times are rounded."""

DEEPEST = 50
"""The deepest nesting of voices, of which only one moves a body part, that is followed without performing them."""


@lru_cache(maxsize=1_000)  # the same few, again and again, when joints must not be late
def _per_second(component: Component, drive: Drive, tempo: Fraction) -> float:
    return _driven(component * (tempo / 60), drive)


def _driven(component: Component, drive: Drive) -> float:
    """Return a component of a velocity in radians or meters of its joint. Measures go in the direction's own sense."""
    if not isinstance(component, Measure):
        return float(component) * drive.per_step
    measured = component.si(0.0, 0.0, DEGREE)
    return float(component.steps) * drive.per_step + (measured if drive.per_step > 0 else -measured)


class JointMotion(NamedTuple):
    """The position of a joint, and its velocity from then on: radians or meters, and per second."""

    position: float
    velocity: float

    def after(self, seconds: float, joint: Joint) -> float:
        """Return its position later. It stops at its limits; a joint beyond a limit doesn't jump back."""
        later = self.position + self.velocity * seconds
        if self.velocity > 0 and joint.max is not None:
            return min(later, max(self.position, joint.max))
        if self.velocity < 0 and joint.min is not None:
            return max(later, min(self.position, joint.min))
        return later


@dataclass(slots=True)
class Limb:
    """One body part of one robot as it moves. `positions` are those of its joints, in radians or meters."""

    part: BodyPart
    body: Body
    tempo: Fraction
    positions: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        joints = [self.body.joint[drive.joint] for drive in self.part.drives]
        self.positions = {joint.name: joint.within(joint.start) for joint in joints}

    def steps(self, direction: str) -> float:
        """Return the steps of a direction's joint from its zero."""
        drive = self.part.drive(direction)
        return self.positions[drive.joint] / drive.per_step if drive else 0.0

    def velocities(self, velocity: Velocity) -> Mapping[str, float]:
        """Return the speeds that a velocity in steps per beat asks of its joints, in rad/s or m/s."""
        return {
            drive.joint: _per_second(component, drive, self.tempo)
            if (component := getattr(velocity, drive.direction))
            else 0.0
            for drive in self.part.drives
        }

    def move(self, velocities: Mapping[str, float], beats: Fraction | int) -> None:
        """Move the joints for some beats. Each stops at its limits, and continues from there."""
        self.turn(velocities, float(beats * 60 / self.tempo))

    def turn(self, velocities: Mapping[str, float], seconds: float) -> None:
        for name, velocity in velocities.items():
            self.positions[name] = JointMotion(self.positions[name], velocity).after(seconds, self.body.joint[name])

    def possible(self, velocities: Mapping[str, float]) -> dict[str, float]:
        """Return the speeds that its joints can have from here: not beyond their limits."""
        return {
            name: velocity if self._room(name, velocity) > REACHED else 0.0 for name, velocity in velocities.items()
        }

    def seconds_to_limit(self, velocities: Mapping[str, float]) -> float:
        """Return the seconds until the first of them reaches a limit; infinite if none does."""
        moving = [(name, velocity) for name, velocity in velocities.items() if velocity]
        return min((self._room(name, velocity) / abs(velocity) for name, velocity in moving), default=math.inf)

    def _room(self, name: str, velocity: float) -> float:
        """Return the distance that a joint can move in the direction of a velocity."""
        joint, position = self.body.joint[name], self.positions[name]
        limit = joint.max if velocity > 0 else joint.min
        return math.inf if limit is None else abs(limit - position)

    def performs(self, movement: Movement) -> Movement:
        """Return its part of a movement. Before each of its moments, `positions` must be those that it begins with."""
        performed = project(movement, self.part.name, self.body, self)
        is_smooth = any(self.body.joint[drive.joint].smooth for drive in self.part.drives)
        return smoothed(performed, self._fits) if is_smooth else performed

    def _fits(self, velocity: Velocity) -> bool:
        limits = ((speed, self.body.joint[name].max_velocity) for name, speed in self.velocities(velocity).items())
        return all(limit is None or abs(speed) <= limit for speed, limit in limits)


def limbs_of(part: Part, tempo: Fraction) -> list[Limb]:
    """Return the body parts that move in a robot's part, with their positions at its beginning."""
    body = part.profile.body
    return [Limb(body.part[name], body, tempo) for name in moved_parts(part)] if body else []


def moved_parts(part: Part) -> Sequence[str]:
    """Return the names of the body parts that move in a robot's part."""
    asked = part.movement.body_words.asked.union(*(scene.body_words.asked for scene in part.scenes))
    return part.profile.body.moved_by(asked) if part.profile.body else ()


class JointMoment(NamedTuple):
    """A moment of a body part, the speeds that it asks of its joints, and their positions when it begins."""

    moment: Moment
    velocities: Mapping[str, float]
    begin: Mapping[str, float]


def joint_moments(movement: Movement, limb: Limb, *, merge: bool = True) -> Iterator[JointMoment]:
    """Yield the moments of a body part in a movement, as if no sense ever held. Moves the limb along."""
    for moment in walk(limb.performs(movement), merge=merge):
        velocities, begin = limb.velocities(moment.velocity), dict(limb.positions)
        limb.move(velocities, moment.duration)
        yield JointMoment(moment, velocities, begin)


class DisturbedError(Exception):
    """Raised if two voices move a body part, one of them to a pose: that has to be performed to be known."""


class _Turned(NamedTuple):
    """The movement of a joint from `x`: to `share * x + added`, but not beyond `least` and `most`."""

    share: float
    added: float
    least: float
    most: float

    def of(self, position: float) -> float:
        from_it = self.share * position if self.share else 0.0  # 0 times infinity is no number
        return min(max(from_it + self.added, self.least), self.most)

    def then(self, other: _Turned) -> _Turned:
        added = other.share * self.added + other.added
        return _Turned(self.share * other.share, added, other.of(self.least), other.of(self.most))


@dataclass(frozen=True, slots=True)
class _AllTurned:
    """The effects of a movement on joints. Joints that are not named stay."""

    joints: Mapping[str, _Turned]

    def then(self, other: _AllTurned) -> _AllTurned:
        if not other.joints:
            return self
        turned = dict(self.joints)
        for name, each in other.joints.items():
            turned[name] = turned[name].then(each) if name in turned else each
        return _AllTurned(turned)


class JointOutcomes(Outcomes[_AllTurned]):
    """The effects of movements on the joints of a body part, computed without performing them."""

    def __init__(self, part: BodyPart, body: Body) -> None:
        super().__init__(_AllTurned({}), self._turned)
        self._part, self._joints = part, body.joint

    def positions(
        self, begin: Mapping[str, float], movement: Movement, beats: Duration, budget: Budget
    ) -> dict[str, float]:
        """Return the positions of joints after the first beats of a movement, as the body part performs it.

        The movement has to live as long as this. Raises TooLongError or DisturbedError.
        """
        turned = self.until(movement, beats, budget).joints
        return {name: turned[name].of(at) if name in turned else at for name, at in begin.items()}

    def walked(self, played: PlayedPart, until: Duration) -> _AllTurned:
        movement = played.movement
        if isinstance(movement, Reach):
            return self._reached(movement, float(until))
        if isinstance(movement, Parallel) and movement.uniform is None and not played.backward:
            voices = enumerate(movement.items)
            moving = [(place, voice) for place, voice in voices if voice.duration and voice.uniform != STILL]
            if len(moving) == 1 and movement.bounds.depth < DEEPEST:  # the others only end it
                ((place, voice),) = moving
                dice = played.dice.inside(place) if played.dice and voice.dice else None
                return self.first_beats(PlayedPart(voice, played.gain, False, dice), until)
            if len(moving) == 1 or any(_has_pose(voice) for _, voice in moving):
                raise DisturbedError
        return super().walked(played, until)

    def _turned(self, velocity: Velocity, beats: float) -> _AllTurned:
        moved = ((drive, each) for drive in self._part.drives if (each := getattr(velocity, drive.direction)))
        return _AllTurned(
            {
                drive.joint: _Turned(1.0, _driven(each, drive) * beats, *self._range(drive.joint))
                for drive, each in moved
            }
        )

    def _reached(self, pose: Reach, share: float) -> _AllTurned:
        turned = {}
        for direction in pose.moved:
            if drive := self._part.drive(direction):
                goal = float(getattr(pose.goal, direction)) * drive.per_step
                turned[drive.joint] = _Turned(1 - share, share * goal, *self._range(drive.joint))
        return _AllTurned(turned)

    def _range(self, name: str) -> tuple[float, float]:
        joint = self._joints[name]
        return -math.inf if joint.min is None else joint.min, math.inf if joint.max is None else joint.max


def _has_pose(movement: Movement) -> bool:
    return any(isinstance(each, Reach) for each in outer_first(movement, lambda part: part.parts))
