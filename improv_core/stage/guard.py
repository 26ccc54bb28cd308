"""Watches whether real robots keep apart while they play, by their measured poses.

It decides nothing, and never reads a clock. Standard library only.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from improv_core.score.following import OLDEST
from improv_core.stage.events import TooNear
from improv_core.stage.nearness import Proximity
from improv_core.stage.run import Run
from improv_core.stage.sinks import RawPose


class Guard:
    """The latest poses of real robots, and what people know about those that aren't guarded."""

    def __init__(self) -> None:
        self._proximity = Proximity()
        self._told: set[str] = set()  # robots that people know are not guarded
        self._lost: set[str] = set()  # those of which no poses come now

    def forget(self) -> None:
        """Name all robots again that aren't guarded, since somebody has restarted everything."""
        self._told, self._lost = set(), set()

    def hear(self, poses: Iterable[RawPose]) -> None:
        """Take measured poses."""
        self._proximity = self._proximity.heard(poses)

    def look(self, run: Run, now: float) -> TooNear | None:
        """The robots that are too near to each other at a time on the clock, if there are any."""
        if (keep_apart := run.score.world.keep_apart) is None:
            return None
        self._proximity, found = self._proximity.looked(run.mode == "playing", _guarded(run), keep_apart, now)
        return TooNear(found) if found else None

    def news(self, run: Run, now: float) -> Iterator[str]:
        """Lines about robots that aren't guarded, each once."""
        if run.score.world.keep_apart is None or run.mode != "playing":
            return
        guarded = _guarded(run)
        if never := run.score.parts.keys() - guarded.keys() - self._told:
            self._told |= never
            who = ", ".join(sorted(never))
            yield f'`keep_apart` doesn\'t guard {who}: that needs poses with `odom_frame = "world"`'
        lost = {robot for robot in guarded if not self._proximity.is_fresh(robot, now)}
        if new := lost - self._lost:
            yield f"`keep_apart` doesn't guard {', '.join(sorted(new))} now: no pose came for {OLDEST} s"
        self._lost = lost


def _guarded(run: Run) -> Mapping[str, float]:
    """The radii of the robots whose poses are in the world that all share."""
    parts = run.score.parts.items()
    return {robot: part.profile.radius for robot, part in parts if part.odom and part.odom_frame == "world"}
