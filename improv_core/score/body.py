"""Bodies: the parts of a robot besides its base, the joints that move them, and poses. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

from improv_core.score.json_types import Long
from improv_core.score.movement import Asked

Interface = Literal["trajectory", "position", "velocity"]
Home = Literal["wait", "move"]
"""The behavior at beat 0 if joints of real robots aren't at their starts: it waits until somebody has brought them
there, or they move there first."""
ROOT = -1
"""The carrier of the first joints of a skeleton."""
MAX_BONES = 1_000
Vector = Annotated[Sequence[float], Long(3, 3)]
JointKind = Literal["turns", "slides", "stays"]
START = "start"
"""The pose that every body part has: all its joints at their starts."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint: its limits, its highest speed and acceleration, and its start, in radians, or in meters if it `slides`.
    None is no limit.

    The real joint is `offset` further than it should be, and its commands are corrected by that. If it is `smooth`, the
    movements of its body part begin and end gently.
    """

    name: str
    min: float | None = None
    max: float | None = None
    max_velocity: float | None = None
    start: float = 0.0
    slides: bool = False
    offset: float = 0.0
    max_acceleration: float | None = None
    smooth: bool = False

    def within(self, position: float) -> float:
        """Return the nearest position within its limits."""
        if self.max is not None and position > self.max:
            return self.max
        return self.min if self.min is not None and position < self.min else position

    def shown(self, position: float) -> str:
        """Return a position as people read it: `119.5°`, or `0.25 m`."""
        value = round(position if self.slides else math.degrees(position), 2) + 0.0  # never -0
        return f"{value:,.2f}".rstrip("0").rstrip(".") + (" m" if self.slides else "°")


@dataclass(frozen=True, slots=True)
class Drive:
    """The joint that a direction (a component of the velocity) moves, and its radians or meters per step."""

    direction: str
    joint: str
    per_step: float


@dataclass(frozen=True, slots=True)
class BodyPose:
    """A pose of a body part: the target of each of its named directions, in steps from a joint's zero."""

    name: str
    steps: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class BodyPart:
    """A body part: the joints of its directions, its poses, and the part on the other side, if there is one."""

    name: str
    drives: Sequence[Drive]
    mirror: str | None = None
    poses: Sequence[BodyPose] = ()

    def drive(self, direction: str) -> Drive | None:
        """Return the joint that a direction moves, if it moves one."""
        return next((each for each in self.drives if each.direction == direction), None)

    def pose(self, name: str) -> BodyPose | None:
        """Return a pose of this part. Its start isn't among them."""
        return next((each for each in self.poses if each.name == name), None)

    def has_pose(self, name: str) -> bool:
        return name == START or self.pose(name) is not None


@dataclass(frozen=True, slots=True)
class BodyGroup:
    """A word for several body parts at once."""

    name: str
    parts: Sequence[str]


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller of some joints of a real robot: its interface, and its topic if that isn't the usual one.

    Joints that no direction moves stay where they are.
    """

    name: str
    joints: Sequence[str]
    interface: Interface = "trajectory"
    topic: str | None = None


@dataclass(frozen=True, slots=True)
class Bone:
    """A joint as it is drawn, after the one that carries it: `carrier` is its number in the skeleton.

    `place` (meters) and `turn` (roll, pitch, and yaw in radians, about fixed axes) are its pose in the frame of its
    carrier, and `axis` is its axis of turning or sliding, of length 1. Its position is `rest` unless another one is
    known, in radians or meters; one that `follows` another joint is at `ratio` times its position, plus `shift`.
    """

    joint: str
    carrier: int
    place: Vector
    turn: Vector
    axis: Vector
    way: JointKind
    rest: float = 0.0
    follows: str | None = None
    ratio: float = 1.0
    shift: float = 0.0


@dataclass(frozen=True)
class Body:
    """All that a robot has besides its base. A real one publishes the positions of its joints on `joint_states`. `urdf`
    is the path of a file, and `skeleton` the joints in it that carry one another."""

    parts: Sequence[BodyPart] = ()
    groups: Sequence[BodyGroup] = ()
    joints: Sequence[Joint] = ()
    controllers: Sequence[Controller] = ()
    joint_states: str | None = None
    home: Home = "wait"
    urdf: str | None = None
    skeleton: Sequence[Bone] = ()

    def __hash__(self) -> int:
        return hash(self._names)  # profiles are keys, and there are few

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return (*self.words, *self.joint)

    @cached_property
    def part(self) -> Mapping[str, BodyPart]:
        return {each.name: each for each in self.parts}

    @cached_property
    def joint(self) -> Mapping[str, Joint]:
        return {each.name: each for each in self.joints}

    @cached_property
    def words(self) -> Mapping[str, Sequence[str]]:
        """The body parts that each word for a part or a group names."""
        return {each.name: (each.name,) for each in self.parts} | {each.name: each.parts for each in self.groups}

    def performers(self, word: str, mirrored: bool) -> Sequence[str]:
        """Return the body parts that a word names; none if this body has no such word."""
        named = self.words.get(word, ())
        return [self.part[each].mirror or each for each in named] if mirrored else named

    def moved_by(self, asked: Iterable[Asked]) -> Sequence[str]:
        """Return the parts that perform these words, in the order of the body."""
        found = {part for each in asked for part in self.performers(each.part, each.mirrored)}
        return [each.name for each in self.parts if each.name in found]

    @cached_property
    def pose_names(self) -> frozenset[str]:
        return frozenset(pose.name for part in self.parts for pose in part.poses)


def is_whole(body: Body) -> bool:
    """Return whether a body has all that its parts, groups, and bones mention. Controllers may have more joints."""
    drives = [drive for part in body.parts for drive in part.drives]
    mentioned = {name for group in body.groups for name in group.parts}
    mentioned |= {part.mirror for part in body.parts if part.mirror}
    is_known = mentioned <= body.part.keys() and {drive.joint for drive in drives} <= body.joint.keys()
    return is_known and all(drive.per_step for drive in drives) and _is_tree(body.skeleton)


def _is_tree(bones: Sequence[Bone]) -> bool:
    """Return whether bones make up a skeleton: each comes after its carrier, and they aren't too many."""
    return len(bones) <= MAX_BONES and all(ROOT <= bone.carrier < number for number, bone in enumerate(bones))
