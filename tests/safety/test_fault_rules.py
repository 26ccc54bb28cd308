"""Faults of a robot: the facts at each look → the times at which a fault begins, and is over."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction

import pytest

from improv_core.protocol.output import Noticed, RawPose, Unfollowed
from improv_core.safety.fault_monitor import FaultMonitor
from improv_core.safety.fault_rules import QUIET, RUSHED, FaultBegan, FaultOver, RobotFacts, RobotWatch, Worst, look
from improv_core.safety.odometry import CONTINUOUS, Comparison
from improv_core.score.faults import FaultRules
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part, Score
from tests.player.test_player import score

RULES = FaultRules()
LOOK = 0.1
SPEED = 0.2


def measured(at: float, pose: Pose, ideal: Pose, **different: object) -> Comparison:
    raw = RawPose("r", CONTINUOUS, pose, at)
    return Comparison(raw, pose, ideal, 1, False, (ideal,))._replace(**different)  # type: ignore[arg-type]


def watched(known: Iterable[RobotFacts], rules: FaultRules = RULES) -> list[str]:
    """Return the times at which each fault begins and is over: `1.1 +stuck`, `3.0 -stuck`."""
    watch, lines = RobotWatch(), []
    for each in known:
        watch, news = look(watch, each, rules)
        for found in news:
            assert isinstance(found, (FaultBegan, FaultOver))
            lines.append(f"{each.now:.1f} {'+' if isinstance(found, FaultBegan) else '-'}{found.fault}")
    return lines


def driving(
    where: Callable[[float], Pose | None],
    seconds: float,
    speed: float = SPEED,
    late: float = 0.0,
    moves: bool = True,
    every: float = LOOK,
) -> Iterable[RobotFacts]:
    """A robot that is sent to drive from time 0 on, at `speed`, and is at `where`; None: no pose comes. Poses come
    `late`, one after each `every` seconds."""
    taken = -1
    for count in range(round(seconds / LOOK) + 1):
        now = count * LOOK
        poses = []
        if math.floor(now / every + 1e-6) > taken:
            taken = math.floor(now / every + 1e-6)
            ideal = Pose(speed * now if moves else 0.0)
            recent = (Pose(speed * max(now - 0.25, 0) if moves else 0.0),)
            if pose := where(max(now - late, 0.0)):
                poses.append(measured(now, pose, ideal, recent=recent))
        yield RobotFacts(now, poses, now, 0.0 if moves else None)


def on_path(at: float) -> Pose:
    return Pose(SPEED * at)


def halts(at: float) -> Pose:
    return Pose(SPEED * min(at, 2.0))


def rests(at: float) -> Pose:
    return Pose(SPEED * (at if at < 2 else max(at - 2, 2)))


def starting(speed: float) -> Callable[[float], Pose]:
    return lambda at: Pose(speed * max(at - 0.12, 0))


def turning(by: float, seconds: float) -> Iterable[RobotFacts]:
    """A robot whose heading is off by an angle and that turns on the spot in every other second; its poses are late."""

    def heading(at: float) -> float:
        return math.pi / 2 * sum(min(max(at - begin, 0.0), 1.0) for begin in range(0, round(seconds), 2))

    for count in range(round(seconds / LOOK) + 1):
        now = count * LOOK
        recent = tuple(Pose(heading=heading(now - lag)) for lag in (0.08, 0.16, 0.25))
        pose = measured(now, Pose(heading=heading(now - 0.08) + by), Pose(heading=heading(now)), recent=recent)
        yield RobotFacts(now, [pose], now, 0.0)


def test_turns_neither_bring_a_robot_back_on_its_path_nor_take_it_off() -> None:
    for degrees in (30, -30, 20, -20):
        said = [line for line in watched(turning(math.radians(degrees), 12)) if "off_path" in line]
        assert len(said) == 1
        assert "+off_path" in said[0]
    assert not [line for line in watched(turning(0, 12)) if "off_path" in line]


@pytest.mark.parametrize(
    ("known", "told"),
    [
        (driving(on_path, 5), []),
        (driving(on_path, 5, late=0.2), []),
        # Its last pose comes at 1.9 s.
        (driving(lambda at: on_path(at) if at < 2 or at >= 5 else None, 6), ["2.9 +silent", "5.0 -silent"]),
        (driving(lambda at: Pose() if at < 2 else None, 6, moves=False), ["2.9 +silent"]),
        # A source that sends a pose every 0.8 s has three times as long.
        (driving(lambda at: on_path(at) if at < 3 else None, 8, every=0.8), ["4.9 +silent"]),
        # It is blocked at 2 s.
        (driving(halts, 3.1), ["2.7 +stuck"]),
        # The wheels of a slow robot are held from 2 s on, or from the start.
        (driving(lambda at: Pose(0.05 * min(at, 2.0)), 3.5, speed=0.05), ["2.8 +stuck"]),
        (driving(lambda at: Pose(), 1.5, speed=0.05), ["1.3 +stuck"]),
        # It moves, but its poses come 0.3 s late, and it takes 0.12 s to get up to speed.
        *((driving(starting(speed), 3, speed, late=0.3), []) for speed in (0.05, 0.1, 0.11, SPEED)),
        (driving(rests, 4.3), ["2.7 +stuck", "3.6 +off_path", "4.2 -stuck"]),
        # Wheels 20% off: after 6.25 s it is 0.25 m behind, and after 7.5 s also behind its ideal pose of 0.25 s ago.
        (driving(lambda at: Pose(0.8 * SPEED * at), 8), ["7.6 +off_path"]),
        # It is turned by 16 degrees, without a command.
        (driving(lambda at: Pose(SPEED * at, heading=math.radians(16 if at >= 2 else 0)), 3), ["2.0 +off_path"]),
        (driving(lambda at: Pose(SPEED * at, heading=math.radians(14)), 3), []),
        (driving(lambda at: Pose(SPEED * at, 0.26 if 1 <= at < 2 else 0), 3), ["1.0 +off_path", "2.0 -off_path"]),
        (driving(lambda at: Pose(SPEED * at, 0.26 if at < 1 else 0.24), 3), ["0.0 +off_path"]),
        # It is slow, or trembles on the spot: that isn't stuck.
        (driving(lambda at: Pose(0.03 * at), 5, speed=0.03), []),
        (driving(lambda at: Pose(), 30, moves=False), []),
    ],
)
def test_measured_poses_show_faults(known: Iterable[RobotFacts], told: list[str]) -> None:
    assert watched(known) == told


def test_joints_that_do_not_follow_are_a_fault_with_its_cause() -> None:
    known = [RobotFacts(0.1), RobotFacts(0.2, unfollowed=Unfollowed(1.05, "head moves nothing")), RobotFacts(0.3)]
    assert watched(known) == ["0.2 +joints", "0.3 -joints"]
    _, news = look(RobotWatch(), known[1], RULES)
    assert news == [FaultBegan("joints", Worst(seconds=1.05), why="head moves nothing")]


@pytest.mark.parametrize(("rushed", "why"), [(False, ""), (True, RUSHED)])
def test_a_robot_that_is_asked_for_the_impossible_is_not_blamed(rushed: bool, why: str) -> None:
    facts = [replace(each, rushed=rushed) for each in driving(lambda at: Pose(0.0), 2.0)]
    watch, found = RobotWatch(), []
    for known in facts:
        watch, news = look(watch, known, RULES)
        found += [each for each in news if each.fault == "off_path"]
    assert [each.why for each in found if isinstance(each, FaultBegan)] == [why]


def test_only_a_change_that_a_robot_s_accelerations_do_not_allow_rushes_it() -> None:
    """It takes half a second to reverse. A stop right after a change is no request of the program."""
    profile = replace(TURTLESIM, max_angular_acceleration=4.0)
    part = Part("r", (), profile, Pose(), "/r/cmd_vel")
    score = Score(Fraction(60), {"r": part})
    left, right = Twist(yaw=1.0), Twist(yaw=-1.0)
    for sent, rushed in [
        ([(0.0, left), (1.0, right), (2.0, left)], False),
        ([(0.0, left), (0.2, STILL)], False),
        ([(0.0, left), (1.0, right), (1.4, left)], True),
    ]:
        monitor = FaultMonitor()
        for at, twist in sent:
            monitor.tell("r", twist, at)
        assert [*monitor.look_around(score, {}, Noticed(), 5.0)] == []
        assert monitor._robots["r"].rushed is rushed


@pytest.mark.parametrize(("back", "faults"), [([], ["stuck"]), (["r"], [])])
def test_a_robot_that_drives_back_to_its_part_is_not_stuck_because_the_part_moves_on(
    back: list[str], faults: list[str]
) -> None:
    part = replace(score("beat 60\nr $ repeat forward").parts["r"], odom="/r/odom")
    monitor, dance, news = FaultMonitor(), Score(Fraction(60), {"r": part}), list[str]()
    monitor.tell("r", Twist(0.05), 0.0)
    for count in range(1, 12):
        monitor.take(measured(count * LOOK, Pose(), Pose(SPEED * count * LOOK)))
        noticed = Noticed(heard=count * LOOK)
        news += [each.news.fault for each in monitor.look_around(dance, {}, noticed, count * LOOK + 0.01, back)]
    assert news == faults


def test_a_robot_that_nobody_measures_is_neither_silent_nor_stuck() -> None:
    assert watched(RobotFacts(now, (), None, 0.0) for now in range(100)) == []


def test_nobody_blames_a_robot_while_the_reader_of_its_poses_stalls() -> None:
    poses = [measured(0.0, Pose(), Pose())]
    assert watched([RobotFacts(0.0, poses, 0.0, 0.0), RobotFacts(9.0, (), 0.5, 0.0)]) == []
    assert watched([RobotFacts(0.0, poses, 0.0, 0.0), RobotFacts(9.0, (), 1.5, 0.0)]) == ["9.0 +silent"]


def test_a_jump_is_reported_once_until_there_was_none_for_a_while() -> None:
    def known(now: float) -> RobotFacts:
        jump = (1.0, 0.0) if now in (1, 2, 3) else None
        return RobotFacts(now, [measured(now, Pose(), Pose(), jump=jump)], now)

    assert watched(known(now) for now in range(16)) == ["1.0 +jumped", f"{3 + QUIET:.1f} -jumped"]


def test_late_commands_are_reported_once_until_there_were_none_for_a_while() -> None:
    late = {1: 0.021, 2: 0.019, 3: 0.3}
    lines = watched(RobotFacts(now, late=late.get(now, 0.0)) for now in range(16))
    assert lines == ["1.0 +late", f"{3 + QUIET:.1f} -late"]


def test_a_listener_that_is_gone_and_comes_back() -> None:
    assert watched(RobotFacts(now, gone=2 <= now < 5) for now in range(8)) == ["2.0 +gone", "5.0 -gone"]


def test_a_robot_whose_listener_is_gone_is_not_stuck_and_may_begin_to_move_once_it_is_back() -> None:
    """It drives again 0.3 s after it listens again."""
    drives = driving(lambda at: Pose(SPEED * (min(at, 2.0) + max(at - 5.3, 0.0))), 8)
    told = watched((replace(each, gone=2 <= each.now < 5) for each in drives), FaultRules(distance=9.0))
    assert told == ["2.0 +gone", "5.0 -gone"]


def test_the_extent_of_a_fault_is_its_maximum() -> None:
    watch, _ = look(RobotWatch(), RobotFacts(0.0, late=0.03), RULES)
    for late in (0.2, 0.1):
        watch, news = look(watch, RobotFacts(1.0, late=late), RULES)
        assert news == []
    _, news = look(watch, RobotFacts(99.0), RULES)
    assert [(each.fault, each.worst.seconds) for each in news] == [("late", 0.2)]


def test_the_limits_of_a_path_can_be_set() -> None:
    known = [RobotFacts(0.0, [measured(0.0, Pose(0.5), Pose())], 0.0)]
    assert watched(known, FaultRules(distance=0.6)) == []
    assert watched(known, FaultRules(distance=0.4)) == ["0.0 +off_path"]


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e300, -1e300])
def test_poses_that_are_no_places_end_nothing(bad: float) -> None:
    poses = [measured(0.0, Pose(), Pose()), measured(0.05, Pose(bad, bad, 0, bad if math.isfinite(bad) else 0), Pose())]
    watched([RobotFacts(0.1, poses, 0.1, 0.0), RobotFacts(0.2, (), 0.2, 0.0)])
