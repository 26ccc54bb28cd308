"""A performance follows a clock from outside: simulated clocks, and the commands to robots and their times."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import pytest

from improv_core.player.player import Player
from improv_core.score.peer_clock import Anchor, Estimate
from improv_core.score.profiles import Profile
from improv_core.score.score import Follow, OutsideClock
from tests.player.test_player import Stage, score
from tests.score.test_peer_clock import Phase, follow, heard, ramp, steady

DANCE = "beat 120\nr $ repeat (forward left)"
"""A change at each beat."""
AWAITED = "the dance begins at the next bar of the MIDI clock, once it is heard"
ANCHORS = 0.1
"""Seconds between two anchors, as its source sends them."""
START = 1000.0
"""The time at which the simulated clock starts, and the stage gets its score."""


def stage_following(clock: Follow, program: str = DANCE, *, profile: Profile | None = None) -> Stage:
    stage = Stage(START)
    stage.player = Player(stage.sink, stage.told.append, lambda: stage.now)  # with a wall clock that keeps running
    stage.sink.real = clock == "ros"
    dance = replace(score(program), clock=OutsideClock(clock))
    if profile:
        dance = replace(dance, parts={name: replace(part, profile=profile) for name, part in dance.parts.items()})
    stage.perform(dance)
    return stage


def anchors(phase: Phase, until: float, every: float, since: float = 0.0, jitter: float = 0.005) -> list[Anchor]:
    """The anchors that a source sends about a clock, on the stage's clock."""
    told: list[Anchor] = []
    for known in follow(heard(phase, until, every, since, jitter)):
        at = known.anchor.at + START
        if known.is_known and (not told or at - told[-1].at >= ANCHORS):
            told.append(replace(known.anchor, at=at))
    return told


def play(stage: Stage, told: Sequence[Anchor], until: float) -> None:
    for each in told:
        stage.run(each.at - stage.now)
        stage.player.take(each, stage.now)
    stage.run(START + until - stage.now)


def beats_of(stage: Stage) -> list[float]:
    """The times at which beats began, in seconds after the start, by the robot's commands."""
    zero = stage.player.run.transport.zero - START
    kinds = [(at + zero, twist.x > 0) for _, at, twist in stage.sink.sent if twist.x or twist.yaw]
    return [at for index, (at, kind) in enumerate(kinds) if not index or kinds[index - 1][1] != kind]


def gaps(stage: Stage) -> list[float]:
    return [later - earlier for earlier, later in pairwise(beats_of(stage))]


def errors(stage: Stage, phase: Phase, since: float = 4.0) -> list[float]:
    """The seconds by which each beat was off that of the clock."""
    beats = [at for at in beats_of(stage) if at >= since]
    rates = [phase(at + 0.5) - phase(at - 0.5) for at in beats]
    return [abs(phase(at) - round(phase(at))) / rate for at, rate in zip(beats, rates, strict=True)]


def check(stage: Stage, phase: Phase, least: int) -> None:
    """After 4 s, 99 of 100 beats are within 15 ms of the clock's, and each is played once, in its turn."""
    found = sorted(errors(stage, phase))
    assert len(found) >= least
    assert found[int(0.99 * len(found))] <= 0.015, found[-5:]
    apart = gaps(stage)
    assert max(apart) < 2 * min(apart), "none is left out or comes twice"


def lines(stage: Stage) -> list[str]:
    return [line for line in stage.lines if line != AWAITED]


# Music


@pytest.mark.parametrize("phase", [steady(90), steady(119), ramp], ids=["slower", "nearly the same", "a ramp"])
def test_beats_are_those_of_the_clock(phase: Phase) -> None:
    stage = stage_following("midi")
    play(stage, anchors(phase, 60, 1 / 48), 60)
    check(stage, phase, least=70)


def test_beat_0_is_at_the_next_bar_of_a_clock_that_starts_late() -> None:
    stage = stage_following("midi")
    stage.run(5)
    assert (beats_of(stage), stage.lines, stage.states) == ([], [AWAITED], ["waiting"])
    phase: Phase = lambda now: (now - 5) * 2  # noqa: E731
    play(stage, anchors(phase, 12, 1 / 48, since=5), 12)
    first = beats_of(stage)[0]
    assert phase(first) % 4 == pytest.approx(0, abs=0.03) or phase(first) % 4 == pytest.approx(4, abs=0.03)
    assert first < 8


