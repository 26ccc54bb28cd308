"""A stage's reactions to arrivals, on a clock that the tests advance."""

from __future__ import annotations

import json
import math
import queue
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import pytest

from improv_core.ipc.arrivals import Arrival, End, First
from improv_core.page.answers import Answers
from improv_core.page.broadcast import Broadcast
from improv_core.page.open_pages import Pages
from improv_core.player.start_rules import WAITS
from improv_core.player.subscribers import PATIENCE
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import Force, Held, KeySense, Released, Seek, Speed, Stop
from improv_core.protocol.drawn import Snapshot
from improv_core.protocol.limits import DEADMAN_LIMIT, LOADING_LIMIT, SILENCE_LIMIT
from improv_core.protocol.messages import FromStage, Load, Ping, Play, RobotsSeen, SeenRobot, When
from improv_core.protocol.output import Alarm, Edge, RawPose, RawPoses
from improv_core.protocol.page_messages import ForPages, MeetingsMessage, ShownScore
from improv_core.protocol.robot_messages import FaultMessage, Instant
from improv_core.safety.heartbeat import Parent
from improv_core.safety.interlocks import OLDER
from improv_core.score.faults import Response
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.peer_clock import Anchor
from improv_core.score.profiles import TURTLEBOT4
from improv_core.score.score import Deadman, Host, OutsideClock, Safety, Score
from improv_core.score.score_json import RowsRead, to_json
from improv_core.score.senses import Key, RobotSense
from improv_core.score.world import World
from improv_core.stage.loop import OpenedOutput, run
from improv_core.stage.stdio import arrival
from tests.player.test_player import Memory, score

START = 1000.0
PING: Ping = {"type": "ping", "number": 1}
HELD: Held = {"type": "held"}
RELEASED: Released = {"type": "released"}


def load(program: str) -> Play:
    message: Load = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "memory"}
    return Play(message, score(program))


@dataclass(frozen=True)
class FromRos:
    """An arrival that doesn't come through the stage's own input."""

    arrival: Arrival


class Reading:
    """A long line has arrived, and the reader is busy with it."""


Event = Arrival | FromRos | Reading


class Turned:
    """A clock, and the inbox of a stage that turns it: everything arrives at its time, in seconds from the start.

    From `sleeps_at` on, the machine has slept for half a minute. A busy one wakes the stage `late` seconds late.
    """

    def __init__(self, arrivals: Sequence[tuple[float, Event]], sleeps_at: float = math.inf, late: float = 0.0) -> None:
        self._arrivals = list(arrivals)
        self._now = START
        self._sleeps_at = START + sleeps_at
        self._late = late
        self._has_channel = any(isinstance(each, First) for _, each in arrivals)
        self.parent = Parent()

    def asleep(self) -> float:
        return 1030.0 if self._now >= self._sleeps_at else 1000.0

    def now(self) -> float:
        return self._now

    def wall(self) -> float:
        return 0.0

    def wait_until(self, now: float) -> None:
        self._now = max(self._now, now + self._late)

    def get(self, *, timeout: float | None) -> Arrival:
        at, next_one = self._arrivals[0]
        end = math.inf if timeout is None else self._now + timeout
        self._now = max(self._now, min(START + at, end))
        if START + at > end:
            raise queue.Empty
        del self._arrivals[0]
        if isinstance(next_one, FromRos):
            return next_one.arrival
        if isinstance(next_one, Reading):
            self.parent.reading(self._now)
            return self.get(timeout=None if timeout is None else end - self._now)
        if isinstance(next_one, First):
            self.parent.speaks(self._now, pings=next_one.message == PING)
        elif not self._has_channel:
            self.parent.speaks(self._now, pings=next_one == PING)
        return next_one


class Slow(Memory):
    """It needs two seconds to prepare a score, and then a moment until beat 0."""

    def prepare(self, score: Score, restart: bool) -> None:
        super().prepare(score, restart)
        self.resets = True
        self.turned.wait_until(self.turned.now() + 2)

    def resetting(self, homing: Collection[str] = ()) -> bool:
        resets, self.resets = self.resets, False
        return resets

    turned: Turned


