"""The times of repeated velocities, on a clock that the tests choose."""

from __future__ import annotations

from itertools import pairwise

import pytest

from improv_core.player.repeats import HOPELESS, SLOTS, SLOWEST, Repeats
from improv_core.score.performance import Mover

RATE = 20.0
PERIOD = 1 / RATE
SLOT = PERIOD / SLOTS


def crowd(count: int) -> Repeats:
    repeats = Repeats()
    for number in range(count):
        repeats.hold(Mover(f"r{number}"), RATE, 0.0)
    return repeats


def play(repeats: Repeats, until: float, cost: float = 0.0, begin: float = 0.0) -> dict[str, list[float]]:
    """The times of each robot's repeats, if sending one takes this many seconds."""
    sent: dict[str, list[float]] = {}
    now = begin
    while (now := max(now, repeats.due)) <= until:
        for mover in repeats.take(now):
            sent.setdefault(mover.robot, []).append(now)
            now += cost
    return sent


def gaps(times: list[float]) -> list[float]:
    return [after - before for before, after in pairwise(times)]


def test_robots_take_turns_in_slots() -> None:
    sent = play(crowd(100), 0.999)
    assert {len(times) for times in sent.values()} == {19, 20}
    assert {round(gap, 9) for times in sent.values() for gap in gaps(times)} == {PERIOD}
    at_once = [sum(0.5 <= time < 0.5 + SLOT for time in times) for times in sent.values()]
    assert sum(at_once) == 100 / SLOTS


def test_no_robot_waits_longer_than_a_period_and_a_slot_after_a_change() -> None:
    for changed in (0.0, 0.001, 0.013, 0.0499, 0.05):
        repeats = crowd(20)
        play(repeats, changed)
        for number in range(20):
            repeats.hold(Mover(f"r{number}"), RATE, changed)
        first = {robot: times[0] for robot, times in play(repeats, 1.0, begin=changed).items()}
        assert all(0 < time - changed <= PERIOD + SLOT + 1e-9 for time in first.values())


def test_others_do_not_shift_the_repeats_of_a_robot() -> None:
    alone = play(crowd(5), 2.0)["r4"]
    repeats = crowd(5)
    sent = play(repeats, 1.0)["r4"]
    for robot in ("r0", "r3"):
        repeats.release(Mover(robot))
    repeats.hold(Mover("new"), RATE, 1.0)
    repeats.hold(Mover("r1"), RATE, 1.0123)
    assert sent + play(repeats, 2.0, begin=1.0)["r4"] == alone


def test_a_hiccup_leaves_one_repeat_of_each_robot_and_the_rate_as_it_was() -> None:
    repeats = crowd(100)
    play(repeats, 1.0)
    sent = play(repeats, 1.4 + PERIOD - 1e-6, begin=1.4)
    assert {len(times) for times in sent.values()} <= {1, 2}
    sent = play(repeats, 5.0, begin=1.45)
    assert {round(gap, 6) for times in sent.values() for gap in gaps(times)} == {PERIOD}
    assert repeats.news() is None


def test_a_slow_machine_repeats_less_often_and_says_so_once() -> None:
    repeats = crowd(1000)
    told = []
    cost = 1 / 12_000  # 12 times a second for each robot
    for second in range(10):
        sent = play(repeats, second + 1.0, cost, second + 0.0)
        told.append(repeats.news())
    (line,) = filter(None, told)
    rate = float(line.split("are now sent ")[1].split()[0])
    assert 10 < rate < 12
    assert line == (
        "this machine can't send 1000 robots 20 commands a second each: those that hold a velocity are now sent "
        f"{rate} a second, and every change of velocity is still sent at its time"
    )
    assert max(gap for times in sent.values() for gap in gaps(times)) <= 1.1 / rate
    assert not repeats.hopeless


def test_the_rate_is_never_lowered_so_far_that_bases_stop() -> None:
    repeats = crowd(1000)
    lowest = RATE / SLOWEST
    for second in range(10):
        sent = play(repeats, second + 1.0, 1 / (lowest * 1000) / 1.5, second + 0.0)
    assert max(gap for times in sent.values() for gap in gaps(times)) <= 1.05 / lowest
    assert not repeats.hopeless
    for second in range(10, 15):
        play(repeats, second + 1.0, 1 / (lowest * 1000) / (HOPELESS * 0.9), second + 0.0)
    assert repeats.hopeless


def test_a_slow_machine_stays_slow_until_fewer_robots_play() -> None:
    repeats = crowd(1000)
    for second in range(5):
        play(repeats, second + 1.0, 1 / 12_000, second + 0.0)
    repeats.restart()
    for robots, rate in ((1000, 11), (10, RATE)):
        for number in range(robots):
            repeats.hold(Mover(f"r{number}"), RATE, 0.0)
        play(repeats, 3.0, 1 / 12_000)
        assert len(play(repeats, 4.0, 1 / 12_000, 3.0)["r0"]) == pytest.approx(rate, abs=1)
        repeats.restart()


def test_few_robots_keep_their_rate_on_a_machine_that_is_busy_with_something_else() -> None:
    repeats = crowd(9)
    for second in range(10):
        play(repeats, second + 1.0, 0.05, second + 0.0)
    assert repeats.news() is None
    assert not repeats.hopeless
    play(repeats, 11.0, begin=11.0)
    sent = play(repeats, 12.0, begin=11.0)
    assert {round(gap, 6) for times in sent.values() for gap in gaps(times)} == {PERIOD}
