"""A dance that a person has stopped stays stopped until a person plays again, whatever else happens meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import pytest

from improv_core.music.osc_in import Situation, UnclearError, request
from improv_core.player import events
from improv_core.player.acts import Begin, DriveBack, Listen, Prepare, PrepareRestart, Resend
from improv_core.player.decide import decide
from improv_core.player.events import Event, Facts
from improv_core.player.run import Run
from improv_core.protocol import play_again
from improv_core.protocol.commands import AUTOMATIONS, COMMANDS, PageRequest
from improv_core.protocol.messages import FromStage, Load, Play
from improv_core.protocol.output import Edge, StopButton
from improv_core.safety.fault_monitor import RobotNews
from improv_core.safety.fault_rules import FaultBegan, Worst
from improv_core.safety.heartbeat import Parent
from improv_core.safety.separation import Near
from improv_core.score.faults import FaultRules
from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Deadman, Follow, OutsideClock, Safety
from improv_core.score.world import World
from improv_core.session.acts import Now, Send, SendScore
from improv_core.session.on_report import on_report
from improv_core.session.on_request import on_request
from improv_core.session.state import HERE, PlayScore, SessionState, StageKey
from improv_core.stage.loop import Loop, OpenedOutput
from tests.player.plays import to_play
from tests.player.test_player import Memory, score
from tests.session.story import READY

PROGRAM = "beat 60\nr $ repeat (forward left)"
STOP, DEADMAN = "/e_stop", Deadman("/joy", 4)
SAFETY = Safety(stop=STOP, deadman=DEADMAN, faults=FaultRules({"gone": "stop"}))
START = 1000.0
STEP = 0.4
"""Seconds between two events."""


class Performance:
    """A parent and its stage of real robots, without processes: requests take their real ways."""

    def __init__(self, follow: Follow | None = None) -> None:
        self.time = START
        self.robots = Memory()
        self.robots.real = True
        self.lines: list[str] = []
        self._situation, self._heard = Situation(), play_again.Heard()
        self._loop = Loop(OpenedOutput(self.robots, self._tell), self, Parent())
        self._state = on_report(SessionState(), StageKey(HERE, "ros"), READY["ros"], Now())[0].opened(["ros"])
        dance = replace(score(PROGRAM), safety=SAFETY)
        self._score = replace(dance, clock=OutsideClock(follow)) if follow else dance

    # The clock of the stage

    def now(self) -> float:
        return self.time

    def wall(self) -> float:
        return self.time

    def asleep(self) -> float:
        return 0.0

    def wait_until(self, now: float) -> None:
        self.time = max(self.time, now)

    # Events

    @property
    def state(self) -> str:
        return self._loop.player.run.mode

    def save(self) -> None:
        self._do(on_request(self._state, PlayScore(self._score, "dance.improv", 0), self._now))

    def ask(self, command: PageRequest) -> None:
        """Send a request from a page, an editor, a terminal, or OSC."""
        if COMMANDS[command["type"]].stops:
            self._take(command)
        self._do(on_request(self._state, command, self._now))

    def ask_on_node(self, command: PageRequest) -> None:
        """Send a request from a service or parameter of the stage's node."""
        if COMMANDS[command["type"]].at_once:
            self._take(command)
        if COMMANDS[command["type"]].stops:
            self._take(command)  # again, from the parent
        self._do(on_report(self._state, StageKey(HERE, "ros"), {"type": "request", "command": command}, self._now))

    def osc(self, address: str, *arguments: Any) -> None:
        try:
            command = request(f"/improv/{address}", arguments, self._situation)
        except UnclearError as error:
            self.lines.append(str(error))
        else:
            if command:
                self.ask(command)

    def call_play(self) -> None:
        reply = play_again.play(self._heard, "ros")
        if reply.request:
            self.ask_on_node(reply.request)

    def press(self, pressed: bool) -> None:
        self._loop.take(Edge(StopButton(STOP), pressed, self.time), self.time)

    def hold(self, held: bool) -> None:
        self._loop.take(Edge(str(DEADMAN), held, self.time), self.time)

    def hear_clock(self, rate: float) -> None:
        """Run a clock from outside at this many beats a second, or stop it."""
        self._loop.take(Anchor(self.time, self.time * rate, rate, 0.02, 0), self.time)

    def play(self) -> None:
        self.ask({"type": "resume"} if self.state == "paused" else {"type": "restart"})

    def passes(self, seconds: float = STEP) -> bool:
        """Let time pass. Return whether a robot is sent a movement meanwhile."""
        before, end = len(self.robots.sent), self.time + seconds
        while self.time < end:
            deadline = min(self._loop.deadline(self.time), end)
            self.time = max(self.time, deadline)
            self._loop.advance(self.time)
        return any(twist.x or twist.yaw for _, _, twist in self.robots.sent[before:])

    # The ways of requests

    @property
    def _now(self) -> Now:
        return Now(self.time, pressed=self._loop.player.run.stops.message)

    def _take(self, message: Any) -> None:
        self._loop.take(message.copy(), self.time)

    def _tell(self, message: FromStage) -> None:
        if message["type"] == "pressed":
            return
        if message["type"] == "warning" or message["type"] == "error":
            self.lines.append(message["message"])
        self._situation, self._heard = self._situation.after(message), self._heard.after(message)
        self._do(on_report(self._state, StageKey(HERE, "ros"), message, self._now))

    def _do(self, decided: tuple[SessionState, Sequence[Any]]) -> None:
        self._state, acts = decided
        for act in acts:
            if isinstance(act, Send):
                self._take(act.message)
            elif isinstance(act, SendScore):
                load: Load = {
                    "type": "load",
                    "generation": act.play.generation,
                    "score": {},
                    "when": act.play.when,
                    "backend": "memory",
                }
                if act.play.by:
                    load["by"] = act.play.by
                self._loop.take(Play(load, act.play.score), self.time)
                self._do(on_report(self._state, StageKey(HERE, "ros"), {"type": "loaded", "play": act.play}, self._now))