def perform(
    sink: Memory, *arrivals: tuple[float, Event], real: bool = True, sleeps_at: float = math.inf, late: float = 0.0
) -> list[FromStage]:
    """Return the messages of a stage until the last of the arrivals has ended it."""
    sink.real = real
    told: list[FromStage] = []
    turned = Turned(arrivals, sleeps_at, late)
    if isinstance(sink, Slow):
        sink.turned = turned
    run(OpenedOutput(sink, told.append), turned, turned, turned.parent)
    return told


def errors(told: Sequence[FromStage]) -> list[str]:
    return [message["message"] for message in told if message["type"] == "error"]


def zeros(sink: Memory, robot: str) -> list[float]:
    return [round(at, 9) for name, at, twist in sink.sent if name == robot and twist == STILL]


class Later(Slow):
    """A robot whose listener is found only after a while."""

    after = 7.0

    def prepare(self, score: Score, restart: bool) -> None:
        Memory.prepare(self, score, restart)

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        self.deaf = {} if self.turned.now() >= START + self.after else {"b": "nothing is listening on /b/cmd_vel"}
        return super().missing(robots)


@pytest.mark.parametrize(("without", "begins"), [(True, PATIENCE), (False, Later.after)])
def test_all_begin_at_once_when_the_last_one_listens_or_without_it(without: bool, begins: float) -> None:
    sink, dance = Later(), load("a b $ repeat forward\n")
    dance = replace(dance, score=replace(dance.score, safety=Safety(start_without=without)))
    told = perform(sink, (0, dance), *((each / 5, PING) for each in range(1, 50)), (10, End()))
    states = [message for message in told if message["type"] == "transport"]
    assert [each["state"] for each in states] == ["waiting", "playing", "stopped"]
    assert states[1]["monotonic"] == pytest.approx(START + begins, abs=0.03)
    first = {robot: next(at for name, at, twist in sink.sent if name == robot and twist != STILL) for robot in "ab"}
    assert first == {"a": 0.0, "b": 0.0}
    lines = [message["message"] for message in told if message["type"] == "warning"]
    assert lines[0] == ("nothing is listening on /b/cmd_vel" if without else WAITS)


def test_nobody_waits_for_a_real_robot_that_only_stands_there() -> None:
    sink = Memory()
    sink.deaf = {"s": "nothing is listening"}
    perform(sink, (0, load("r $ forward\ns at 1 2\n")), (0.5, End()))
    assert sink.met == {"r"}
    assert sink.sent[0][1] == 0
    assert {robot for robot, _, _ in sink.sent} == {"r"}


def test_a_simulated_robot_that_only_stands_there_is_met() -> None:
    sink = Memory()
    perform(sink, (0, load("r $ forward\ns at 1 2\n")), (0.5, End()), real=False)
    assert sink.met == {"r", "s"}


def test_poses_of_robots_elsewhere_count_at_once_even_behind_waiting_arrivals() -> None:
    sink, dance = Memory(), load("a b $ repeat forward\n")
    parts = {name: replace(part, odom=f"/{name}/pose", odom_frame="world") for name, part in dance.score.parts.items()}
    parts["b"] = replace(parts["b"], host=Host("pad"))
    dance.load["here"] = ""
    dance.load["anyway"] = True
    near = {"b": SeenRobot(at=START + 0.3, pose={"x": 0.5, "y": 0.0, "z": 0.0, "heading": 0.0})}
    told = perform(
        sink,
        (0, replace(dance, score=replace(dance.score, parts=parts, world=World(keep_apart=1.0)))),
        (0.1, FromRos(RawPoses([RawPose("a", "odom", Pose(), START + 0.1)]))),
        (0.2, Speed(type="speed", factor=0.5, at=START + 0.5)),
        (0.29, FromRos(RawPoses([RawPose("a", "odom", Pose(), START + 0.29)]))),
        (0.3, RobotsSeen(type="seen", robots=near)),
        (0.4, End()),
    )
    states = {each["state"]: each["monotonic"] for each in told if each["type"] == "transport"}
    assert states["paused"] == START + 0.3