def test_robots_are_as_fast_as_the_music() -> None:
    stage = stage_following("midi")
    play(stage, anchors(steady(90), 20, 1 / 48, jitter=0.0), 20)
    assert stage.sink.sent[-1][2].x in (0, pytest.approx(2 * 1.5, rel=0.01))
    assert stage.transports[-1]["tempo"] == pytest.approx(90, rel=0.01)
    assert stage.transports[-1].get("pace") == pytest.approx(0.75, rel=0.01)


def test_a_clock_that_is_lost_leaves_its_tempo_and_a_line() -> None:
    stage = stage_following("midi")
    play(stage, anchors(steady(90), 10, 1 / 48, jitter=0.0), 30)
    assert lines(stage) == ["nothing is heard of the MIDI clock: the dance continues at 90.0 beats per minute"]
    assert errors(stage, steady(90))[-1] < 0.01
    stage.player.take(Anchor(START + 30, 45.0, 1.5, 0.02), stage.now)
    assert lines(stage)[1:] == ["the MIDI clock is heard again"]


def test_a_clock_that_stops_pauses_and_continues_only_its_own_pause() -> None:
    stage = stage_following("midi")
    play(stage, anchors(steady(120), 10, 1 / 48), 10)
    stands, again = Anchor(START + 10, 20.0, 0.0, 0.02), Anchor(START + 12, 0.0, 2.0, 0.02, 1)
    stage.player.take(stands, stage.now)
    assert (stage.states[-1], stage.transports[-1].get("waits_for")) == ("paused", ["the MIDI clock"])
    stage.run(2)
    stage.player.take(again, stage.now)
    assert stage.states[-1] == "paused", "it comes in at its own beat of the bar"
    stage.run(2.1)
    assert stage.states[-1] == "playing"
    assert abs(math.remainder(float(stage.player.run.beat(stage.now, math.inf)) - 4.2, 4)) < 0.01
    stage.player.take(replace(stands, at=stage.now), stage.now)
    stage.ask("pause")
    stage.player.take(replace(again, at=stage.now), stage.now)
    assert stage.states[-1] == "paused", "a person has paused it"
    stage.ask("stop")
    stage.player.take(replace(again, at=stage.now, jumps=2), stage.now)
    assert stage.states[-1] == "stopped"


@pytest.mark.parametrize("asked", ["a seek", "a save in a pause", "a resume"])
def test_what_a_person_asks_comes_in_at_the_beat_of_the_clock(asked: str) -> None:
    stage = stage_following("midi")
    phase = steady(120)
    told = anchors(phase, 20, 1 / 48, jitter=0.0)
    play(stage, [each for each in told if each.at < START + 10.3], 10.3)
    if asked == "a seek":
        stage.ask("seek", beat=101.5)
    else:
        stage.ask("pause")
    if asked == "a resume":
        stage.ask("resume")
    elif asked == "a save in a pause":
        later = replace(score(DANCE.replace("left", "left left")), clock=OutsideClock("midi"))
        stage.perform(later, 2, "now")
    assert (stage.states[-1], stage.transports[-1].get("waits_for")) == ("paused", ["the MIDI clock"])
    play(stage, [each for each in told if each.at >= START + 10.3], 20)
    assert stage.states[-1] == "playing"
    beat = float(stage.player.run.beat(stage.now, math.inf))
    assert math.remainder(beat - phase(20), 4) == pytest.approx(0, abs=0.01)
    assert (beat > 101) == (asked == "a seek")


def test_a_stop_counts_while_a_dance_waits_to_come_in() -> None:
    stage = stage_following("midi")
    play(stage, anchors(steady(120), 10, 1 / 48, jitter=0.0), 10)
    stage.ask("pause")
    stage.ask("resume")
    stage.ask("stop")
    stage.run(5)
    assert stage.states[-1] == "stopped"


TOO_SLOW = "r may be too slow from 120 beats per minute on, so it would leave its path"
TOO_FAST = "the dance plays from 12 to 480 beats per minute, so it can't keep up"


@pytest.mark.parametrize(
    ("fastest", "tempos", "said"),
    [
        (2.0, [90, 100, 110, 115, 125, 130, 100, 125], {115: TOO_SLOW, 125: TOO_SLOW}),
        (None, [110, 500, 110], {500: TOO_FAST}),
    ],
)
def test_a_tempo_at_which_robots_cannot_keep_up_is_reported(
    fastest: float | None, tempos: list[int], said: dict[int, str]
) -> None:
    stage = stage_following("midi", profile=Profile("cart", step=1, max_linear=fastest))
    play(stage, anchors(steady(tempos[0]), 5, 1 / 48), 5)
    for count, tempo in enumerate(tempos[1:]):
        stage.player.take(Anchor(stage.now, count * 4.0, tempo / 60, 0.02), stage.now)
        stage.run(1.5)
    assert lines(stage) == [f"the MIDI clock runs at {tempo}: {line}" for tempo, line in said.items()]


