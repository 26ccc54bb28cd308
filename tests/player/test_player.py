"""The player's commands and their times, on a clock that the tests advance."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pytest

from improv_core.player.player import Player
from improv_core.player.sensing import Foreseen
from improv_core.player.subscribers import LOOK_AT, MAX_LINES, PATIENCE
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import FromStage, Play, TransportMessage, When
from improv_core.protocol.output import BaseCommand, Edge, Noticed, Sink
from improv_core.score.joints import JointMotion
from improv_core.score.motion import Twist
from improv_core.score.score import Deadman, DeviceAddress, Rejoin, Safety, Score
from improv_core.score.senses import RobotSense
from tests.player.plays import to_play


class Memory(Sink):
    name = "memory"

    def __init__(self) -> None:
        self.real = False
        self.notes: dict[str, str] = {}
        self.resets = False
        self.noted, self.looks = Noticed(), 0
        self.sent: list[tuple[str, float, Twist]] = []
        self.joints: list[tuple[str, float, dict[str, JointMotion]]] = []
        self.paces: list[float] = []  # of commands to joints
        self.untils: list[tuple[float, float]] = []
        self.deaf: dict[str, str] = {}
        self.asked: list[set[str]] = []
        self.met: set[str] = set()
        self.refuses: set[str] = set()
        self.breaks_at: tuple[float, str] = (math.inf, "")  # when a robot becomes unreachable
        self.prepared = 0  # scores so far

    def preload(self, score: Score) -> Iterator[None]:
        for robot in score.parts.keys() - self.met:
            self.met.add(robot)
            yield

    def prepare(self, score: Score, restart: bool) -> None:
        for robot in self.refuses & score.parts.keys():
            raise OSError(f"{robot} can't be prepared")
        self.prepared += 1

    def ask(self, robots: Collection[str]) -> None:
        self.asked.append(set(robots))

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {robot: line for robot, line in self.deaf.items() if robots is None or robot in robots}

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {robot: line for robot, line in self.notes.items() if robots is None or robot in robots}

    def resetting(self, homing: Collection[str] = ()) -> bool:
        return self.resets

    def ready(self, commands: Sequence[BaseCommand]) -> Callable[[], None]:
        send, prepared = super().ready(commands), self.prepared

        def send_by_the_same_score() -> None:
            assert self.prepared == prepared, "these commands were made ready for an earlier score"
            send()

        return send_by_the_same_score

    def send(self, robot: str, twist: Twist, at: float) -> None:
        since, broken = self.breaks_at
        if robot == broken and at >= since:
            raise OSError(f"{robot} has no publisher any more")
        self.sent.append((robot, at, twist))

    def send_joints(
        self, robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0, until: float = math.inf
    ) -> None:
        self.joints.append((robot, at, dict(joints)))
        self.paces.append(pace)
        self.untils.append((round(at, 6), round(until, 6)))

    def noticed(self) -> Noticed:
        self.looks += 1
        return self.noted

    def changes(self, robot: str) -> list[tuple[float, float, float]]:
        """The times at which the robot's velocity changed, and its forward speed and yaw from then on."""
        changes: list[tuple[float, float, float]] = []
        for name, at, twist in self.sent:
            if name == robot and (not changes or changes[-1][1:] != (twist.x, twist.yaw)):
                changes.append((round(at, 12), twist.x, twist.yaw))
        return changes


class Stage:
    """A player on a memory, and the clock that drives it: it jumps from deadline to deadline."""

    def __init__(self, start: float = 1000.0) -> None:
        self.now = start
        self.sink = Memory()
        self.told: list[FromStage] = []
        self.player = Player(self.sink, self.told.append, lambda: 0.0)
        self.prepares = False  # whether changes are prepared before they are due

    def load(self, program: str, when: When = "restart") -> None:
        self.perform(score(program), len(self.told) + 1, when)

    def perform(self, dance: Score, number: int = 1, when: When = "restart", **rest: Any) -> None:
        """Have the player take a score."""
        self.request(to_play(dance, number, when, **rest))

    def request(self, asked: Play) -> None:
        """Have the player take a request, and begin at once if beat 0 is due, as a stage does."""
        self.player.take(asked, self.now)
        if self.player.run.is_due:
            self.player.advance(self.now)

    def ask(self, kind: str, **given: Any) -> None:
        """Have the player take a message of this type."""
        message: Any = {"type": kind, **given}
        take = self.player.hear if kind in ("cue", "osc_sense", "force") else self.player.take
        take(message, self.now)

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while (deadline := self._next_deadline()) <= end:
            self.now = max(deadline, self.now)
            self.player.advance(self.now)
        self.now = end

    def _next_deadline(self) -> float:
        if self.prepares:
            self.player.prepare()
        return self.player.deadline(self.now)

    def hang(self, seconds: float) -> None:
        """Do nothing for this long, and then what was due meanwhile."""
        deadline = self.player.deadline(self.now)
        self.now += seconds
        self.player.advance(self.now, self.now - deadline)

    def run_busy(self, seconds: float) -> None:
        """Run as before, but sending takes time too."""
        end = self.now + seconds
        while max(deadline := self.player.deadline(self.now), self.now) <= end:
            self.now = max(deadline, self.now)
            self.player.advance(self.now)

    @property
    def states(self) -> list[str]:
        return [message["state"] for message in self.transports]

    @property
    def transports(self) -> list[TransportMessage]:
        return [message for message in self.told if message["type"] == "transport"]

    @property
    def lines(self) -> list[str]:
        """The lines for people."""
        return [message["message"] for message in self.told if message["type"] in ("warning", "error", "fault")]


