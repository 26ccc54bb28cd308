"""Collisions for a simulator without a physics library: things that are near each other pass through each other."""

from __future__ import annotations

from collections.abc import Mapping

from improv_core.outputs.simulator.collisions import Disc, Pushed
from improv_core.protocol.drawn import Bump
from improv_core.score.motion import Pose
from improv_core.score.world import World


class Passing:
    """Replaces `Collisions` if pymunk is not available."""

    def __init__(self, world: World) -> None:
        """Ignore the world."""

    def near_obstacle(self, x: float, y: float, reach: float) -> bool:
        return False

    def keep(self, discs: Mapping[str, Disc]) -> None:
        """Push nobody."""

    def push(self, paths: Mapping[str, tuple[Pose, Pose]], start: float, end: float) -> dict[str, Pushed]:
        return {}

    def take_bumps(self) -> list[Bump]:
        return []

    def take_contacts(self) -> tuple[set[str], set[str]]:
        return set(), set()
