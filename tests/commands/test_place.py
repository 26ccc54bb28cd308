"""`improv place`: its refusals, and the drives of robots until they are in their places.

Here robots end where scores take them, or nearly; the benchmark `placing` drives simulated bases.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from improv_core.commands import place
from improv_core.commands.exit_codes import FAILED, INTERRUPTED, PROBLEMS, CommandError
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.fields import to_pose_json
from improv_core.robots.config import read_robots
from improv_core.safety.interlocks import pose_of
from improv_core.score.motion import Pose
from improv_core.score.path import pose_at
from improv_core.score.score import Part, Score
from tests.commands.command_line import run

TOML = """
[ros]
odom_frame = "world"
[world]
margin = 0.1
"""
ROBOT = """
[robots.{0}]
profile = "turtlebot4"
odom = "pose"
start = {{ x = {1}, y = 0, heading = 0 }}
"""
Move = Callable[[Part, Pose], Pose]
"""The real end pose of a robot after a part, from its real start pose."""


def exactly(part: Part, pose: Pose) -> Pose:
    found = pose_at(part, part.movement.duration)  # type: ignore[arg-type]
    assert found
    return found if any(part.movement.bounds.peak[:4]) else pose


def nearly(part: Part, pose: Pose) -> Pose:
    """Drive and turn a tenth too little."""
    ideal = exactly(part, pose)
    turned = math.remainder(ideal.heading - pose.heading, math.tau)
    x, y = (before + 0.9 * (after - before) for before, after in ((pose.x, ideal.x), (pose.y, ideal.y)))
    return Pose(x, y, heading=pose.heading + 0.9 * turned)


def never(part: Part, pose: Pose) -> Pose:
    return pose


def score(*places: float) -> Score:
    """Make the score of robots a, b, … with places along the x axis."""
    names = "abcd"[: len(places)]
    toml = TOML + "".join(map(ROBOT.format, names, places))
    return score_of(analyze(f"{' '.join(names)} $ forward", read_robots(toml)))


WAITS = {"unseen": [pose_of("a")], "near": ["a", "b"]}
"""Reasons for which robots wait that stand in the middle of a drive."""


class Robots:
    """Real robots, and the performance that moves them."""

    def __init__(self, poses: Sequence[Pose], move: Move = exactly, ends: str = "ended", frames: str = "") -> None:
        self.poses = dict(zip("abcd", poses, strict=False))
        self.said: list[str] = []
        self.played: list[Score] = []
        self.results = SimpleNamespace(measured={}, state="stopped" if ends == "stopped" else "ended")
        self.stops = SimpleNamespace(count=0)
        self.finished, self.broken = asyncio.Event(), asyncio.Event()
        self.screen = SimpleNamespace(say=self.said.append, complain=self.said.append)
        self.playback = SimpleNamespace(play=self._play, state=SimpleNamespace(waits_for=()))
        self.has_page = False
        self._move, self._ends, self._frames = move, ends, frames or "w" * len(poses)

    async def _play(self, asked: Any) -> int:
        self.played.append(asked.score)
        self.stops.count = int(self._ends == "stop" and len(self.played) > 1)
        for frame, (robot, part) in zip(self._frames, asked.score.parts.items(), strict=False):
            self.poses[robot] = self._move(part, self.poses[robot])
            told = {"frame": frame, "pose": to_pose_json(self.poses[robot])}
            self.results.measured[robot] = told, told
        if self._ends in WAITS:
            self.playback.state.waits_for = WAITS[self._ends]
        else:
            self.finished.set()
        return len(self.played)


def drive(robots: Robots, dance: Score, answer: str = "y", *, yes: bool = False) -> int:
    """Hold the whole conversation and return the exit code."""

    async def hold() -> int:
        return await place._Placing(robots, dance, "dance.improv").drive(yes=yes)  # type: ignore[arg-type]

    async def answers(self: Any, question: str) -> str:
        self.say(question)
        return answer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("improv_core.commands.answers.TypedAnswers.to", answers)
        for limit in ("MEASURED_AT_REST", "PATIENCE", "LOOK_PERIOD"):
            patch.setattr(place, limit, 0.0001)
        return asyncio.run(hold())


QUESTION = "They drive there now. Is the floor clear, and a stop at hand? [y/N]"


def test_robots_are_driven_to_their_places() -> None:
    robots = Robots([Pose(0, 1), Pose(4, 2, heading=1)])
    assert drive(robots, score(0, 3)) == 0
    assert robots.said == [
        "a is 1.00 m and 0° from its place",
        "b is 2.24 m and 57° from its place",
        QUESTION,
        "a, b drive",
        "all robots are in their places, within 0.00 m and 0.0°",
    ]
    assert all(each.safety.sight for each in robots.played)


def test_robots_that_slip_try_again() -> None:
    robots = Robots([Pose(0, 1), Pose(3)], nearly)
    assert drive(robots, score(0, 3), yes=True) == 0
    assert robots.said[:2] == ["a is 1.00 m and 0° from its place", "a drives"]
    assert robots.said.count("a drives") > 1
    assert QUESTION not in robots.said


def test_robots_that_get_nowhere_are_named_in_the_end() -> None:
    robots = Robots([Pose(0, 1), Pose(3)], never)
    assert drive(robots, score(0, 3)) == PROBLEMS
    assert robots.said.count("a drives") == place.TRIES + 4  # it would need four drives without a correction
    assert robots.said[-2:] == ["a is 1.00 m and 0° from its place", "not in place: a"]


def test_a_robot_in_the_way_is_named() -> None:
    dance = score(0, 1.32)
    robots = Robots([Pose(-2), Pose(1.32, 0)])
    robots.poses["b"] = Pose(0.1, 0)
    stuck = lambda part, pose: pose if part.robot == "b" else exactly(part, pose)  # noqa: E731
    robots._move = stuck
    assert drive(robots, dance) == PROBLEMS
    assert "a can't get to its place, because b is in its way: move one of them by hand" in robots.said


def test_robots_in_their_places_stay_there() -> None:
    robots = Robots([Pose(0.01), Pose(3)])
    assert drive(robots, score(0, 3)) == 0
    assert robots.said == ["all robots are in their places, within 0.01 m and 0.0°"]
    assert len(robots.played) == 1


@pytest.mark.parametrize("answer", ["", "n", "what"])
def test_nobody_drives_unless_a_person_says_so(answer: str) -> None:
    robots = Robots([Pose(0, 1), Pose(3)])
    assert drive(robots, score(0, 3), answer) == PROBLEMS
    assert robots.said[-1] == "no robot was moved"
    assert robots.poses["a"] == Pose(0, 1)


AGAIN = "then place robots again"


@pytest.mark.parametrize(
    ("ends", "code", "played", "said"),
    [
        ("stop", INTERRUPTED, 2, ["a drives"]),
        ("stopped", FAILED, 1, []),
        ("unseen", FAILED, 1, [f"improv: no pose came for 0.0001 s: start the node that publishes them, {AGAIN}"]),
        ("near", FAILED, 1, [f"improv: make room by hand, {AGAIN}"]),
    ],
)
def test_nothing_drives_on_after_it_was_stopped(ends: str, code: int, played: int, said: list[str]) -> None:
    robots = Robots([Pose(0, 1), Pose(3)], ends=ends)
    assert drive(robots, score(0, 3), yes=True) == code
    assert len(robots.played) == played
    assert robots.said[-1:] == said


def test_poses_in_different_frames_are_no_use() -> None:
    with pytest.raises(CommandError, match="a is measured in the frame 'm' and b in 'o': use one frame"):
        drive(Robots([Pose(0, 1), Pose(3)], frames="mo"), score(0, 3))


@pytest.mark.parametrize(
    ("toml", "options", "line"),
    [
        ("[world]\n", ["--backend", "sim"], "simulated robots begin in their places: there is nothing to drive"),
        ("[world]\n", [], "a can't be driven to its place: its poses are not in the world: add `odom`, and"),
        (
            TOML + "keep_apart = 1\n" + ROBOT.format("a", 0) + ROBOT.format("b", 1),
            [],
            "the places of a and b are 0.66 m apart, edge to edge: start them farther apart, or make `keep_apart`",
        ),
        ("[world]\n", ["--from", "end"], "no scene"),
    ],
)
def test_undrivable_robots_are_refused(toml: str, options: list[str], line: str, tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text(toml)
    (tmp_path / "dance.improv").write_text("a b $ forward\n")
    ended = run("place", "dance.improv", *options, folder=tmp_path)
    assert ended.returncode == FAILED
    assert line in ended.stderr
