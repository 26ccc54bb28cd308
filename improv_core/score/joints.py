"""From beats to joints: how fast and how far the joints of a robot move. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from improv_core.score.body import Body, BodyPart, Joint
from improv_core.score.movement import Movement, Velocity
from improv_core.score.projection import project
from improv_core.score.score import Part
from improv_core.score.walk import Moment, walk

REACHED = 1e-9
"""Radians or meters to a limit at which a joint counts as being there: times are rounded."""


@lru_cache(maxsize=1_000)  # the same few, again and again, when joints must not be late
def _per_second(steps: Fraction | int, tempo: Fraction) -> float:
    return float(steps * tempo / 60)


class JointMotion(NamedTuple):
    """Where a joint is, and how fast it moves from then on: radians or meters, and per second."""

    position: float
    velocity: float

    def after(self, seconds: float, joint: Joint) -> float:
        """Where it is later. It stops at its limits."""
        return joint.within(self.position + self.velocity * seconds)


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
        """How many steps the joint of a direction is from its zero."""
        drive = self.part.drive(direction)
        return self.positions[drive.joint] / drive.per_step if drive else 0.0

    def velocities(self, velocity: Velocity) -> Mapping[str, float]:
        """How fast a velocity in steps per beat asks its joints to move, in rad/s or m/s."""
        return {
            drive.joint: self._speed(getattr(velocity, drive.direction), drive.per_step) for drive in self.part.drives
        }

    def _speed(self, steps: Fraction | int, per_step: float) -> float:
        return _per_second(steps, self.tempo) * per_step if steps else 0.0

    def move(self, velocities: Mapping[str, float], beats: Fraction | int) -> None:
        """Move the joints for some beats. Each stops at its limits, and continues from there."""
        seconds = float(beats * 60 / self.tempo)
        for name, velocity in velocities.items():
            if velocity:
                self.positions[name] = self.body.joint[name].within(self.positions[name] + velocity * seconds)

    def turn(self, velocities: Mapping[str, float], seconds: float) -> None:
        """Move the joints for some seconds."""
        for name, velocity in velocities.items():
            self.positions[name] = JointMotion(self.positions[name], velocity).after(seconds, self.body.joint[name])

    def possible(self, velocities: Mapping[str, float]) -> dict[str, float]:
        """How fast they can move from where they stand: not beyond their limits."""
        return {
            name: velocity if self._room(name, velocity) > REACHED else 0.0 for name, velocity in velocities.items()
        }

    def seconds_to_limit(self, velocities: Mapping[str, float]) -> float:
        """After how many seconds the first of them reaches a limit; infinite if none does."""
        moving = [(name, velocity) for name, velocity in velocities.items() if velocity]
        return min((self._room(name, velocity) / abs(velocity) for name, velocity in moving), default=math.inf)

    def _room(self, name: str, velocity: float) -> float:
        """How far a joint can move in the direction of a velocity."""
        joint, position = self.body.joint[name], self.positions[name]
        limit = joint.max if velocity > 0 else joint.min
        return math.inf if limit is None else abs(limit - position)

    def performs(self, movement: Movement) -> Movement:
        """What it performs of a movement. Before each of its moments, `positions` must be those that it begins with."""
        return project(movement, self.part.name, self.body, self)


def limbs_of(part: Part, tempo: Fraction) -> list[Limb]:
    """The body parts that move in a robot's part, where they stand at its beginning."""
    body = part.profile.body
    return [Limb(body.part[name], body, tempo) for name in moved_parts(part)] if body else []


def moved_parts(part: Part) -> Sequence[str]:
    """The names of the body parts that move in a robot's part."""
    asked = part.movement.body_words.asked.union(*(scene.body_words.asked for scene in part.scenes))
    return part.profile.body.moved_by(asked) if part.profile.body else ()


class JointMoment(NamedTuple):
    """A moment of a body part, how fast its joints are asked to move, and where they stand when it begins."""

    moment: Moment
    velocities: Mapping[str, float]
    begin: Mapping[str, float]


def joint_moments(movement: Movement, limb: Limb, *, merge: bool = True) -> Iterator[JointMoment]:
    """The moments of a body part in a movement that no sense decides, or as if none ever held. Moves the limb along."""
    for moment in walk(limb.performs(movement), merge=merge):
        velocities, begin = limb.velocities(moment.velocity), dict(limb.positions)
        limb.move(velocities, moment.duration)
        yield JointMoment(moment, velocities, begin)