@pytest.mark.parametrize("broken", ["a", "r", "z"])
def test_all_others_get_their_last_zeros_if_one_robot_cannot_be_reached(broken: str) -> None:
    sink = Memory()
    sink.breaks_at = (0.503, broken)
    told = perform(sink, (0, load("a r z $ repeat forward\n")), (9, End()))
    for robot in ("a", "r", "z"):
        assert len(zeros(sink, robot)) == (0 if robot == broken else 3)
    assert told[-1] == {"type": "stopped", "message": f"{broken} has no publisher any more"}


def test_a_parent_that_has_never_pinged_may_stay_silent() -> None:
    told = perform(Memory(), (0, load("r $ repeat forward\n")), (9, End()))
    assert errors(told) == []


def test_a_parent_is_not_hung_while_the_stage_reads_a_long_line() -> None:
    arrivals: list[tuple[float, Event]] = [(0.0, PING), (0.0, load("r $ repeat forward\n")), (0.1, Reading())]
    assert errors(perform(Memory(), *arrivals, (LOADING_LIMIT, End()))) == []
    assert len(errors(perform(Memory(), *arrivals, (LOADING_LIMIT + 0.2, End())))) == 1


SPEED: Speed = {"type": "speed", "factor": 1.0}
SILENT = f"Improv was suspended or hung for {SILENCE_LIMIT} s, so all robots were stopped: play again"


@pytest.mark.parametrize(
    "other",
    [SPEED, Edge("/joy", True, START), Edge(RobotSense("r", "near"), True, START), RawPoses([])],
    ids=["a parameter", "a button", "a sense", "poses"],
)
def test_only_messages_from_the_parent_are_signs_of_its_life(other: Arrival) -> None:
    sink = Memory()
    others: list[tuple[float, Event]] = [(count / 10, FromRos(other)) for count in range(1, 50)]
    told = perform(sink, (0, PING), (0, load("r $ repeat forward\n")), *others, (9, End()))
    assert errors(told) == [SILENT]
    assert zeros(sink, "r") == [0.5, 0.55, 0.6]


def test_our_own_work_is_not_the_parents_silence() -> None:
    pings: list[tuple[float, Event]] = [(count / 10, PING) for count in range(40)]
    told = perform(Slow(), (0, PING), (0, load("r $ repeat forward\n")), *pings, (4, End()))
    assert errors(told) == []
    assert states(told)[-1] == "stopped"
    assert states(told)[-2] == "playing"


def test_a_parent_that_falls_silent_while_we_work_counts_as_hung_afterward() -> None:
    told = perform(Slow(), (0, PING), (0, load("r $ repeat forward\n")), (9, End()))
    assert errors(told) == [SILENT]
    stopped = [each["monotonic"] for each in told if each["type"] == "transport" and each["state"] == "stopped"]
    assert START + 2 < stopped[0] <= START + 2 + SILENCE_LIMIT


def test_robots_do_not_move_if_the_parent_hangs_before_the_button_is_held() -> None:
    sink = Memory()
    told = perform(sink, (0, PING), (0, guarded("r $ repeat forward\n")), (2, FromRos(HELD)), (9, End()))
    assert errors(told) == [SILENT]
    assert all(twist == STILL for *_, twist in sink.sent)


def test_what_people_asked_for_before_they_knew_that_the_parent_was_silent_is_refused() -> None:
    def asked(stops: int) -> Play:
        play = load("r $ repeat forward\n")
        return replace(play, load={**play.load, "stops": stops})

    sink = Memory()
    told = perform(sink, (0, PING), (0, asked(0)), (2, asked(0)), (3, PING), (3, asked(1)), (3.4, End()))
    assert errors(told) == [SILENT, OLDER]
    assert [each for each in told if each["type"] == "pressed"] == [{"type": "pressed", "topics": [], "count": 1}]
    assert states(told) == ["playing", "stopped", "stopped", "playing", "stopped"]


def test_a_stage_that_hung_during_a_count_does_not_start_real_robots() -> None:
    counted = load("r $ repeat forward\n")
    counted = replace(counted, score=replace(counted.score, count_in=True))
    for late, stalls in ((0.3, False), (1.5, True)):
        sink = Memory()
        told = perform(sink, (0, counted), (12, End()), late=late)
        assert errors(told) == ["the stage stalled for 1.5 s, so all robots were stopped: play again"] * stalls
        assert any(twist != STILL for *_, twist in sink.sent) == (not stalls)