# The time of a simulation


def clock_of(rate: Callable[[float], float], until: float) -> list[Anchor]:
    """The anchors of a simulator's clock that makes this many seconds a second; it sends none while it stands."""
    at, passed, told = 0.0, 0.0, list[Anchor]()
    known: Estimate | None = None
    while at < until:
        passed += rate(at) * 0.01
        at += 0.01
        if rate(at):
            known = next(follow([Anchor(at, passed, 0.0, 0.01)], known))
            if known.is_known and (not told or at + START - told[-1].at >= 0.05):
                told.append(replace(known.anchor, at=at + START))
    return told


def test_a_simulator_at_half_speed_plays_at_half_speed_and_its_robots_get_their_own_velocities() -> None:
    stage = stage_following("ros")
    assert stage.states == ["paused"]
    play(stage, clock_of(lambda now: 0.5, 20), 20)
    apart = gaps(stage)
    assert apart[3:] == pytest.approx([1.0] * len(apart[3:]), abs=0.005)
    assert {round(twist.x, 6) for *_, twist in stage.sink.sent} == {0, 4}


def test_a_paused_simulator_pauses_and_what_a_person_has_stopped_stays() -> None:
    stage = stage_following("ros")
    told = clock_of(lambda now: 0.0 if 5 <= now < 8 else 1.0, 12)
    play(stage, [each for each in told if each.at < START + 6], 7)
    assert (stage.states[-1], stage.transports[-1].get("waits_for")) == ("paused", ["/clock"])
    assert lines(stage)[-1] == "paused until /clock continues"
    began = beats_of(stage)[0]
    assert stage.transports[-1]["beat"] == pytest.approx((5 - began) * 2, abs=0.05), "where the time stood still"
    play(stage, [each for each in told if each.at >= START + 6], 12)
    assert stage.states[-1] == "playing"
    again = [at for at in beats_of(stage) if at > 8]
    assert again[-1] - again[-2] == pytest.approx(0.5, abs=0.01)
    assert (again[-1] - 3 - began) * 2 % 1 == pytest.approx(0, abs=0.1), "the simulation has lost no time"
    stage.ask("stop")
    later = clock_of(lambda now: 1.0, 20)
    play(stage, [each for each in later if each.at >= START + 12], 20)
    assert stage.states[-1] == "stopped"


def test_the_dance_continues_from_where_it_is_when_the_time_of_a_simulation_jumps() -> None:
    stage = stage_following("ros")
    play(stage, clock_of(lambda now: 1.0, 5), 5)
    beat = stage.player.run.beat(stage.now, math.inf)
    stage.player.take(Anchor(stage.now, 700.0, 1.0, 0.01, jumps=1), stage.now)
    assert lines(stage)[-1] == "the time on /clock has jumped: the dance continues from where it is"
    assert stage.player.run.beat(stage.now, math.inf) == pytest.approx(beat)
    for tenth in range(1, 11):
        stage.run(0.1)
        stage.player.take(Anchor(stage.now, 700 + tenth / 10, 1.0, 0.01, jumps=1), stage.now)
    assert stage.player.run.beat(stage.now, math.inf) == pytest.approx(beat + 2, abs=0.01)


# The simulator beside real robots


def test_without_ros_nobody_waits_for_a_simulation() -> None:
    stage = Stage()
    stage.perform(replace(score(DANCE), clock=OutsideClock("ros")))
    stage.run(1)
    assert stage.states[-1] == "playing"


def test_the_stage_that_plays_behind_another_reports_its_delay_for_the_song_on_its_page() -> None:
    stage = Stage()
    stage.perform(score(DANCE), entry={"beat": 0.0, "monotonic": stage.now, "behind": 0.1})
    stage.run(1)
    assert stage.transports[-1].get("behind") == 0.1
    stage.perform(score(DANCE), 2, "restart")
    stage.run(1)
    assert "behind" not in stage.transports[-1]


def test_joints_move_by_our_time_and_at_the_pace_of_a_simulation() -> None:
    """Their positions count by our time: a joint in a simulation at half speed gets half as far in a second."""
    stage = stage_following("ros", "ada is puppet\nbeat 60\nada $ head repeat (left right)")
    play(stage, anchors(steady(30), 12, 0.05, jitter=0.0), 12)
    *_, joints = stage.sink.joints[-1]
    assert abs(joints["head_yaw"].velocity) == pytest.approx(math.radians(30) * 0.5, rel=0.01)
    assert stage.sink.paces[-1] == pytest.approx(0.5, rel=0.01)
