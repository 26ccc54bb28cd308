"""The poses of robots at a beat that playback jumps to. Standard library only."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress

from improv_core.score.budget import Budget, TooLongError
from improv_core.score.joints import moved_parts
from improv_core.score.motion import Pose
from improv_core.score.movement import Exact
from improv_core.score.path import Paths
from improv_core.score.performer import MAX_SKIPPED, performer_at
from improv_core.score.score import Part, Score

MAX_VISITED = 10_000
"""The most parts of movements to visit for the poses of all robots. That takes 0.1 s, or a little longer."""


class TooFarError(Exception):
    """Raised if it takes too long to compute what `robot` does at a beat."""

    def __init__(self, robot: str) -> None:
        super().__init__(robot)
        self.robot = robot


def known_poses(parts: Collection[Part], beat: Exact, paths: Paths) -> dict[str, Pose]:
    """Return the ideal poses of robots at a beat, if no sense is true until then, unless that takes too long."""
    poses = {}
    for part in parts:
        with suppress(TooLongError):
            poses[part.robot] = paths.pose(part, beat, Budget(MAX_VISITED // len(parts)))
    return poses


def arrive(score: Score, beat: Exact, paths: Paths) -> Mapping[str, Pose]:
    """Return the ideal poses of all robots at a beat, if no sense is true until then.

    Raises TooFarError if it takes too long to compute one of them, or what a robot plays there.
    """
    visits, changes = Budget(MAX_VISITED), Budget(MAX_SKIPPED)
    scene, _ = score.scene_at(beat)
    poses = {}
    for robot, part in score.parts.items():
        begins, performed, left = score.begins(robot, scene), part.of_scene(scene), changes.left
        try:
            if performed.open and begins < beat:
                performer_at(performed, begins, beat, changes)
                changes.spend((left - changes.left) * len(moved_parts(part)))  # which perform the same
            poses[robot] = paths.pose(part, beat, visits)
        except TooLongError as error:
            raise TooFarError(robot) from error
    return poses
