"""Skeletons: joints of a robot that carry one another, so that it can be drawn. Standard library only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from improv_core.score.fits import Long

BASE = -1
"""The carrier of the first joints of a skeleton."""
MOST_BONES = 1_000
Vector = Annotated[Sequence[float], Long(3, 3)]
JointKind = Literal["turns", "slides", "stays"]


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


def is_tree(bones: Sequence[Bone]) -> bool:
    """Return whether bones make up a skeleton: each comes after its carrier, and they aren't too many."""
    return len(bones) <= MOST_BONES and all(BASE <= bone.carrier < number for number, bone in enumerate(bones))