SLEPT = "the machine was asleep for 30 s, so all robots were stopped: play again"


def test_real_robots_stand_after_the_machine_has_slept() -> None:
    sink = Memory()
    told = perform(sink, (0, load("r $ repeat forward\n")), (9, End()), sleeps_at=2.01)
    assert errors(told) == [SLEPT]
    assert zeros(sink, "r") == [2.05, 2.1, 2.15], "nothing else is sent to them after it woke"
    assert max(at for _, at, twist in sink.sent if twist != STILL) < 2.01


def test_a_score_from_before_the_machine_slept_is_refused_and_one_from_after_it_plays() -> None:
    def asked(asleep: float) -> Play:
        play = load("r $ repeat forward\n")
        return replace(play, load={**play.load, "asleep": asleep})

    sink = Memory()
    told = perform(sink, (2, asked(1000.0)), (5, asked(1030.0)), (9, End()), sleeps_at=1)
    assert errors(told) == ["the machine was asleep since somebody asked for this program: play it again"]
    assert min(at for _, at, twist in sink.sent if twist != STILL) == 0.0
    assert states(told)[:2] == ["stopped", "playing"]


def test_the_simulator_continues_after_the_machine_has_slept() -> None:
    told = perform(Memory(), (0, load("r $ repeat forward\n")), (9, End()), real=False, sleeps_at=2)
    assert errors(told) == []


@pytest.mark.parametrize(
    ("response", "over", "stands_at"), [("stand", False, 0.5), ("stand", True, 0.9), ("tell", False, 0.9)]
)
def test_a_simulated_robot_stands_as_soon_as_the_real_one_does_because_of_a_fault(
    response: Response, over: bool, stands_at: float
) -> None:
    when: Instant = {"beat": 1.0, "performed": 0.5, "wall": 0}
    fault: FaultMessage = {
        **when, "type": "fault", "generation": 1, "robot": "r", "fault": "off_path", "over": over,
        "response": response, "worst": {}, "message": "r is off its path", "line": "",
    }  # fmt: skip
    sink = Memory()
    perform(sink, (0, load("r $ repeat forward\n")), (0.5, fault), (0.9, End()), real=False)
    assert zeros(sink, "r")[0] == stands_at


def test_a_stage_that_does_not_lead_plays_at_the_pace_of_the_one_that_does() -> None:
    sink = Memory()
    bend: BendMessage = {"type": "bend", "at": START + 0.5, "beat": 0.5, "pace": 2.0}
    perform(sink, (0, load("beat 60\nr $ forward\n")), (0.5, bend), (3, End()))
    assert zeros(sink, "r")[0] == 0.75


def test_a_dance_that_waits_for_its_clock_does_not_begin_while_the_stage_ends() -> None:
    play, sink = load("beat 60\nr $ repeat forward\n"), Memory()
    play = replace(play, score=replace(play.score, clock=OutsideClock("midi")))

    def hears(at: float, rate: float, jumps: int = 0) -> tuple[float, Event]:
        return at, FromRos(Anchor(START + at, at, rate, 0.1, jumps))

    runs = [hears(each / 10, 1.0) for each in range(50)]
    told = perform(sink, (0, play), *runs, hears(5, 0.0), hears(5.5, 1.0, 1), (8.95, End()))
    assert states(told)[-1] == "paused"
    assert all(at < 5.5 for _, at, twist in sink.sent if twist != STILL)


def test_a_stage_whose_real_robots_are_paused_ends_at_once() -> None:
    sink = Memory()
    turned = Turned([(0, load("r $ repeat forward\n")), (1, {"type": "pause"}), (1.01, End())])
    sink.real = True
    run(OpenedOutput(sink, lambda message: None), turned, turned, turned.parent)
    assert zeros(sink, "r") == [1, 1.05, 1.1]
    assert turned.now() - START == pytest.approx(1.1)