Does = Callable[[Performance], object]
A_PERSON: Mapping[str, Does] = {
    "a person stops": lambda it: it.ask({"type": "stop"}),
    "a person seeks beat 5": lambda it: it.ask({"type": "seek", "beat": 5.0}),
    "a person pauses": lambda it: it.ask({"type": "pause"}),
    "a person sets the speed": lambda it: it.ask({"type": "speed", "factor": 2.0}),
    "a person unmutes": lambda it: it.ask({"type": "silence", "muted": [], "soloed": []}),
    "a person holds the button": lambda it: it.hold(True),
    "a person lets the button go": lambda it: it.hold(False),
    "the emergency stop is pressed": lambda it: it.press(True),
    "the emergency stop is released": lambda it: it.press(False),
}
OSC: Mapping[str, Does] = {
    "OSC plays": lambda it: it.osc("play"),
    "OSC seeks beat 0": lambda it: it.osc("seek", 0),
    "OSC pauses": lambda it: it.osc("pause"),
    "OSC sets the tempo": lambda it: it.osc("tempo", 90),
    "OSC plays late": lambda it: it.ask({"type": "resume", "by": "osc"}),  # it had yet to receive the stop
    "OSC restarts late": lambda it: it.ask({"type": "restart", "by": "osc"}),
}
ROS: Mapping[str, Does] = {
    "ROS plays": lambda it: it.call_play(),
    "ROS pauses": lambda it: it.ask_on_node({"type": "pause"}),
    "ROS sets the speed": lambda it: it.ask_on_node({"type": "speed", "factor": 0.5}),
    "ROS plays late": lambda it: it.ask_on_node({"type": "resume", "by": "ros"}),
    "ROS restarts late": lambda it: it.ask_on_node({"type": "restart", "by": "ros"}),
}
STOPS: Mapping[str, Does] = {
    "OSC stops": lambda it: it.osc("stop"),
    "ROS stops": lambda it: it.ask_on_node({"type": "stop", "by": "ros"}),
}
CLOCK: Mapping[str, Does] = {
    "the clock runs": lambda it: it.hear_clock(1.5),
    "the clock stands": lambda it: it.hear_clock(0.0),
}
ALL = {**A_PERSON, **OSC, **ROS, **STOPS}


def every(kinds: Sequence[str], length: int) -> Iterator[str]:
    """A sequence that has each sequence of this length in it: de Bruijn's, from its Lyndon words."""
    word = [-1]
    while word:
        word[-1] += 1
        if length % len(word) == 0:
            yield from (kinds[each] for each in word)
        known = len(word)
        word = [word[each % known] for each in range(length)]
        while word and word[-1] == len(kinds) - 1:
            word.pop()


def dancing(follow: Follow | None = None) -> Performance:
    """A robot moves, because a person has played."""
    it = Performance(follow)
    it.hold(True)
    it.save()
    assert moves_again(it, follow)
    return it


def moves_again(it: Performance, follow: Follow | None) -> bool:
    """Return whether the robot moves at last: a clock has it wait for a bar."""
    for _ in range(10):
        if follow:
            it.hear_clock(1.5)
        if it.passes():
            return True
    return False


def test_the_sequence_has_each_triple() -> None:
    found = [*every("abcd", 3)]
    assert {*zip(found, found[1:], [*found[2:], *found[:2]], strict=False)} >= {*product("abcd", repeat=3)} - {
        ("d", "d", "a"),
        ("d", "a", "a"),
    }


