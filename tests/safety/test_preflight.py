"""Robots stand where the program has them before they begin, or people get advice."""

from __future__ import annotations

import math

import pytest

from improv_core.safety.odometry import AFTER_MOVING, CONTINUOUS, FRESH
from improv_core.safety.preflight import NAMED, Standing, advice, message, misplaced, refusal, shown
from improv_core.score.motion import STILL, Pose
from improv_core.score.score import Preflight
from tests.safety.test_odometry import Robot

LIMITS = Preflight(0.1, math.radians(10))
TRACKED = "geometry_msgs/PoseStamped"


def degrees(x: float, y: float, heading: float = 0) -> Pose:
    return Pose(x, y, heading=math.radians(heading))


@pytest.mark.parametrize(
    ("ideal", "pose", "line"),
    [
        (degrees(0, 0), degrees(0.1, 0), None),
        (degrees(0, 0), degrees(0, 0, 9.9), None),
        (degrees(1, 1, 355), degrees(1, 1, 4), None),
        (degrees(0, 0), degrees(0.36, 0), "move ada 0.36 m toward 180°"),
        (degrees(0, 0), degrees(0.18, -0.31177, -5), "move ada 0.36 m toward 120° and turn it 5° left"),
        (degrees(0, 0), degrees(0, 0.11, 5), "move ada 0.11 m toward 270° and turn it 5° right"),
        (degrees(2, 3, 90), degrees(2, 3, 79), "turn ada 11° left"),
        (degrees(2, 3, -179), degrees(2, 3, 170), "turn ada 11° left"),
        (degrees(2, 3), degrees(2, 2.98, 20), "turn ada 20° right"),
        (degrees(2, 3), degrees(2, 2.5, 1.5), "move ada 0.50 m toward 90°"),
        (degrees(0, 0), degrees(1e9, 0), "move ada 1000000000.00 m toward 180°"),
        (degrees(0, 0), None, "nobody knows where ada stands: its poses have to arrive"),
    ],
)
def test_robots_that_are_not_in_their_places_get_advice(ideal: Pose, pose: Pose | None, line: str | None) -> None:
    found = misplaced({"ada": Standing(ideal, pose)}, LIMITS)
    assert [advice(robot, each) for robot, each in found.items()] == ([line] if line else [])


@pytest.mark.parametrize(
    ("poses", "lines"),
    [
        ({"a": Pose(2.1), "b": Pose(-0.1), "c": Pose(9)}, ["swap a and b", "move c 5.00 m toward 180°"]),
        ({"a": Pose(2.1), "b": Pose(4.1), "c": Pose(0.1)}, ["move a 2.10 m", "move b 2.10 m", "move c 3.90 m"]),
        ({"a": Pose(2.1), "b": None, "c": None}, ["move a 2.10 m", "nobody knows where b", "nobody knows where c"]),
    ],
)
def test_two_swapped_robots_get_one_line(poses: dict[str, Pose | None], lines: list[str]) -> None:
    ideal = {"a": Pose(), "b": Pose(2), "c": Pose(4)}
    found = {robot: Standing(ideal[robot], pose) for robot, pose in poses.items()}
    assert [line.startswith(begin) for line, begin in zip(shown(found), lines, strict=True)] == [True] * len(lines)
    assert refusal(found).startswith(f"✗ doesn't begin: {lines[0]}")
    told = message(found, 1)["robots"]
    assert {told["a"]["line"], told["b"]["line"], told["c"]["line"]} == {*shown(found)}


def test_the_limits_are_settings() -> None:
    standing = {"ada": Standing(Pose(), degrees(0.36, 0, 20))}
    assert misplaced(standing, Preflight(0.4, math.radians(21))) == {}
    assert misplaced(standing, Preflight(0.4, math.radians(19))) == standing
    assert misplaced(standing, Preflight(0.3, math.radians(21))) == standing


def test_a_line_names_a_few_robots() -> None:
    found = {f"r{number}": Standing(Pose(), Pose(1)) for number in range(1_000)}
    line = refusal(found)
    assert line.count("move") == NAMED
    assert ", and 997 more; then play again (`--force` or *Begin anyway* ignores this)" in line


