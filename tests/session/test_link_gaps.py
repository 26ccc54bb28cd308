"""A dance on several machines whose links fall silent: the real loops of stages with the real rules of the group, on
one clock, with links that delay all messages."""

from __future__ import annotations

import heapq
import json
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import pytest

from improv_core.ipc.arrivals import First
from improv_core.protocol.commands import is_stop
from improv_core.protocol.decoding import read_as
from improv_core.protocol.messages import FromStage, Play, State, read_first
from improv_core.protocol.output import Alarm
from improv_core.safety.heartbeat import PING_PERIOD, Parent
from improv_core.score.motion import STILL
from improv_core.score.score_json import RowsRead
from improv_core.session.on_hosts import due, in_time
from improv_core.session.state import HERE, StageKey
from improv_core.stage.loop import Loop, OpenedOutput
from improv_core.stage.stdio import arrival
from tests.player.test_player import Memory
from tests.session.test_group import PAD, PI, Say, SendTo, Story

START = 1000.0
DANCE = "beat 240\na o q $ repeat forward\n"
EDIT = "beat 240\na o q $ repeat left\n"
SETTLED = 3.0
"""Seconds after the last event within which everything has settled."""


@dataclass(frozen=True)
class Gap:
    """The times between which nothing passes between here and a host, in seconds from the start."""

    host: str
    begins: float
    ends: float


class Machine:
    def __init__(self, clock: World, host: str) -> None:
        self.sink, self.parent, self.read = Memory(), Parent(), RowsRead()
        self.sink.real = True
        self.loop = Loop(OpenedOutput(self.sink, lambda message: clock.comes_up(host, message)), clock, self.parent)
        self.number = self.before = 0  # as in `Stage`

    @property
    def moves(self) -> bool:
        return bool(self.sink.sent) and self.sink.sent[-1][2] != STILL