@pytest.mark.parametrize("follow", [None, "midi", "ros"])
def test_after_a_stop_no_pair_and_no_triple_of_anything_but_a_play_of_a_person_moves_a_robot(
    follow: Follow | None,
) -> None:
    it = dancing(follow)
    it.ask({"type": "stop"})
    it.passes()
    kinds = [*ALL, *CLOCK] if follow else [*ALL]
    done = ["a person stops"]
    for kind in every(kinds, 2 if follow else 3):
        {**ALL, **CLOCK}[kind](it)
        done.append(kind)
        assert not it.passes(), done[-6:]
    it.press(False)
    it.hold(True)
    it.play()
    assert moves_again(it, follow), it.lines[-3:]


@pytest.mark.parametrize("stop", ["a person stops", "the emergency stop is pressed"])
@pytest.mark.parametrize("first", ALL)
def test_each_pair_right_after_a_stop_and_then_a_person_plays(stop: str, first: str) -> None:
    for second in ALL:
        it = dancing()
        for kind in (stop, first, second):
            ALL[kind](it)
            it.passes(0.01)
            assert not it.passes(), (stop, first, second)
        it.press(False)
        it.hold(True)
        it.play()
        assert it.passes(), it.lines


@pytest.mark.parametrize(
    ("story", "moves"),
    [
        (["OSC stops", "OSC plays"], True),
        (["OSC stops", "OSC seeks beat 0", "OSC plays"], True),
        (["OSC stops", "a person seeks beat 5", "OSC plays"], True),
        (["OSC stops", "OSC stops", "OSC plays"], True),
        (["ROS stops", "ROS plays"], True),
        (["OSC pauses", "ROS plays"], True),
        (["a person pauses", "OSC plays"], True),
        (["OSC stops", "ROS plays"], False),
        (["OSC stops", "ROS stops", "OSC plays"], False),
        (["OSC stops", "a person stops", "OSC plays"], False),
        (["a person pauses", "a person stops", "ROS plays"], False),
        (["OSC stops", "the emergency stop is pressed", "the emergency stop is released", "OSC plays"], False),
    ],
)
def test_automations_play_again_what_only_they_have_stopped(story: Sequence[str], moves: bool) -> None:
    it = dancing()
    for kind in story:
        it.passes()
        ALL[kind](it)
    assert it.passes() == moves, it.lines


def test_automations_play_again_after_a_person_has_played() -> None:
    it = dancing()
    it.ask({"type": "stop"})
    it.save()
    assert it.passes()
    it.osc("stop")
    it.osc("play")
    assert it.passes()


def test_an_automation_that_is_refused_learns_why() -> None:
    it = dancing()
    it.ask({"type": "stop"})
    it.osc("play")
    assert it.lines == [f"/improv/play: {play_again.STOPPED}"]
    assert play_again.play(it._heard, "ros") == (None, False, play_again.STOPPED)
    it.ask({"type": "restart", "by": "osc"})
    assert it.lines[1:] == [play_again.STOPPED]


def test_a_stage_on_which_no_person_has_played_is_not_started_by_automations() -> None:
    """Such as one that has replaced a stage that died while everything was stopped."""
    it = Performance()
    it.hold(True)
    load: Load = {"type": "load", "generation": 7, "score": {}, "when": "restart", "backend": "memory", "by": "osc"}
    it._loop.take(Play(load, it._score), it.time)
    assert (it.passes(), it.lines) == (False, [play_again.STOPPED])


# The player's decisions

DANCE = replace(score(PROGRAM), safety=SAFETY, world=World(keep_apart=0.2))
MOVES = (Begin, Resend, DriveBack, Listen, Prepare, PrepareRestart)


@pytest.mark.parametrize(
    "stop",
    [
        {"type": "stop"},
        events.EmergencyStop(STOP, True),
        events.Stalled(1.0),
        events.Overloaded(),
        events.Faults([RobotNews("r", FaultBegan("gone", Worst()))]),
        events.TooNear([Near(("r", "s"), 0.1)]),
    ],
    ids=lambda event: type(event).__name__,
)
def test_automations_may_start_nothing_after_a_stop_that_is_not_theirs(stop: Event) -> None:
    run = Run("playing", DANCE, DANCE, generation=1, restarted=1)
    playing = replace(run, transport=replace(run.transport, zero=START, tempo=DANCE.tempo))
    facts = Facts(START + 2.0, real=True, over=8, held=frozenset({str(DEADMAN)}))
    stopped, _ = decide(playing, stop, facts)
    stopped, _ = decide(stopped, events.EmergencyStop(STOP, False), facts)
    assert (stopped.mode in ("stopped", "paused"), [*stopped.startable_by]) == (True, [])
    for by in AUTOMATIONS:
        starts: list[Event] = [{"type": "resume", "by": by}, to_play(DANCE, 2, "restart", by=by)]
        for event in [*starts, to_play(DANCE, 2, "now", by=by)]:
            then, acts = decide(stopped, event, facts)
            assert (then.mode, [act for act in acts if isinstance(act, MOVES)]) == (stopped.mode, [])