QUARTER = math.pi / 2


def score(program: str) -> Score:
    analysis = analyze(program)
    assert analysis.ok
    return score_of(analysis)


def played(program: str, seconds: float) -> Stage:
    stage = Stage()
    stage.load(program)
    stage.run(seconds)
    return stage


def test_every_change_is_sent_at_its_time_and_zero_at_the_end() -> None:
    stage = played("beat 60\nr $ forward [left left] forward", 10)
    assert stage.sink.changes("r") == [(0, 2, 0), (1, 0, 2 * QUARTER), (2, 2, 0), (3, 0, 0)]
    assert stage.states == ["playing", "ended"]


def test_commands_are_repeated_at_20_hz_and_silent_after_three_zeros() -> None:
    stage = played("r $ forward", 60)
    times = [at for _, at, _ in stage.sink.sent]
    assert times == pytest.approx([step / 20 for step in range(23)])
    assert [twist for _, _, twist in stage.sink.sent[-3:]] == [Twist(), Twist(), Twist()]
    assert stage.player.deadline(stage.now) == math.inf


def test_a_change_is_sent_before_the_repeats_that_are_due_too() -> None:
    stage = played("a b $ forward left\nz $ repeat forward forward", 0.96)
    stage.sink.sent.clear()
    stage.now = 1001.03  # the machine was busy
    stage.player.advance(stage.now)
    changed = [("a", Twist(yaw=QUARTER)), ("b", Twist(yaw=QUARTER)), ("z", Twist(2))]
    assert [(robot, twist) for robot, _, twist in stage.sink.sent[:3]] == changed


def test_a_slow_machine_keeps_playing_and_reports_its_rate_once() -> None:
    stage = Stage()
    stage.sink.real = True
    send, cost = stage.sink.send, 1 / 1200

    def send_slowly(robot: str, twist: Twist, at: float) -> None:
        send(robot, twist, at)
        stage.now += cost

    stage.sink.send = send_slowly  # type: ignore[method-assign]
    robots = [f"r{number}" for number in range(100)]
    stage.load(f"beat 2\n{' '.join(robots)} $ repeat (forward left)")
    stage.run_busy(31)
    assert stage.states == ["playing"]
    assert len(stage.lines) == 1
    assert stage.lines[0].startswith("this machine can't send 100 robots 20 commands a second each")
    assert [at for at, *_ in stage.sink.changes("r50")] == [0, 30]
    cost = 1 / 150
    stage.run_busy(20)
    assert stage.states[-1] == "stopped"
    assert stage.lines[1:] == ["this machine is too slow for 100 robots, so all were stopped: play fewer robots"]


def test_many_tiny_items_cannot_overload_a_robot() -> None:
    stage = played("r $ fast 1000000 repeat 1000000 (forward left)", 5)
    assert len(stage.sink.sent) <= 2004
    assert stage.sink.changes("r")[-1] == (2, 0, 0)


def test_robots_stand_while_waiting_for_listeners() -> None:
    stage = played("r $ repeat forward", 1)
    stage.sink.deaf = {"new": "nothing is listening on /new/cmd_vel"}
    stage.load("r new $ repeat forward")
    assert stage.sink.sent[-1] == ("r", 0.0, Twist())
    assert stage.player.run.mode == "waiting"


def test_a_speed_counts_at_once_and_for_the_next_score() -> None:
    stage = played("r $ forward", 0.5)
    stage.ask("speed", factor=2)
    stage.run(10)
    stage.load("r $ forward")
    stage.run(10)
    assert stage.sink.changes("r") == [(0, 2, 0), (0.5, 4, 0), (0.75, 0, 0), (0, 4, 0), (0.5, 0, 0)]


FAULT = {"robot": "r", "fault": "silent", "over": False, "response": "stand", "worst": {}, "message": "", "line": ""}