class World:
    """All machines, the links between them, and the clock. `says` has the messages to people and pages."""

    def __init__(self, hosts: Sequence[str], gaps: Sequence[Gap] = (), seed: int = 0) -> None:
        self._now, self._count, self._dice = START, 0, random.Random(seed)
        self._coming: list[tuple[float, int, Callable[[], None]]] = []
        self._latest: dict[str, float] = {}  # when the latest message of a channel arrives
        self._gaps = gaps
        self.says: list[Any] = []
        self.machines = {host: Machine(self, host) for host in hosts}
        self.story = Story(*hosts)
        for host in hosts:
            self._ping(host)

    def now(self) -> float:
        return self._now

    def wall(self) -> float:
        return self._now

    def asleep(self) -> float:
        return 0.0

    def wait_until(self, now: float) -> None:
        self._now = max(self._now, now)

    @property
    def beats(self) -> list[float]:
        players = [machine.loop.player for machine in self.machines.values()]
        return [float(player.run.beat(self._now, player._tracks.active_parts.over)) for player in players]

    @property
    def moving(self) -> list[str]:
        return [host for host, machine in self.machines.items() if machine.moves]

    def ask(self, kind: str, **fields: Any) -> None:
        message: Any = {"type": kind, **fields}
        self.story.now = self._now
        if is_stop(message):
            timed = in_time(self.story.state, message, self.story.times())
            for host in self.machines:
                self._send(host, timed)
        self.story.told(kind, **fields)
        self._do()

    def play(self, program: str = DANCE, when: str = "restart", **fields: Any) -> None:
        self.story.now = self._now
        self.story.plays(program, when=when, **fields)
        self._do()

    def does(self, dice: random.Random) -> None:
        """Do something as a person, or have a stage stop its robots by itself."""
        kind = dice.choice(("stop", "pause", "resume", "seek", "speed", "save", "save", "play", "alarm"))
        if kind == "save":
            self.play(dice.choice((DANCE, EDIT)), dice.choice(("now", "beat", "bar")))
        elif kind == "alarm":
            machine = dice.choice([*self.machines.values()])
            self._take(machine, Alarm("its standby has died"))
        elif kind == "play":
            self.play()
            self.run(0.5)  # a request in the moment in which it begins is another story
        else:
            fields: dict[str, Any] = {"seek": {"beat": 20.0}, "speed": {"factor": 1.5}}.get(kind, {})
            self.ask(kind, **fields)

    def run(self, seconds: float) -> None:
        end = self._now + seconds
        while True:
            dues = [(machine.loop.deadline(self._now), machine) for machine in self.machines.values()]
            runs, machine = min(dues, key=lambda each: each[0])
            comes = self._coming[0][0] if self._coming else math.inf
            self.story.now = self._now
            waited = due(self.story.state, self.story.times())
            at = min(runs, comes, waited)
            if at > end:
                break
            self._now = max(self._now, at)
            if comes <= at:
                heapq.heappop(self._coming)[2]()
            elif runs <= at:
                machine.loop.advance(self._now)
            else:
                self.story.now = self._now
                self.story.wakes()
                self._do()
        self._now = end

    def comes_up(self, host: str, message: Any) -> None:
        """Take a message from a stage. A stage whose robots stopped in a gap keeps them still until it gets a score
        again."""
        assert not (message.get("deserted") and message["state"] in ("playing", "waiting"))
        if message["type"] != "pong":
            line = json.dumps(message).encode()
            self._pass(host, "up", lambda: self._hear(host, line))

    def _hear(self, host: str, line: bytes) -> None:
        self.story.now = self._now
        self.story.reports(StageKey(host, "ros"), read_as(line, FromStage))
        self._do()

    def _do(self) -> None:
        for act in self.story.acts:
            if isinstance(act, SendTo):
                self._send(act.host, act.message)
            elif isinstance(act, Say):
                self.says.append(act.message)

    def _send(self, host: str, message: Any) -> None:
        machine = self.machines[host]
        if is_stop(message):
            self._send_first(host, message)
            return
        if message["type"] in ("load", "resume"):
            self._send_first(host, {"type": "ping"})
        line = json.dumps({**message, "after": machine.before}).encode()
        self._pass(host, "lines", lambda: self._take(machine, arrival(line, machine.read)))

    def _send_first(self, host: str, message: Any) -> None:
        machine = self.machines[host]
        machine.number = machine.before = machine.number + 1
        first = First(*read_first(json.dumps({**message, "number": machine.number}).encode()))

        def take() -> None:
            machine.parent.speaks(self._now, pings=first.message["type"] == "ping")
            self._take(machine, first)

        self._pass(host, "stops", take)

    def _take(self, machine: Machine, arrived: Any) -> None:
        machine.loop.take(arrived, self._now)
        if self._now >= machine.loop.deadline(self._now):
            machine.loop.advance(self._now)

    def _ping(self, host: str) -> None:
        self._send_first(host, {"type": "ping"})
        self._at(self._now + PING_PERIOD, lambda: self._ping(host))

    def _pass(self, host: str, channel: str, arrive: Callable[[], None]) -> None:
        """Have a message arrive after a while, behind all others on its channel."""
        at = self._now if host == HERE else self._now + self._dice.choice((0.001, 0.01, 0.03))
        for gap in self._gaps:
            if gap.host == host and START + gap.begins <= at < START + gap.ends:
                at = START + gap.ends + self._dice.choice((0.001, 0.05, 0.3))
        at = max(at, self._latest.get(host + channel, at))
        self._latest[host + channel] = at
        self._at(at, arrive)

    def _at(self, at: float, work: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._coming, (at, self._count, work))


def states(world: World) -> list[str]:
    return [each["state"] for each in world.says if each["type"] == "transport"]


HOSTS = ((HERE, PI), (PI, PAD), (HERE, PI, PAD))


def agree(world: World) -> None:
    """Check that all dance at the same beat, or all stand, and that the group and people know which."""
    assert world.moving == ([*world.machines] if world.story.state.mode == "playing" else [])
    assert (states(world)[-1] == "playing") == bool(world.moving)
    if world.moving:
        assert max(world.beats) - min(world.beats) < 0.1


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("length", [0.3, 0.6, 0.8, 1.0])
@pytest.mark.parametrize("hosts", HOSTS)
def test_after_a_gap_all_dance_at_the_same_beat(hosts: Sequence[str], length: float, seed: int) -> None:
    world = World(hosts, [Gap(PI, 2.0, 2.0 + length)], seed)
    world.play()
    world.run(2 + length + SETTLED)
    assert world.story.state.mode == "playing"
    assert "stopped" not in states(world)
    agree(world)


def test_a_dance_that_an_automation_restarts_survives_a_gap_too() -> None:
    world = World((HERE, PI), [Gap(PI, 2.0, 2.9)])
    world.play()
    world.run(1.0)
    world.ask("stop", by="osc")
    world.run(0.2)
    world.play(by="osc")
    world.run(SETTLED)
    assert world.story.state.mode == "playing"
    agree(world)