def test_a_stage_that_only_has_to_stop_robots_waits_for_them_before_it_ends() -> None:
    """They may be those of a stage that has died."""
    sink, dance = Later(), load("b $ forward\n")
    sink.after = 1.0
    part = replace(dance.score.parts["b"], scenes=())
    perform(sink, (0, replace(dance, score=replace(dance.score, parts={"b": part}))), (0.5, End()))
    assert zeros(sink, "b")


def test_an_alarm_stops_moving_robots_and_reports_the_reason() -> None:
    sink = Memory()
    alarm = FromRos(Alarm("no standby"))
    told = perform(sink, (0, alarm), (0, load("r $ repeat forward\n")), (0.51, alarm), (2, alarm), (9, End()))
    assert errors(told) == ["no standby"]
    assert zeros(sink, "r") == [0.51, 0.56, 0.61]


def test_a_stop_that_only_the_parent_sends_is_confirmed_once_robots_were_sent_zeros() -> None:
    sink = Memory()
    sent: list[Twist] = []  # the latest velocity at each confirmation

    def tell(message: FromStage) -> None:
        if message["type"] == "obeyed":
            sent.append(sink.sent[-1][2])

    stop: Stop = {"type": "stop", "direct": "page 1"}
    turned = Turned([(0, load("r $ repeat forward\n")), (0.5, stop), (1, stop), (2, End())])
    run(OpenedOutput(sink, tell), turned, turned, turned.parent)
    assert sent == [STILL]


def test_a_ping_is_answered_with_its_number() -> None:
    told = perform(Memory(), (0, {"type": "ping", "number": 7}), (0, End()))
    assert {"type": "pong", "number": 7} in told


TOO_LONG = [["hold", [1, 0, 0, 0], 1, None], *(["repeat", place, 10**9] for place in range(35))]


@pytest.mark.parametrize("when", ["restart", "now"])
def test_a_sink_that_fails_at_a_new_score_ends_the_stage_which_stops_the_robots(when: When) -> None:
    sink = Memory()
    sink.refuses = {"s"}
    other = load("s $ forward\n")
    other.load["when"] = when
    told = perform(sink, (0, load("r $ repeat forward\n")), (0.51, other), (9, End()))
    assert told[-1] == {"type": "stopped", "message": "s can't be prepared"}
    assert zeros(sink, "r")[-3:] == [0.51, 0.56, 0.61]


def test_a_line_that_is_not_a_message_is_one_error_and_playing_continues() -> None:
    sink = Memory()
    told = perform(sink, (0, load("r $ forward\n")), (0.51, arrival(b"no JSON\n", RowsRead())), (9, End()))
    assert errors(told) == ["this line is not JSON"]
    assert zeros(sink, "r") == [1, 1.05, 1.1]


def test_a_failure_while_playing_ends_the_stage_with_its_reason() -> None:
    sink = Memory()
    told: list[FromStage] = []
    turned = Turned([(0, load("r $ forward\n")), (9, End())])
    sink.breaks_at = (0.2, "r")
    assert run(OpenedOutput(sink, told.append), turned, turned, turned.parent) == 1
    assert told[-1] == {"type": "stopped", "message": "r has no publisher any more"}
    assert all(twist == Twist(2.0) for *_, twist in sink.sent)


def test_robots_that_cannot_be_stopped_are_not_reported_as_stopped() -> None:
    sink = Memory()
    sink.breaks_at = (0.0, "r")
    standing = {robot: replace(part, scenes=()) for robot, part in score("r s $ forward\n").parts.items()}
    told = perform(sink, (0, Play(load("").load, Score(Fraction(60), standing))), (9, End()))
    assert {message["state"] for message in told if message["type"] == "transport"} <= {"waiting", "playing"}
    assert told[-1] == {"type": "stopped", "message": "r has no publisher any more"}
    assert len(zeros(sink, "s")) >= 3


def guarded(program: str) -> Play:
    """A score that plays only while a deadman button is held."""
    play = load(program)
    return replace(play, score=replace(play.score, safety=Safety(deadman=Deadman("/joy", 4))))


def states(told: Sequence[FromStage]) -> list[str]:
    return [message["state"] for message in told if message["type"] == "transport"]


