"""Where robots start because somebody moved them on the page of `improv edit`. No file keeps it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from improv_core.robots.config import Robots, read_robots
from improv_core.robots.edits import form
from improv_core.score.motion import Pose
from improv_core.score.score import Score
from improv_core.stage.commands import Form, PlaceRobots
from improv_core.stage.fields import StartPoseJson


@dataclass(frozen=True, slots=True)
class PlacedRobots:
    """Robots that somebody moved one by one, and before that, into a formation."""

    starts: Mapping[str, Pose] = field(default_factory=dict)
    formation: Form | None = None

    def after(self, asked: PlaceRobots | Form) -> PlacedRobots:
        """With what was asked for last. A formation also takes robots that were moved before."""
        if asked["type"] == "form":
            return PlacedRobots(formation=asked)
        starts = {
            name: Pose(pose["x"], pose["y"], heading=math.radians(pose["heading"]))
            for name, pose in asked["start_poses"].items()
        }
        return replace(self, starts={**self.starts, **starts})

    def robots(self, robots: Robots) -> Robots:
        """The robots of an `improv.toml`, at these starts."""
        if self.formation:
            text = form(robots.text, self.formation["shape"], self.formation["distance"], self.formation["facing"])
            robots = robots if text is None else read_robots(text, robots.path)
        return replace(robots, starts=self.starts)


def starts_of(score: Score) -> dict[str, StartPoseJson]:
    """The start poses of a score in meters and degrees, as pages have them."""
    return {
        name: {"x": part.start.x, "y": part.start.y, "heading": math.degrees(part.start.heading)}
        for name, part in score.parts.items()
    }
