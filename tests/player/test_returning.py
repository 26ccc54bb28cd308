"""A robot that was away drives slowly back to its part, and continues there (`rejoin = "return"`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from improv_core.protocol.output import RawPose
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import TURTLEBOT4, slow_speeds
from improv_core.score.score import Host, Safety
from improv_core.score.world import Wall, World
from tests.player.test_player import GONE, Stage, score

STEP = 0.05
"""Seconds between two poses of each robot."""
APART = {"r": Pose(0, 0), "s": Pose(0, 3)}
DRIVES, BACK = "r drives slowly to where it should be, and continues there", "r is back in its place and continues"
SQUARE = "beat 60\nr s $ repeat (forward forward left left)\n"
LINE = "beat 60\nr s $ repeat 5 forward repeat 100 rest\n"
SLOW, SLOW_TURN = slow_speeds(TURTLEBOT4)


class Floor(Stage):
    """Two real robots that obey their commands at once, and a camera that sees them."""

    def __init__(
        self,
        program: str = LINE,
        *,
        world: World | None = None,
        deaf: Mapping[str, str] | None = None,
        elsewhere: Collection[str] = (),
    ) -> None:
        super().__init__()
        self.sink.real, self.sink.deaf = True, dict(deaf or {})
        self.poses = dict(APART)
        self.unseen: set[str] = set()
        self._heard = self._mark = 0
        self._obeys = dict.fromkeys(APART, STILL)
        read = score(program)
        parts = {
            robot: replace(
                part,
                odom=f"/{robot}/pose",
                odom_frame="world",
                start=APART[robot],
                profile=TURTLEBOT4,
                host=Host("pad") if robot in elsewhere else None,
            )
            for robot, part in read.parts.items()
        }
        self.dance = replace(
            read, parts=parts, world=world or World(keep_apart=0.3), safety=Safety(rejoin="return")
        ).on("")
        self.see()
        self.perform(self.dance, anyway=True)

    def see(self) -> None:
        seen = self.poses.keys() - self.unseen
        raw = [RawPose(robot, "geometry_msgs/PoseStamped", self.poses[robot], self.now) for robot in sorted(seen)]
        self.player.measure(raw, self.now)

    def move(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.run(STEP)
            for robot, _, twist in self.sink.sent[self._heard :]:
                self._obeys[robot] = STILL if robot in self.sink.deaf else twist
            self._heard = len(self.sink.sent)
            for robot, twist in self._obeys.items():
                self.poses[robot] = self.poses[robot].after(twist, STEP)
            self.see()

    def heard(self, robot: str = "r") -> list[Twist]:
        found = [twist for name, _, twist in self.sink.sent[self._mark :] if name == robot]
        self._mark = len(self.sink.sent)
        return found

    def stands(self, seconds: float = 1.0) -> bool:
        self.heard()
        before = self.poses["r"]
        self.move(seconds)
        return not any(twist != STILL for twist in self.heard()) and self.poses["r"].apart(before)[0] < 0.02

    @property
    def off(self) -> float:
        """The distance of robot `r` from the ideal pose of its part, in meters."""
        measured = [each["robots"]["r"] for each in self.told if each["type"] == "measured" and "r" in each["robots"]]
        ideal = measured[-1]["ideal"]
        return math.dist((ideal["x"], ideal["y"]), (self.poses["r"].x, self.poses["r"].y))


def returning(program: str = LINE, seconds: float = 3.0, **rest: Any) -> Floor:
    """Robot `r` was away while its part continued, and has begun to drive back."""
    floor = Floor(program, **rest)
    floor.move(1)
    floor.sink.deaf = GONE
    floor.move(seconds)
    floor.sink.deaf = {}
    floor.move(1)
    return floor


def until_back(floor: Floor) -> None:
    for _ in range(60):
        if BACK in floor.lines:
            return
        floor.move(1)
    raise AssertionError(floor.lines)


def test_a_robot_drives_slowly_to_where_its_part_has_it_and_continues_there() -> None:
    floor = Floor(SQUARE)
    floor.move(1)
    floor.sink.deaf = GONE
    floor.move(2)
    assert floor.off > 0.15
    floor.sink.deaf = {}
    floor.heard()
    while BACK not in floor.lines:
        way = floor.heard()
        assert all(abs(twist.x) <= SLOW and abs(twist.yaw) <= SLOW_TURN for twist in way)
        floor.move(STEP)
    assert DRIVES in floor.lines
    floor.move(8)
    assert floor.off < 0.1
    assert max(twist.x for twist in floor.heard()) > SLOW, "it dances as before"
    assert {twist.x for twist in floor.heard("s")} <= {0.0, 0.2}


def test_a_robot_that_was_missing_at_beat_0_drives_to_its_part_too() -> None:
    floor = Floor(deaf=GONE)
    floor.move(8)
    assert floor.states[-1] == "playing"
    floor.sink.deaf = {}
    floor.heard()
    floor.move(3)
    assert DRIVES in floor.lines
    assert 0 < max(twist.x for twist in floor.heard()) <= SLOW
    until_back(floor)


def test_driving_back_is_reported() -> None:
    floor = returning()
    floor.move(1)
    told = [each["robots"] for each in floor.told if each["type"] == "vitals"]
    assert (told[-1]["r"]["instead"], told[-1]["s"]["instead"]) == ("drives back", "")
    floor.sink.deaf = GONE
    floor.move(2)
    told = [each["robots"] for each in floor.told if each["type"] == "vitals"]
    assert told[-1]["r"]["instead"] == "stands"


@pytest.mark.parametrize("elsewhere", [set(), {"s"}], ids=["s is here", "another stage moves s"])
@pytest.mark.parametrize("why", ["r is not seen", "s is not seen", "s is in its way"])
def test_it_stands_while_it_cannot_drive_safely(why: str, elsewhere: Collection[str]) -> None:
    floor = returning(elsewhere=elsewhere)
    assert not floor.stands()
    if why.endswith("seen"):
        floor.unseen = {why[0]}
    else:
        floor.poses["s"] = floor.poses["r"].after(Twist(0.7), 1)
    floor.move(0.3)
    assert floor.stands()
    floor.unseen, floor.poses["s"] = set(), APART["s"]
    floor.move(0.1)
    assert not floor.stands()


@pytest.mark.parametrize(
    ("program", "walls"),
    [(LINE, (Wall(0.6, -2, 0.6, 2),)), ("beat 60\nr s $ repeat 3 forward repeat (if near left else right)\n", ())],
    ids=["a wall is in its way", "senses decide its part"],
)
def test_a_robot_that_finds_no_path_stands_and_is_named_once(program: str, walls: tuple[Wall, ...]) -> None:
    floor = returning(program, world=World(keep_apart=0.3, walls=walls))
    assert floor.stands(3)
    assert floor.lines.count("r finds no path to where it should be: carry it there") == 1


HALTS: dict[str, Callable[[Floor], None]] = {
    "mute": lambda floor: floor.ask("silence", muted=["r"], soloed=[]),
    "stop": lambda floor: floor.ask("stop"),
    "pause": lambda floor: floor.ask("pause"),
    "lose": lambda floor: floor.sink.deaf.update(GONE),
}


@pytest.mark.parametrize("halt", HALTS)
def test_every_stop_stops_it_on_its_way(halt: str) -> None:
    floor = returning()
    floor.heard()
    HALTS[halt](floor)
    floor.move(1 if halt == "lose" else 0.1)
    assert floor.heard()[-1] == STILL
    assert floor.stands(3)


def pause(floor: Floor) -> None:
    floor.ask("pause")
    floor.move(1)
    floor.ask("resume")


@pytest.mark.parametrize(
    ("program", "happens"),
    [
        ("beat 60\nr s $ repeat 4 forward\n---\nr s $ repeat 20 rest backward\n", lambda floor: None),
        (LINE, pause),
        (SQUARE, lambda floor: floor.ask("speed", factor=0.25)),
        (SQUARE, lambda floor: floor.ask("speed", factor=3.0)),
        (SQUARE, lambda floor: floor.perform(replace(floor.dance, tempo=Fraction(120)), 2, "now")),
    ],
    ids=["its part stands", "a pause", "a slow speed", "a fast speed", "a save"],
)
def test_a_robot_continues_only_at_the_place_of_its_part(program: str, happens: Callable[[Floor], None]) -> None:
    floor = returning(program)
    happens(floor)
    while BACK not in floor.lines:
        floor.move(STEP)
        assert floor.now < 1100
    assert (floor.off < 0.15, floor.states[-1]) == (True, "playing")