@pytest.mark.parametrize("seed", range(40))
def test_no_robot_dances_alone_after_any_requests_in_gaps(seed: int) -> None:
    dice = random.Random(seed)
    hosts = dice.choice(HOSTS)
    gaps = [Gap(dice.choice(hosts[1:]), 2.0, 2.0 + dice.uniform(0.3, 1.5)) for _ in range(dice.choice((1, 2)))]
    world = World(hosts, gaps, seed)
    world.play()
    world.run(2.0)
    for _ in range(dice.randrange(6)):
        world.run(dice.choice((0.0, 0.01, 0.1, 0.5, 0.8)))
        world.does(dice)
    world.run(SETTLED)
    agree(world)


def entering() -> Story:
    """PI has been sent the score of the others, after a gap, and has yet to play it."""
    story = Story.playing()
    story.now += 1.0
    story.said(PI, "deserted", seconds=0.5)
    assert story.is_at(PI, "stopped", 1.0, deserted=True) == []
    assert story.state.entering == {PI: 1}
    return story


def test_a_stage_that_enters_after_a_gap_plays_once_it_reports_that() -> None:
    story = entering()
    assert story.said(PI, "lacks", generation=1) == [], "it was sent all already"
    assert story.is_at(PI, "playing", 2.0) == []
    assert story.is_at(PI, "stopped", 3.0) == ["here: stop", f"{PAD}: stop", "say stopped"]


def test_a_stage_that_cannot_enter_after_a_gap_stops_all() -> None:
    assert entering().is_at(PI, "stopped", 1.0) == ["here: stop", f"{PAD}: stop", "say stopped"]


def test_a_stage_that_has_entered_after_a_gap_stops_all_although_it_has_yet_to_take_over_a_save() -> None:
    story = entering()
    story.plays(when="end")
    assert story.is_at(PI, "playing", 2.0, generation=1) == []
    assert story.said(PI, "lacks", generation=2) == [], "nobody plays that yet, so it waits for the others"
    assert story.state.joining == {PI}
    story = entering()
    story.plays(when="end")
    assert story.is_at(PI, "stopped", 1.0, generation=1) == ["here: stop", f"{PAD}: stop", "say stopped"]


def test_a_stage_about_to_enter_after_a_gap_stops_if_the_dance_ends_meanwhile() -> None:
    assert entering().is_at(HERE, "ended", 20.0) == ["say ended", f"{PI}: stop"]
    story = entering()
    story.said(HERE, "gone", message="it was killed")
    assert f"{PI}: stop" in story.said(PAD, "gone", message="it was killed")


def test_a_stage_that_moves_although_all_have_stopped_is_stopped_again() -> None:
    story = Story.playing()
    story.told("stop")
    assert story.is_at(PI, "playing", 1.0) == [], "it has yet to hear of the stop"
    story.is_at(PI, "stopped", 1.0)
    assert story.is_at(PI, "playing", 1.0) == [f"{PI}: stop"]


def test_a_new_stage_stops_robots_that_moved_when_the_one_before_died() -> None:
    story = Story.playing()
    story.said(PI, "gone", message="it hung")
    story.told("stop")
    story.starts(PI)
    assert story.words == [f"{PI}: load"]
    play = arrival(json.dumps(story.sent(PI)[0]).encode(), RowsRead())
    assert isinstance(play, Play)
    assert not play.score.moves
    assert play.score.on(PI).parts.keys() >= {"p", "q"}
    story.is_at(HERE, "stopped", 1.0)
    story.said(HERE, "gone", message="it hung")
    states: tuple[State, ...] = ("waiting", "playing", "ended")
    for state in states:
        assert story.is_at(PI, state) == [], "nothing plays"
    story.said(PI, "gone", message="it hung")
    story.starts(PI)
    assert story.words == [], "it had stopped them"


def test_people_hear_of_another_stage_that_leads_while_the_one_that_did_is_away() -> None:
    story = Story.playing(PI, PAD)
    story.now += 1.0
    story.is_at(PI, "playing", 2.0)
    assert story.said(PAD, "deserted", seconds=0.5)[1:] == ["say playing", f"{PAD}: load"]


@pytest.mark.parametrize("hosts", [(PI,), (HERE, PI)])
def test_robots_of_the_stage_that_dies_last_are_stopped_by_the_next_one(hosts: Sequence[str]) -> None:
    story = Story.playing(*hosts)
    story.said(PI, "deserted", seconds=0.5)
    story.said(hosts[0], "gone", message="it was killed")
    assert story.state.mode == "stopped"
    assert story.starts(hosts[0]) == [f"{hosts[0] or 'here'}: load"]
    assert not any(part["scenes"] for part in story.sent(hosts[0])[0]["score"]["parts"].values())
