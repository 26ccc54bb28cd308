"""Simulated robots that keep apart: their least distance although poses are late, lost, or wrong, and motors need time,
and robots that aren't paused."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from improv_core.protocol.output import RawPose
from improv_core.safety.odometry import CONTINUOUS
from improv_core.safety.separation import LOOK_PERIOD, Proximity
from improv_core.safety.stopping_distance import BRAKING, REACTION, Base, coasting
from improv_core.score.following import accelerated
from improv_core.score.motion import STILL, Pose, Twist

KEEP_APART, RADIUS, SPEED = 0.1, 0.171, 0.3
STEP = 0.005
"""Seconds of one step of the simulation."""
POSE_PERIOD = 0.05
LATEST = REACTION - LOOK_PERIOD - 2 * STEP
"""The latest time at which a simulated base obeys."""
AHEAD, BACK, TURN, STRAFE = Twist(SPEED), Twist(-SPEED), Twist(yaw=1.9), Twist(y=SPEED)
ABRUPT = 100.0
"""m/s² of a base without a known acceleration."""


@dataclass
class Robot:
    """A base that obeys late, and changes its speed only so fast. It begins at a pose, gets twists at times, and its
    poses come late. A pose may jump, as `number: (x, y)`, or get lost."""

    pose: Pose
    told: Sequence[tuple[float, Twist]]
    acceleration: float | None = 0.9
    latency: float = LATEST
    delays: Sequence[float] = (0.08,)
    jumps: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    lost: frozenset[int] = frozenset()
    speed: Twist = STILL
    obeys: list[tuple[float, Twist]] = field(default_factory=list)

    def move(self, now: float) -> None:
        wanted = [twist for at, twist in self.obeys if at + self.latency <= now]
        motors = self.acceleration or ABRUPT, 7.725
        self.speed = accelerated(self.speed, wanted[-1] if wanted else STILL, STEP, motors)
        self.pose = self.pose.after(self.speed, STEP)

    def measured(self, name: str, number: int, now: float) -> tuple[float, RawPose] | None:
        """The time at which its next pose comes, and the pose; no two in a row get lost."""
        if number in self.lost and number - 1 not in self.lost:
            return None
        x, y = self.jumps.get(number, (0.0, 0.0))
        pose = Pose(self.pose.x + x, self.pose.y + y, 0.0, self.pose.heading)
        return now + self.delays[number % len(self.delays)], RawPose(name, CONTINUOUS, pose, now)


class Stage:
    """A stage that moves some of the robots, and gets the poses of the others from their stages."""

    def __init__(self, robots: Mapping[str, Robot], ours: frozenset[str]) -> None:
        self.robots, self.ours = robots, ours
        self.bases = {
            name: Base(RADIUS, SPEED, robot.acceleration or BRAKING, elsewhere=name not in ours)
            for name, robot in robots.items()
        }
        first = [RawPose(name, CONTINUOUS, robot.pose, 0.0) for name, robot in robots.items()]
        self.proximity = Proximity().heard(first, self.bases)
        self.due, self.paused, self.was_late = 0.0, False, False
        self.left = {name: [*robot.told] for name, robot in robots.items()}  # the commands of the score to come
        self.coming: list[tuple[float, RawPose]] = []

    def tell(self, name: str, twist: Twist, now: float) -> None:
        self.robots[name].obeys.append((now, twist))
        self.proximity = self.proximity.sent(name, twist, now)

    def look(self, now: float) -> bool:
        self.proximity, found, self.due = self.proximity.looked(True, self.bases, KEEP_APART, now, self.ours)
        return bool(found)

    def pause(self, now: float) -> None:
        self.paused = True
        for name in self.ours:
            self.tell(name, STILL, now)

    def play(self, now: float) -> bool:
        """Play everything due since the last time. Return whether robots are too near."""
        looks = now >= self.due
        for name, left in self.left.items():
            while left and left[0][0] <= now:
                _, twist = left.pop(0)
                if name not in self.ours:  # every stage plays the whole score
                    self.proximity = self.proximity.sent(name, twist, now)
                    continue
                self.tell(name, twist, now)
                self.was_late |= self.look(now)
        come = [raw for at, raw in self.coming if at <= now]
        self.coming = [each for each in self.coming if each[0] > now]
        self.proximity = self.proximity.heard(sorted(come, key=lambda raw: raw.at), self.bases)
        return (looks or bool(come)) and self.look(now)

    def saying(self, raw: RawPose) -> RawPose:
        """The pose of a robot here, as other stages get it."""
        told = self.proximity.tracks[raw.robot].sent
        return raw._replace(told=told[-1].twist if told else None)


@dataclass
class Story:
    """The outcome: whether robots were paused, whether they were already too near for a command when it came, and their
    least distance from edge to edge."""

    paused: bool = False
    was_late: bool = False
    nearest: float = math.inf


def play(robots: Mapping[str, Robot], *, link: float | None = None, seconds: float = 3.0) -> Story:
    """Play until all robots stand after a pause, or for so long. With a link, each robot has its own stage, and
    messages of one reach another after this many seconds."""
    hosts = [frozenset(robots)] if link is None else [frozenset([name]) for name in robots]
    stages, story, pauses = [Stage(robots, ours) for ours in hosts], Story(), math.inf
    for step in range(round((seconds + 3.0) / STEP)):
        now = step * STEP
        if step % round(POSE_PERIOD / STEP) == 0:
            for name, robot in robots.items():
                if measured := robot.measured(name, step // round(POSE_PERIOD / STEP), now):
                    comes, raw = measured
                    owner = next(stage for stage in stages if name in stage.ours)
                    for stage in stages:
                        heard = (comes, raw) if stage is owner else (comes + (link or 0.0), owner.saying(raw))
                        stage.coming.append(heard)
        for stage in stages:
            if stage.paused:
                continue
            too_near = stage.play(now)
            story.was_late |= stage.was_late
            if too_near or now >= pauses:
                stage.pause(now)
                story.paused = True
                pauses = min(pauses, now + (link or 0.0))
        for robot in robots.values():
            robot.move(now)
        story.nearest = min(story.nearest, gap(robots))
        if (now >= seconds and not story.paused) or (
            all(stage.paused for stage in stages) and all(robot.speed == STILL for robot in robots.values())
        ):
            break
    return story


def gap(robots: Mapping[str, Robot]) -> float:
    each = [robot.pose for robot in robots.values()]
    return min(one.apart(other)[0] - 2 * RADIUS for number, one in enumerate(each) for other in each[:number])


def at(gap: float, heading: float = 0.0, *, beside: float = 0.0) -> Pose:
    """A pose with this many meters between the edges, ahead of a robot at the origin, and so far beside its path."""
    return Pose(gap + 2 * RADIUS if gap else 0.0, beside, 0.0, heading)


@pytest.mark.parametrize("link", [None, 0.02, 0.1])
@pytest.mark.parametrize("acceleration", [0.9, None])
def test_two_that_drive_toward_each_other_come_to_rest_apart(acceleration: float | None, link: float | None) -> None:
    """Their poses are 0.08 s old."""
    forward = [(0.0, AHEAD)]
    a, b = Robot(at(0), forward, acceleration), Robot(at(1.0, math.pi), forward, acceleration)
    story = play({"a": a, "b": b}, link=link)
    assert story.paused
    assert KEEP_APART <= story.nearest < 0.4


@pytest.mark.parametrize("lost", [False, True])
def test_a_pose_that_is_slightly_wrong_brings_robots_no_nearer(lost: bool) -> None:
    """It shows a robot 0.05 m behind its place, where it can be, and the next one may get lost."""
    for number in range(13, 18):
        missing = frozenset([number + 1] if lost else [])
        a = Robot(at(0), [(0.0, AHEAD)], delays=[0.09], jumps={number: (-0.05, 0.0)}, lost=missing)
        b = Robot(at(0.667, math.pi), [(0.0, AHEAD)], delays=[0.09])
        assert play({"a": a, "b": b}).nearest >= KEEP_APART, number


@pytest.mark.parametrize("link", [None, 0.1])
def test_a_robot_that_moves_without_a_command_pauses_all(link: float | None) -> None:
    story = play({"a": Robot(at(0), [(0.0, AHEAD)]), "b": Robot(at(1.0, math.pi), [], obeys=[(0.0, AHEAD)])}, link=link)
    assert story.paused
    assert KEEP_APART <= story.nearest < 0.4


twists = st.builds(Twist, st.sampled_from([SPEED, SPEED / 2, 0.0, -SPEED]), yaw=st.sampled_from([0.0, 0.0, 0.7, -1.9]))
commands = st.lists(st.tuples(st.just(0.0) | st.floats(0.0, 2.5), twists), min_size=1, max_size=5)
offsets = st.tuples(st.floats(-1, 1), st.floats(-1, 1))
robots = st.builds(
    Robot,
    st.builds(Pose, st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.just(0.0), st.floats(-math.pi, math.pi)),
    commands.map(lambda told: sorted(told, key=lambda each: each[0])),
    st.sampled_from([None, 0.5, 0.9, 2.0]),
    st.floats(0.0, LATEST),
    st.lists(st.floats(0.0, 0.09), min_size=1, max_size=7),
    st.dictionaries(st.integers(5, 50), offsets, max_size=1),
    st.frozensets(st.integers(1, 50), max_size=5),
)


@pytest.mark.slow("simulates many dances")
@given(st.lists(robots, min_size=2, max_size=3), st.none() | st.floats(0.0, 0.3))
def test_robots_far_enough_apart_come_to_rest_apart(drawn: Sequence[Robot], link: float | None) -> None:
    robots = {f"r{number}": robot for number, robot in enumerate(drawn)}
    assume(gap(robots) >= KEEP_APART)
    story = play(robots, link=link)
    assume(not story.was_late)
    event("paused" if story.paused else "not paused")
    assert story.nearest >= KEEP_APART - 1e-6


@pytest.mark.parametrize(
    ("one", "other", "link"),
    [
        (one, other, link)
        for link, more in ((None, 0.0), (0.02, 0.04), (0.1, 0.04))
        for one, other in (
            (Robot(at(0), [(0, AHEAD)]), Robot(at(0, beside=2 * RADIUS + 0.11 + more), [(0, AHEAD)])),
            (Robot(at(0), [(0, AHEAD)]), Robot(at(0.6, math.pi, beside=2 * RADIUS + 0.16 + more), [(0, AHEAD)])),
            (Robot(at(0), [(0, BACK)]), Robot(at(0.11), [(0, AHEAD)])),
            (Robot(at(0), [(0, TURN)]), Robot(at(0.11), [(0, STILL)])),
            (Robot(at(0), [(0, STRAFE)]), Robot(at(0.11), [(0, STRAFE)])),
            (Robot(at(0), [(0, AHEAD)]), Robot(at(0.31 + more), [(0, AHEAD)])),
            (Robot(at(0), [(0, AHEAD), (1, STILL)]), Robot(at(0.6), [(0, STILL)])),
        )
    ],
    ids=[
        f"{what} {link}"
        for link in ("here", "near", "far")
        for what in ("side by side", "passing", "apart", "turning", "strafing", "in a row", "up to another")
    ],
)
def test_robots_that_stay_apart_are_not_paused(one: Robot, other: Robot, link: float | None) -> None:
    """Also if a pose of each jumps. On links, poses of two robots are from different times, so robots that pass or
    follow each other need 0.04 m more."""
    for jumps in ({}, {7: (0.3, 0.1)}, {23: (-0.2, -0.5)}):
        a, b = (replace(robot, jumps=jumps, obeys=[]) for robot in (one, other))
        story = play({"a": a, "b": b}, link=link)
        assert not story.paused, jumps


def left_when_found(seen_at: Callable[[float], Pose], twist: Twist) -> float | None:
    """Return the distance that is left between the edges of a robot that stands at -1.5 m and one that is seen at
    these poses when the two are found too near; None if they never are."""
    base = Base(0.089, 0.22)
    bases, proximity = {"a": base, "b": base}, Proximity().sent("a", twist, 0.0)
    for number in range(50):
        now = number * 0.04
        poses = [RawPose("b", CONTINUOUS, Pose(-1.5), now), RawPose("a", CONTINUOUS, seen_at(now), now)]
        proximity = proximity.heard(poses, bases)
        proximity, found, _ = proximity.looked(True, bases, KEEP_APART, now + 0.08)
        if found:
            return found[0].gap - KEEP_APART
    return None


def test_a_robot_that_a_camera_sees_beside_itself_does_not_seem_to_circle_toward_another() -> None:
    assert left_when_found(lambda now: Pose(heading=0.785 * now).then(Pose(y=1.0)), Twist(yaw=0.785)) is None


@pytest.mark.parametrize("turning", [0.0, 0.3])
def test_a_robot_that_is_pushed_faster_than_it_can_drive_has_room_to_brake(turning: float) -> None:
    left = left_when_found(lambda now: Pose(-0.1 - 0.6 * now, heading=turning * now), STILL)
    assert left is not None
    assert left >= coasting(0.6, BRAKING, 0.08) - 0.6 * 0.04
