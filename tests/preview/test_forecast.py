"""The forecast of a performance for others, from the messages of a real player."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import pytest

from improv_core.preview.forecast import AHEAD, MAX_POSES, Forecast
from improv_core.protocol.messages import When
from improv_core.score.motion import Pose
from tests.player.test_player import Stage, score


class PageOpened(Stage):
    def __init__(self, program: str, *, real: bool = True) -> None:
        super().__init__()
        self.sink.real = real
        self.forecast = Forecast()
        self._heard = 0
        self.load(program)

    def load(self, program: str, when: When = "restart") -> None:
        made, generation = score(program), len(self.told) + 1
        self.forecast.add_score(made, generation)
        self.perform(made, generation, when)

    def see(self, robot: str = "r") -> tuple[float, float, float, str]:
        """Return x, y, and degrees of a robot now, and its movement."""
        for message in self.told[self._heard :]:
            if message["type"] == "transport" or message["type"] == "sensed":
                self.forecast.take(message)
        self._heard = len(self.told)
        self.forecast.compute(self.now)
        current = self.forecast.robot(robot, self.now)
        assert current.pose
        x, y, heading = current.pose.x, current.pose.y, math.degrees(current.pose.heading)
        return round(x, 6), round(y, 6), round(heading, 6), " ".join(current.words)

    def path(self, robot: str = "r") -> list[tuple[float, Pose]]:
        self.see(robot)
        return list(self.forecast.path(robot))


def test_the_forecast_has_a_robots_pose_and_movement() -> None:
    stage = PageOpened("side = forward left\nr $ repeat 4 side\n")
    assert stage.see() == (0, 0, 0, "side forward")
    stage.run(0.5)
    assert stage.see() == (1, 0, 0, "side forward")
    stage.run(1)
    assert stage.see() == (2, 0, 45, "side left")
    stage.ask("speed", factor=2)
    stage.run(0.5)
    assert stage.see() == (2, 1, 90, "side forward")
    stage.ask("seek", beat=4.5)
    assert stage.see() == (1, 2, 180, "side forward")
    stage.run(10)
    assert stage.see() == (0, 0, 360, "")


def test_a_path_reaches_half_a_minute_ahead() -> None:
    stage = PageOpened("beat 120\nr $ repeat (forward forward left)\n")
    stage.run(0.25)
    path = stage.path()
    assert path[0] == (0, Pose(1.0))
    assert path[-1][0] == pytest.approx(AHEAD)
    times = [at for at, _ in path]
    assert times == sorted(times)
    turns = [abs(b.heading - a.heading) for (_, a), (_, b) in itertools.pairwise(path)]
    assert max(turns) <= math.radians(10) + 1e-9
    stage.ask("speed", factor=0.5)
    assert stage.path()[-1][0] == pytest.approx(AHEAD)


@pytest.mark.slow("walks the longest paths")
@pytest.mark.parametrize(
    ("program", "length"),
    [("r $ forward\n", 2), ("r $ rest\n", 2), ("r $ repeat fast 1000 left\n", MAX_POSES)],
)
def test_a_path_has_a_limited_number_of_poses(program: str, length: int) -> None:
    stage = PageOpened(program)
    assert len(stage.path()) == length


def test_there_is_no_path_if_nothing_is_left_to_play() -> None:
    stage = PageOpened("r $ repeat forward\n")
    assert stage.path()
    stage.ask("pause")
    assert stage.path()
    stage.ask("silence", muted=["r"], soloed=[])
    assert stage.path() == []
    stage.ask("silence", muted=[], soloed=["r"])
    assert stage.path()
    stage.ask("stop")
    assert stage.path() == []
    assert stage.forecast.transport
    assert stage.forecast.transport["state"] == "stopped"


def test_a_save_continues_from_where_robots_are() -> None:
    """Real robots don't report where they are: a new part begins at the ideal pose of the one before."""
    stage = PageOpened("r $ repeat forward\nb $ repeat left\n")
    stage.see()
    stage.run(1)
    stage.load("r $ repeat backward\nb $ repeat left\n", "now")
    assert stage.see() == (2, 0, 0, "backward")
    stage.run(0.5)
    assert stage.see() == (1, 0, 0, "backward")
    stage.load("r $ forward\nb $ repeat left\n", "restart")
    assert stage.see() == (0, 0, 0, "forward")


def test_the_forecast_follows_decisions_of_senses() -> None:
    stage = PageOpened("r $ until cue (repeat forward) left\n---\nr $ forward\n", real=False)
    stage.see()
    stage.run(1.5)
    assert stage.see() == (3, 0, 0, "forward")
    stage.ask("cue")
    stage.run(0.25)
    assert stage.see() == (3, 0, 0, "until")
    stage.run(0.75)
    assert stage.see() == (3, 0, 45, "left")
    stage.run(1)
    assert stage.see() == (3, 1, 90, "forward")
    stage.run(10)
    assert stage.see() == (3, 2, 90, "")
    stage.ask("seek", beat=0.5)
    assert stage.see() == (1, 0, 0, "forward")


def test_the_path_is_in_the_frame_of_odometry() -> None:
    """Once that frame is known, and as long as the robot has one."""
    stage = PageOpened("r $ repeat forward\n")
    stage.see()
    at = {"x": 0, "y": 5, "z": 0, "heading": math.pi / 2}
    robot: Any = {"frame": "r/odom", "origin": at}
    forecast = stage.forecast
    forecast.take({"type": "measured", "generation": 1, "robots": {"r": robot}})
    stage.run(1)
    assert (stage.see()[:3], forecast.frame("r").name) == ((2, 0, 0), "improv")
    assert forecast.score
    forecast.score = replace(forecast.score, parts={"r": replace(forecast.score.parts["r"], odom="/r/odom")})
    assert (stage.see()[:3], forecast.frame("r").name) == ((0, 7, 90), "r/odom")
    last = stage.path()[-1][1]
    assert (last.x, last.y) == pytest.approx((0, 67))


def test_nothing_is_known_before_the_first_message() -> None:
    forecast = Forecast()
    forecast.compute(0.0)
    assert (forecast.beat(0.0), forecast.robot("r", 0.0).pose, list(forecast.path("r"))) == (0, None, [])