class Lab(Robot):
    def __init__(self, source: str = TRACKED) -> None:
        super().__init__(source, Pose(), "world")

    def begins(self, pose: Pose | None, *, waits: float = 0.0, anyway: bool = False) -> None:
        """Put the robot there, this many seconds before beat 0 is due."""
        self.stage.sink.resets = True
        self.play(anyway=anyway)
        self.run(0.1)
        if pose:
            self.pose(pose)
        self.run(waits)
        self.stage.sink.resets = False
        self.run(0.1)

    def resume(self) -> None:
        self.stage.ask("resume")
        self.run(0.1)

    @property
    def shown(self) -> list[str]:
        told = [message for message in self.stage.told if message["type"] == "misplaced"]
        return [each["line"] for each in told[-1]["robots"].values()] if told else []

    @property
    def waits(self) -> bool:
        return next(each["waits"] for each in reversed(self.stage.told) if each["type"] == "misplaced")

    @property
    def moves(self) -> tuple[str, bool]:
        return self.player.run.mode, any(twist != STILL for _, _, twist in self.stage.sink.sent)


def test_a_robot_that_is_not_in_its_place_begins_anyway_if_a_person_says_so() -> None:
    lab = Lab()
    lab.begins(Pose(0.36))
    lab.stage.ask("resume", anyway=True)
    lab.run(0.1)
    assert lab.moves == ("playing", True)


def test_a_robot_that_is_not_in_its_place_does_not_begin_and_begins_when_it_is() -> None:
    lab = Lab()
    lab.begins(Pose(0.36))
    assert lab.moves == ("paused", False)
    assert lab.stage.lines == [
        "✗ doesn't begin: move r 0.36 m toward 180°; then play again (`--force` or *Begin anyway* ignores this)"
    ]
    assert lab.shown == ["move r 0.36 m toward 180°"]
    lab.resume()
    assert lab.moves == ("paused", False)
    lab.pose(Pose(0.2))
    assert lab.shown == ["move r 0.20 m toward 180°"]
    lab.pose(Pose(0.02))
    assert lab.shown == []
    assert lab.stage.lines[-1] == "all robots are in their places: play again"
    lab.run(1)
    assert lab.moves == ("paused", False), "it begins only when a person says so"
    lab.pose(Pose(0.5))
    assert lab.shown == ["move r 0.50 m toward 180°"]
    assert lab.waits
    lab.pose(Pose(0.02))
    lab.resume()
    assert (lab.moves, lab.waits) == (("playing", True), False)


def test_robots_do_not_begin_before_a_pose_that_has_come_has_been_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the thread that reads it and the player, it waits like any other arrival."""
    lab = Lab(AFTER_MOVING)
    monkeypatch.setattr(lab.stage.sink, "posed", lambda: ["r"])
    lab.play()
    lab.run(1)
    assert lab.stage.states == ["waiting"]
    lab.pose(Pose())
    lab.run(0.1)
    assert lab.stage.states == ["waiting", "playing"]


@pytest.mark.parametrize(("source", "state"), [(TRACKED, "paused"), (CONTINUOUS, "paused"), (AFTER_MOVING, "playing")])
def test_an_old_pose_counts_only_if_its_source_is_silent_while_robots_stand(source: str, state: str) -> None:
    lab = Lab(source)
    lab.begins(Pose(), waits=FRESH + 0.1)
    assert lab.moves[0] == state


def test_robots_that_were_carried_during_a_pause_do_not_continue() -> None:
    lab = Lab()
    lab.begins(Pose())
    lab.run(0.9)
    lab.stage.ask("pause")
    lab.pose(Pose(1, 1))
    lab.resume()
    assert lab.moves[0] == "paused"
    assert lab.shown[0].startswith("move r 1.")


def test_a_seek_of_real_robots_needs_them_at_their_places_there() -> None:
    lab = Lab()
    lab.begins(Pose())
    lab.pose(Pose(0.2))
    lab.stage.ask("seek", beat=2)
    assert lab.moves[0] == "paused"
    assert lab.shown == ["move r 1.80 m toward 0° and turn it 90° left"]
    lab.pose(degrees(2, 0, 90))
    lab.resume()
    assert lab.moves[0] == "playing"
