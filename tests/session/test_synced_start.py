"""Stages on several machines that follow a clock, which only their parent hears: news of the clock → messages to
all."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import pytest

from improv_core.score.peer_clock import MAX_BENT
from improv_core.score.score import Follow, OutsideClock
from improv_core.session import clock
from improv_core.session.state import HERE
from improv_core.session.together import SPARE
from tests.player.plays import to_play
from tests.player.test_player import Stage, score
from tests.session.test_group import NOW, PI, Say, SendTo, Story, on_hosts

TEXT = "beat 120\na p $ repeat forward\n"
AWAITED = "say the dance begins at the next bar of the MIDI clock, once it is heard"
BOTH = ["here: {0}", PI + ": {0}"]


def loaded(follow: Follow = "midi", **fields: Any) -> Story:
    """A stage here and one on a host have been sent a score that follows a clock."""
    story = Story(HERE, PI)
    story.plays(replace(on_hosts(TEXT), clock=OutsideClock(follow)), **fields)
    return story


def ready(**fields: Any) -> Story:
    """All are ready for beat 0."""
    story = loaded(**fields)
    for host in (HERE, PI):
        story.said(host, "armed", generation=1, armed=True, begins=None)
    return story


def hear(story: Story, beat: float, tempo: float = 120.0) -> list[str]:
    """Return the acts that follow if the clock is at a beat now."""
    return story.told("anchor", at=story.now, beat=beat, tempo=tempo, period=0.02, jumps=0)


def both(*kinds: str) -> list[str]:
    return [line.format(kind) for kind in kinds for line in BOTH]


def playing(beat: float = 0.0, tempo: float = 120.0) -> Story:
    """All have begun, with the clock, and are at this beat."""
    story = ready()
    hear(story, 0.0, tempo)
    story.waits()
    story.now = NOW + 10
    for host in (HERE, PI):
        story.is_at(host, "playing", beat)
    return story


def instants(story: Story) -> set[float]:
    return {act.message["at"] for act in story.acts if isinstance(act, SendTo)}  # type: ignore[typeddict-item]


def test_no_stage_gets_the_clock_and_no_line_reports_that() -> None:
    story = loaded()
    assert [story.sent(host)[0]["score"]["clock"] for host in (HERE, PI)] == [None, None]
    assert not any(isinstance(act, Say) for act in story.acts)
    line = "say stages on other machines don't follow the time of a simulation: the program's tempo counts"
    assert loaded("ros").words[0] == line


def test_beat_0_is_at_the_next_bar_of_the_clock_for_all() -> None:
    story = ready()
    assert story.words == ["say armed", AWAITED]
    story.now += 5
    assert hear(story, 6.0, tempo=90.0) == [], "it is soon enough to tell them later"
    assert story.waits() == both("bend", "resume")
    zero = NOW + 5 + 2 * 60 / 90
    assert [story.sent(host)[1]["at"] for host in (HERE, PI)] == [pytest.approx(zero)] * 2
    assert story.sent(PI)[0]["pace"] == pytest.approx(0.75)


def test_an_armed_dance_begins_at_the_next_bar_or_at_once_without_a_clock() -> None:
    story = ready(arming={})
    assert story.words == ["say armed"]
    hear(story, 3.0)
    assert story.words == []
    story.told("resume")
    assert (story.words or story.waits()) == both("bend", "resume")
    assert story.sent(PI)[1]["at"] == pytest.approx(NOW + 0.5)
    silent = ready(arming={})
    assert silent.told("resume") == both("resume")
    assert instants(silent) == {NOW + SPARE}


def test_all_bend_at_one_instant_and_alike() -> None:
    story = playing(beat=20.0)
    assert hear(story, 20.0) == [], "they are where it is"
    story.now += clock.LOOK
    assert hear(story, 20.6) == both("bend")
    assert instants(story) == {story.now + SPARE}
    assert story.sent(HERE) == story.sent(PI)
    bend = story.sent(PI)[0]
    assert (bend["beat"], bend["pace"]) == (pytest.approx(20 + 2 * (0.25 + SPARE)), pytest.approx(1 + MAX_BENT))
    story.now += 0.1
    assert hear(story, 20.8) == [], "not all the time"


def test_a_clock_that_stands_pauses_all_and_they_come_in_when_it_is_at_their_beat_again() -> None:
    story = playing(beat=20.0)
    story.now += 1
    assert hear(story, 22.0, tempo=0.0) == [*both("pause"), "say paused until the MIDI clock continues"]
    assert instants(story) == {story.now + SPARE}
    for host in (HERE, PI):
        story.is_at(host, "paused", 22.5)
    story.now += 10
    hear(story, 21.0)
    assert (story.words or story.waits()) == both("bend", "resume")
    assert story.sent(PI)[1]["at"] == pytest.approx(NOW + 21 + 0.75)
    assert story.state.mode == "playing"


def test_a_seek_while_all_wait_for_their_beat_changes_that_beat() -> None:
    story = playing(beat=20.0)
    hear(story, 20.0, tempo=0.0)
    for host in (HERE, PI):
        story.is_at(host, "paused", 20.0)
    story.now += 10
    hear(story, 5.0)
    assert story.told("seek", beat=13.0) == both("seek")
    for host in (HERE, PI):
        story.is_at(host, "paused", 13.0)
    assert story.waits() == both("bend", "resume")
    assert story.sent(PI)[1]["at"] == pytest.approx(NOW + 20 + 4 / 2), "the second beat of a bar"


@pytest.mark.parametrize("kind", ["pause", "stop"])
def test_only_a_person_continues_a_dance_that_a_person_paused_or_stopped(kind: str) -> None:
    story = playing(beat=20.0)
    hear(story, 20.0, tempo=0.0)
    story.is_at(HERE, "paused", 20.0)
    story.told(kind)
    story.now += 1
    assert hear(story, 20.0) == []
    assert (story.state.mode, story.state.enters) == ("paused" if kind == "pause" else "stopped", math.inf)
    if kind == "pause":
        hear(story, 22.0, tempo=0.0)
        assert story.told("resume") == [], "the clock stands: all wait for it"
        hear(story, 20.0)
        assert (story.words or story.waits())[-2:] == both("resume")


def test_a_stop_while_they_wait_for_their_beat_begins_nothing() -> None:
    story = ready()
    hear(story, 1.0, tempo=60.0)
    assert story.state.enters == NOW + 3
    story.told("stop")
    story.now += 2.5
    assert hear(story, 3.5, tempo=60.0) == []
    story.wakes()
    assert not any(isinstance(act, SendTo) for act in story.acts)


def test_a_stage_that_stops_while_they_wait_for_their_beat_begins_nothing() -> None:
    story = ready()
    hear(story, 1.0, tempo=60.0)
    story.is_at(PI, "stopped")
    story.now += 2.5
    story.wakes()
    assert not any(isinstance(act, SendTo) for act in story.acts)


NEAR: Any = {"too_near": ["a", "p"]}


def goes_on_by_itself(story: Story) -> bool:
    """Return whether robots move again although no person has resumed."""
    story.is_at(HERE, "paused", 22.0)
    for _ in range(50):
        story.now += 0.1
        hear(story, 20 + 2 * (story.now - NOW - 10))
        told = list(story.acts)
        story.wakes()
        if any(isinstance(act, SendTo) and act.message["type"] in ("resume", "seek") for act in [*told, *story.acts]):
            return True
    return False


def test_robots_too_near_to_each_other_wait_for_a_person_also_if_the_clock_stands_then() -> None:
    story = playing(beat=20.0)
    story.now += 1
    hear(story, 22.0, tempo=0.0)
    story.is_at(PI, "paused", 22.0, **NEAR)
    assert not goes_on_by_itself(story)


def test_robots_too_near_to_each_other_wait_for_a_person_also_after_one_came_in_at_once() -> None:
    story = playing(beat=20.0)
    story.told("pause")
    story.is_at(HERE, "paused", 20.0)
    hear(story, 21.9)
    story.told("resume")
    assert story.told("resume", anyway=True)[-2:] == both("resume")
    for host in (HERE, PI):
        story.is_at(host, "playing", 20.0)
    story.now += 3
    story.is_at(PI, "paused", 26.0, **NEAR)
    assert not goes_on_by_itself(story)


def test_an_armed_dance_that_is_no_longer_ready_waits_for_a_person_again() -> None:
    story = ready(arming={})
    hear(story, 1.0, tempo=60.0)
    story.told("resume")
    for armed in (False, True):
        story.said(PI, "armed", generation=1, armed=armed, begins=None)
    assert (story.state.mode, story.state.enters) == ("armed", math.inf)


def test_a_person_who_begins_while_the_clock_stands_waits_for_it() -> None:
    story = ready(arming={})
    hear(story, 0.0, tempo=0.0)
    assert story.told("resume") == []
    story.now += 1
    assert hear(story, 0.0) == both("bend", "resume") or story.waits() == both("bend", "resume")


def test_older_news_does_not_undo_a_seek() -> None:
    story = playing(beat=20.0)
    story.now += 1
    assert story.told("seek", beat=4.0) == both("seek")
    story.now += SPARE
    assert hear(story, 24.0) == []


def test_a_lost_clock_leaves_its_tempo_and_is_reported_once() -> None:
    story = playing(beat=20.0)
    hear(story, 20.0)
    said = [*story.waits(), *story.waits(), *story.waits()]
    assert [each for each in said if "say" in each] == [
        "say nothing is heard of the MIDI clock: the dance continues at 120.0 beats per minute"
    ]
    story.now += 1
    assert hear(story, 26.0)[0] == "say the MIDI clock is heard again"


def test_a_host_that_joins_has_the_pace_of_the_others() -> None:
    story = playing(beat=20.0)
    for host in (HERE, PI):
        story.is_at(host, "playing", 20.0, pace=1.1)
    story.said(PI, "gone", message="it was rebooted")
    story.starts(PI)
    assert story.sent(PI)[0]["entry"]["pace"] == 1.1


DELAY = 0.08
"""Seconds that every message takes."""


class Dance:
    """Two stages with real players, which a parent directs by the clock."""

    def __init__(self, phase: Callable[[float], float]) -> None:
        self.phase = phase
        self.story = loaded()
        self.story.said(PI, "link", host=PI, offset=0.0, error=0.0, round_trip=2 * DELAY, lag=DELAY)
        self.stages = {host: Stage(NOW) for host in (HERE, PI)}
        self.due: list[tuple[float, int, Callable[[], Any]]] = []
        self.heard = dict.fromkeys(self.stages, 0)
        self.number = 0
        for host, stage in self.stages.items():
            stage.player.take(to_play(score(TEXT), 1, "restart"), NOW)
            self.report(host, NOW)

    def at(self, when: float, what: Callable[[], Any]) -> None:
        self.number += 1
        heapq.heappush(self.due, (when, self.number, what))

    def send(self) -> None:
        for act in self.story.acts:
            if isinstance(act, SendTo) and act.message["type"] == "bend":
                bend = act.message
                stage = self.stages[act.host]
                when = max(bend["at"], self.story.now + DELAY)
                self.at(when, partial(stage.player.take, bend, when))

    def report(self, host: str, now: float) -> None:
        """Pass a stage's messages on to the parent."""
        told = self.stages[host].transports
        for each in told[self.heard[host] :]:
            message: dict[str, Any] = {**each}
            self.at(now + DELAY, partial(self.story.said, host, message.pop("type"), **message))
        self.heard[host] = len(told)

    def play(self, seconds: float) -> None:
        self.story.state = replace(self.story.state, mode="playing", since=NOW)
        for number in range(round(seconds * 10)):
            self.at(NOW + number / 10, lambda: None)
        while self.due and self.due[0][0] < NOW + seconds:
            when, _, what = heapq.heappop(self.due)
            self.story.now = when
            for stage in self.stages.values():
                stage.run(when - stage.now)
            what()
            phase, rate = self.phase(when - NOW), self.phase(when - NOW + 0.5) - self.phase(when - NOW - 0.5)
            self.story.told("anchor", at=when, beat=phase, tempo=60 * rate, period=0.1, jumps=0)
            self.send()
            for host in self.stages:
                self.report(host, when)

    def beats(self, now: float) -> list[float]:
        return [float(stage.player.run.beat(now, float("inf"))) for stage in self.stages.values()]


@pytest.mark.parametrize(
    "phase",
    [lambda t: 2.1 * t, lambda t: 1.5 * t + 0.2, lambda t: 2 * t + 0.004 * t * t],
    ids=["faster", "slower", "an accelerando"],
)
def test_all_keep_together_and_with_the_clock(phase: Callable[[float], float]) -> None:
    dance = Dance(phase)
    dance.play(20)
    here, there = dance.beats(NOW + 20)
    assert here == there
    assert abs((here - phase(20) + 2) % 4 - 2) / 2 < 0.015