@pytest.mark.parametrize(
    ("kind", "given", "is_sent"),
    [
        ("stop", {}, False),
        ("pause", {}, True),
        ("resume", {}, False),
        ("resume", {"anyway": True}, False),
        ("seek", {"beat": 0.0}, False),
        ("speed", {"factor": 2.0}, True),
        ("silence", {"muted": ["r"], "soloed": []}, True),
        ("pressed", {"topics": [], "count": 1}, False),
        ("bend", {"pace": 1.0, "beat": 1.0, "at": 1001.0}, True),
        ("fault", FAULT, True),
        ("cue", {}, True),
        ("osc_sense", {"name": "kick", "robot": "r", "value": True}, True),
        ("force", {"robot": "r", "sense": "near", "value": True}, True),
    ],
)
def test_what_is_due_is_sent_before_a_message_unless_that_is_void_or_makes_it_void(
    kind: str, given: Mapping[str, Any], is_sent: bool
) -> None:
    stage = played("beat 60\nr $ forward left", 0.99)
    stage.now += 0.02  # the machine was busy
    stage.ask(kind, **given)
    assert ((1, 0, QUARTER) in stage.sink.changes("r")) == is_sent


def test_a_muted_robot_stands_while_its_part_continues_and_a_solo_lasts_for_the_next_score() -> None:
    stage = played("r s $ repeat (forward left)", 0.5)
    stage.ask("silence", muted=["r"], soloed=[])
    stage.run(1.0)
    stage.ask("silence", muted=[], soloed=[])
    stage.run(1.0)
    assert stage.sink.changes("r") == [(0, 2, 0), (0.5, 0, 0), (1.5, 0, QUARTER), (2, 2, 0)]
    assert stage.sink.changes("s") == [(0, 2, 0), (1, 0, QUARTER), (2, 2, 0)]
    still = [at for robot, at, twist in stage.sink.sent if robot == "r" and twist == Twist()]
    assert len(still) == 3  # then silence, for other publishers
    stage.ask("silence", muted=["s"], soloed=["s"])
    stage.load("s t $ forward")
    stage.run(0.5)
    assert stage.sink.changes("s")[-1][1:] == (2, 0)
    assert stage.sink.changes("t") == [(0, 0, 0)]


@pytest.mark.parametrize("hears", [False, True])
def test_real_robots_that_are_late_stop_instead_of_catching_up(hears: bool) -> None:
    stage = Stage()
    stage.sink.real = True
    stage.load("r $ repeat (forward left)")
    stage.run(1.0)
    stage.sink.sent.clear()
    stage.now += 2
    if hears:  # of an edge elsewhere, which is late too
        stage.player.foresee(Foreseen(1, RobotSense("s", "near"), True), stage.now)
    else:
        stage.player.advance(stage.now)
    stage.run(10)
    assert {twist for _, _, twist in stage.sink.sent} == {Twist()}
    assert "the stage stalled for 1.9 s" in stage.lines[-1]  # since what was due 0.05 s later
    assert stage.states[-1] == "stopped"


def test_a_robot_is_no_longer_gone_once_its_listener_is_found() -> None:
    """It takes longer to find out that it hears us, and the robot may already move."""
    stage = Stage()
    stage.sink.real = True
    stage.load("r $ repeat forward")
    stage.run(1)
    for deaf, seconds in ((GONE, 3), ({"r": ""}, 4)):
        stage.sink.deaf = deaf
        stage.run(seconds)
    back = "beat 5: r listens again, after 2.9 s, and continues in the middle of the program"
    assert stage.lines == [f"beat 2: {LOST}", back]


def test_the_line_about_a_robot_that_its_output_has_lost_has_the_reason() -> None:
    stage = Stage()
    stage.sink.real = True
    dance = score("r $ repeat forward")
    device = DeviceAddress("tcp:localhost:4000", None)
    parts = {name: replace(part, device=device) for name, part in dance.parts.items()}
    stage.perform(replace(dance, parts=parts))
    stage.run(1)
    stage.sink.deaf = {name: f"{name}: it is switched off" for name in parts}
    stage.run(1)
    assert stage.lines == ["beat 2: r is gone: it is switched off"]


GONE = {"r": "nobody listens on /r/cmd_vel"}
LOST = "r is gone, nothing listens on /r/cmd_vel: start its driver again"


def test_one_line_reports_many_robots() -> None:
    stage = Stage()
    robots = [f"r{number}" for number in range(50)]
    stage.sink.deaf = {robot: f"nobody listens on /{robot}/cmd_vel (here)" for robot in robots[:48]}
    stage.sink.notes = dict.fromkeys(robots[48:], "the standby process has ended")
    stage.load("\n".join(f"{robot} $ repeat forward" for robot in robots))
    stage.run(PATIENCE + 3)
    expected = ["nobody listens on 48 topics, such as /r0/cmd_vel (here)", "the standby process has ended"]
    assert stage.lines == expected