def test_a_gamepad_at_the_page_lets_robots_move_while_its_button_is_held() -> None:
    sink = Memory()
    told = perform(sink, (0, guarded("r $ repeat forward\n")), (1, HELD), (1.2, HELD), (1.3, RELEASED), (2, End()))
    moved = [at for _, at, twist in sink.sent if twist != STILL]
    assert (min(moved), max(moved) <= 1.3) == (1.0, True)
    assert states(told)[-2:] == ["playing", "paused"]


def test_a_gamepad_that_falls_silent_counts_as_released() -> None:
    sink = Memory()
    told = perform(sink, (0, guarded("r $ repeat forward\n")), (1, HELD), (2, End()))
    moved = [at for _, at, twist in sink.sent if twist != STILL]
    assert max(moved) <= 1 + DEADMAN_LIMIT
    assert states(told)[-2:] == ["playing", "paused"]


def test_a_page_that_dies_while_a_key_is_held_counts_as_letting_it_go() -> None:
    play = load("r $ until near (repeat forward)\n")
    parts = {name: replace(part, senses={"near": Key("d")}) for name, part in play.score.parts.items()}
    held: KeySense = {"type": "key", "key": "d", "held": True}
    play = replace(play, score=replace(play.score, parts=parts))
    told = perform(Memory(), (0, play), (1, held), (1.1, held), (3, End()))
    sensed = [(each["value"], round(each["performed"], 6)) for each in told if each["type"] == "sensed"]
    assert sensed == [(False, 0.0), (True, 1.0), (False, round(1.1 + DEADMAN_LIMIT, 6))]


def test_simulated_robots_keep_limits_only_beside_real_ones() -> None:
    def shown(entry: bool) -> str:
        play = load("a $ forward")
        limited = {name: replace(part, profile=TURTLEBOT4) for name, part in play.score.parts.items()}
        message: Load = {**play.load, "entry": {"beat": 0, "monotonic": START}} if entry else play.load
        scores: list[Score] = []
        turned = Turned([(0, Play(message, replace(play.score, parts=limited))), (9, End())])
        run(
            OpenedOutput(Memory(), lambda told: None, lambda score, generation: scores.append(score)),
            turned,
            turned,
            turned.parent,
        )
        return scores[0].parts["a"].profile.dynamics

    assert (shown(entry=False), shown(entry=True)) == ("ideal", "limits")


def test_a_score_that_builds_on_a_lost_one_is_requested_again_while_the_dance_continues() -> None:
    sink = Memory()
    message: Load = {
        "type": "load",
        "generation": 7,
        "score": {**to_json(score("r $ left\n")), "known": 3},
        "when": "beat",
        "backend": "memory",
    }
    lost = arrival(json.dumps(message).encode(), RowsRead())
    told = perform(sink, (0, load("r $ repeat forward\n")), (0.51, lost), (2, End()))
    assert {"type": "lacks", "generation": 7} in told
    assert errors(told) == []
    assert zeros(sink, "r") == [2.0, 2.05, 2.1]


class Shown(Broadcast):
    """The scenes that pages show."""

    def __init__(self) -> None:
        pages, answers = Pages(Snapshot), Answers(lambda work: work())
        super().__init__(pages, answers, lambda do, *values: do(*values), print, takes_start_poses=False)
        self.scenes: list[int] = []

    def publish(self, message: ForPages | ShownScore | MeetingsMessage) -> None:
        if message["type"] == "score":
            self.scenes.append(message["scene"])
        super().publish(message)

    def tell(self, message: FromStage) -> None:
        if message["type"] == "transport":
            self.publish(message)


def test_pages_are_shown_the_scene_to_which_playback_goes_back() -> None:
    program = "a $ until near (repeat forward)\n---\na $ repeat left\n"
    force: Force = {"type": "force", "robot": "a", "sense": "near", "value": True}
    seek: Seek = {"type": "seek", "beat": 0.0}
    sink, pages = Memory(), Shown()
    sink.real = False
    turned = Turned([(0, load(program)), (0.5, force), (2.5, seek), (3, End())])
    opened = OpenedOutput(sink, pages.tell, pages.show)
    run(opened, turned, turned, turned.parent)
    assert pages.scenes == [0, 1, 0]