def test_a_look_costs_no_more_with_many_robots_and_reports_few_lines() -> None:
    stage = Stage()
    asked: list[int] = []
    robots = [f"r{number}" for number in range(1000)]
    warnings = stage.sink.warnings

    def count(robots: Collection[str] | None = None) -> dict[str, str]:
        asked.append(len(robots or ()))
        return warnings(robots)

    stage.load(f"beat 1\n{' '.join(robots)} $ repeat forward")
    stage.run(0.1)  # beat 0 looks at all of them, after they were sent their first velocities
    stage.sink.warnings = count  # type: ignore[method-assign]
    stage.sink.notes = {robot: f"{robot} bumped into a wall" for robot in robots}
    stage.run(1.2)
    assert max(asked) == LOOK_AT
    assert len(stage.lines) == MAX_LINES + 1
    assert stage.lines[-1] == f"and {1000 - MAX_LINES} more warnings"


STOP, DEADMAN = "/e_stop", Deadman("/joy", 4)


class Guarded(Stage):
    """A stage with real robots."""

    def __init__(self, safety: Safety) -> None:
        super().__init__()
        self.sink.real = True
        self._safety = safety

    def load(self, program: str, when: When = "restart") -> None:
        guarded = replace(score(program), safety=self._safety)
        self.perform(guarded, len(self.told) + 1, when)


def test_a_button_that_is_no_longer_heard_counts_as_released() -> None:
    stage = Guarded(Safety(deadman=DEADMAN))
    stage.load("r $ repeat forward")
    stage.run(1)
    for held in (True, None):
        stage.player.sense(Edge(str(DEADMAN), held, stage.now), stage.now)
        stage.run(1)
    assert stage.sink.changes("r") == [(0, 0, 0), (1, 2, 0), (2, 0, 0)]
    assert stage.transports[-1]["waits_for"] == ["button 4 on /joy"]


@pytest.mark.parametrize(("rejoin", "until"), [("next", "play"), ("scene", "scene")])
def test_a_robot_that_comes_back_stands_until_the_next_scene_or_play(rejoin: Rejoin, until: str) -> None:
    stage = Guarded(Safety(rejoin=rejoin))
    stage.load("r s $ repeat 4 forward\n---\nr s $ repeat 4 left")
    stage.run(1)
    stage.sink.deaf = GONE
    stage.run(1)
    stage.sink.deaf = {}
    stage.run(1)
    assert stage.lines[-1].endswith(f", and stands until the next {until}")
    assert [x for _, x, _ in stage.sink.changes("r")] == [2, 0]
    stage.run(2)
    assert (stage.sink.changes("r")[2:] == [(4, 0, QUARTER)]) == (until == "scene")
    stage.load("r s $ repeat forward", "now")
    stage.run(1)
    assert stage.sink.changes("r")[-1][1:] == (2, 0)


def test_a_robot_that_stands_after_it_was_away_is_asked_whether_it_hears() -> None:
    """Nothing else is sent to it, so it would never confirm that."""
    stage = Guarded(Safety(rejoin="scene"))
    stage.load("r s $ repeat 4 forward\n---\nr s $ repeat 4 left")
    stage.run(1)
    stage.sink.deaf = GONE
    stage.run(1)
    stage.sink.asked.clear()
    stage.run(1)
    assert stage.sink.asked
    assert all(asked == {"r"} for asked in stage.sink.asked)


def test_all_wait_for_a_robot_that_went_away() -> None:
    stage = Guarded(Safety(rejoin="pause"))
    stage.load("r s $ forward left")
    stage.run(0.4)
    stage.sink.deaf = GONE
    stage.run(20)
    assert (stage.states[-1], stage.transports[-1]["waits_for"]) == ("paused", ["r"])
    stage.sink.deaf = {}
    stage.run(5)
    assert stage.states == ["playing", "paused", "playing", "ended"]
    assert [(x, yaw) for _, x, yaw in stage.sink.changes("s")] == [(2, 0), (0, 0), (2, 0), (0, QUARTER), (0, 0)]


def test_a_sink_is_asked_what_it_noticed_ten_times_a_second_however_many_commands_leave() -> None:
    stage = Stage()
    stage.sink.real = True
    stage.load(f"beat 60\n{' '.join(f'r{number}' for number in range(10))} $ repeat forward")
    stage.run(10.0)
    assert len(stage.sink.sent) > 1000
    assert 90 <= stage.sink.looks <= 110
