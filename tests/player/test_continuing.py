"""A save with `continue` edits the score that plays: the player's commands, on a clock that the tests advance."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from improv_core.player.decide import UNHEARD
from improv_core.player.subscribers import LOOK_AT
from improv_core.protocol.messages import State, TransportMessage, When
from improv_core.safety.pending_zeros import LAST_ZEROS
from improv_core.score.motion import STILL, Twist
from improv_core.score.score import Safety, Score
from improv_core.score.takeover import Takeover
from improv_core.session.state import PartEditions
from tests.player.test_player import QUARTER, Memory, Stage, score

ANNA = "anna $ repeat (forward [left right])\n"
BERT = "bert $ repeat (forward left)\n"
EDITED = "bert $ repeat right\n"


class Topics(Memory):
    def __init__(self) -> None:
        super().__init__()
        self.topics: dict[str, str] = {}
        self.by_topic: list[tuple[str, Twist]] = []

    def prepare(self, score: Score, restart: bool) -> None:
        super().prepare(score, restart)
        self.topics.update({robot: part.topic for robot, part in score.parts.items()})

    def send(self, robot: str, twist: Twist, at: float) -> None:
        super().send(robot, twist, at)
        self.by_topic.append((self.topics[robot], twist))


class Continuing(Stage):
    """A stage whose parent numbers the parts, as `Playback` does."""

    def __init__(self, start: float = 1000.0) -> None:
        super().__init__(start)
        self.sink: Topics = Topics()
        self.editions = PartEditions()
        self.generation = 0
        self.player = type(self.player)(self.sink, self._hear, lambda: 0.0)

    def _hear(self, message: object) -> None:
        self.told.append(message)  # type: ignore[arg-type]
        if isinstance(message, dict) and message["type"] == "transport":
            self.editions = self.editions.plays(message["generation"])

    def save(self, program: str | Score, when: When = "beat", entry: Takeover | None = None) -> Score:
        """Load a program as the parent would. Return the score that was sent."""
        self.generation += 1
        asked = score(program) if isinstance(program, str) else program
        self.editions, sent = self.editions.number(asked, self.generation)
        self.perform(sent, self.generation, when, entry=entry)
        return sent

    @property
    def transport(self) -> TransportMessage:
        return self.transports[-1]

    def sent_to(self, robot: str) -> list[tuple[str, float, Twist]]:
        return [each for each in self.sink.sent if each[0] == robot]


def played(program: str | Score, seconds: float) -> Continuing:
    stage = Continuing()
    stage.save(program, "restart")
    stage.run(seconds)
    return stage


def changes(stage: Continuing, robot: str, since: float = 0.0) -> list[tuple[float, float, float]]:
    return [change for change in stage.sink.changes(robot) if change[0] >= since]


@pytest.mark.parametrize(("bar", "asked"), [("", 3), ("bar 3\n", 4)], ids=["asked", "written"])
def test_a_bar_has_as_many_beats_as_the_playing_program_sets_or_else_the_request(bar: str, asked: int) -> None:
    stage = Continuing()
    stage.save(bar + BERT, "restart")
    assert stage.transport.get("bar") == (3 if bar else None)
    stage.run(3.5)
    stage.perform(score(EDITED), 2, "bar", beats_per_bar=asked)
    stage.run(10)
    assert stage.transport["begins"] == {"bert": 6}
    assert "bar" not in stage.transport


def test_a_new_tempo_keeps_everyones_beat() -> None:
    stage = played("beat 60\nanna $ repeat (forward left)\n", 2.5)
    stage.save("beat 120\nanna $ repeat (forward left)\n")
    stage.run(2)
    # Beat 3 at 3 s: from there on, twice as fast. It plays the rest of its path, not its beginning.
    assert changes(stage, "anna", 2.5) == [(3, 0, 2 * QUARTER), (3.5, 4, 0), (4, 0, 2 * QUARTER), (4.5, 4, 0)]
    assert "begins" not in stage.transport


def with_part(program: str, robot: str, **different: object) -> Score:
    whole = score(program)
    return replace(whole, parts={**whole.parts, robot: replace(whole.parts[robot], **different)})  # type: ignore[arg-type]


def test_a_part_continues_on_its_new_topic_and_the_robot_on_the_old_one_stops() -> None:
    stage = played(ANNA + BERT, 2.5)
    stage.save(with_part(ANNA + BERT, "bert", topic="/other/cmd_vel"))
    stage.run(4)
    old, new = ([twist for at, twist in stage.sink.by_topic if at == f"/{name}/cmd_vel"] for name in ("bert", "other"))
    assert old[-3:] == [STILL] * 3
    assert new[0] == Twist(yaw=math.pi / 2)
    assert [at for at, *_ in changes(stage, "bert", 3.5)] == [4, 5, 6]
    assert stage.lines == ["/other/cmd_vel has the part of bert now"]


def test_another_profile_begins_the_part_again() -> None:
    stage = played(ANNA + BERT, 2.5)
    profile = replace(score(BERT).parts["bert"].profile, step=0.5)
    stage.save(with_part(ANNA + BERT, "bert", profile=profile))
    stage.run(1.5)
    assert changes(stage, "bert", 2.5) == [(3, 0.5, 0), (4, 0, QUARTER)]


def test_a_robot_removed_and_restored_within_a_beat_was_never_away() -> None:
    stage = played(ANNA + BERT, 2.1)
    for program in (ANNA, ANNA + BERT):
        stage.save(program)
        stage.run(0.4)
    stage.run(2)
    assert stage.sent_to("bert") == played(ANNA + BERT, 4.9).sent_to("bert")


def test_a_robot_that_returns_while_it_is_being_stopped_moves_again() -> None:
    stage = played(ANNA + BERT, 2.5)
    stage.save(ANNA, "now")
    stage.run(0.06)
    stage.save(ANNA + BERT, "now")
    stage.run(0.5)
    assert [twist.x for _, at, twist in stage.sent_to("bert") if at >= 2.56] == [2] * 10


def test_a_seek_counts_each_part_from_its_own_beginning() -> None:
    stage = played("anna $ repeat (forward left)\nbert $ repeat forward\n", 2.5)
    stage.save("anna $ repeat (forward left)\nbert $ repeat (left forward)\n")
    stage.run(1)
    stage.ask("seek", beat=8.0)  # 5 beats of bert's part, which began at beat 3
    stage.run(0.5)
    assert changes(stage, "anna", 3.5)[0] == (3.5, 2, 0)
    assert changes(stage, "bert", 3.5)[0] == (3.5, 2, 0)
    stage.ask("seek", beat=2.5)  # before bert's part begins
    stage.run(1.2)
    assert changes(stage, "bert", 4.0) == [(4, 0, 0), (4.5, 0, QUARTER)]


class Pair:
    """A stage that leads and its twin, which its parent loads as `Playback` does: a little later each time."""

    def __init__(self, late: float) -> None:
        self.leader, self.twin, self.late = Continuing(), Continuing(), late
        self.sent: dict[int, Score] = {}
        self.known = 0

    def save(self, program: str, when: When = "beat") -> None:
        sent = self.leader.save(program, when)
        self.sent[self.leader.generation] = sent

    def run(self, seconds: float) -> None:
        """Run in small steps, so that the twin soon gets what the leading stage did."""
        end = self.leader.now + seconds
        while self.leader.now < end:
            self.leader.run(0.01)
            self.twin.run(max(self.leader.now + self.late - self.twin.now, 0))
            told = self.leader.transports[-1]
            if told["state"] == "playing" and told["generation"] == max(self.sent) > self.known:
                self.known = told["generation"]
                entry: Takeover = {"beat": told["beat"], "monotonic": told["monotonic"]}
                entry["begins"] = told.get("begins", {})
                when: When = "restart" if told["restarted"] == self.known else "now"
                self.twin.perform(self.sent[self.known], self.known, when, entry=entry)


@pytest.mark.parametrize("late", [0.0, 0.005, 0.3])
def test_the_twin_follows_the_leading_stage(late: float) -> None:
    pair, dice = Pair(late), random.Random(1)
    pair.save(ANNA + BERT, "restart")
    for turn in range(60):
        pair.run(dice.uniform(0, 0.4))
        pair.save(ANNA + (BERT, EDITED, "cleo $ repeat left\n")[turn % 3], ("beat", "now", "bar")[turn // 5 % 3])
    pair.run(10)
    leader, twin = pair.leader, pair.twin
    assert twin.transport.get("begins") == leader.transport.get("begins")
    assert twin.transport["beat"] == pytest.approx(leader.transport["beat"])
    end = leader.now - 1000
    for robot, since in (("anna", 0.0), ("bert", end - 9), ("cleo", end - 9)):
        one, other = ({change for change in changes(each, robot, since) if change[0] < end} for each in (twin, leader))
        assert one == other


@pytest.mark.parametrize("when", ["restart", "now"])
def test_a_renamed_robot_is_not_stopped_in_between(when: When) -> None:
    def on_one_topic(program: str) -> Score:
        made = score(program)
        return replace(made, parts={name: replace(part, topic="/cmd_vel") for name, part in made.parts.items()})

    stage = played(on_one_topic(ANNA), 2.5)
    before = len(stage.sink.by_topic)
    stage.save(on_one_topic(ANNA.replace("anna", "carl")), when)
    stage.run(0.9)
    sent = [twist for _, twist in stage.sink.by_topic[before:]]
    count = sent.count(STILL)
    assert count >= LAST_ZEROS
    assert sent[:count] == [STILL] * count


def guarded(program: str, safety: Safety) -> Score:
    return replace(score(program), safety=safety)


@pytest.mark.slow("saves for many beats")
@pytest.mark.parametrize("asked", ["save", "seek"])
def test_a_robot_that_goes_away_is_noticed_despite_saves_and_seeks(asked: str) -> None:
    robots = [f"r{number}" for number in range(LOOK_AT * 3)]
    crowd = "".join(f"{robot} $ repeat (forward left)\n" for robot in robots)
    stage = Continuing()
    stage.sink.real = True
    saves = [guarded(crowd + part, Safety(rejoin="pause")) for part in (BERT, EDITED)]
    stage.save(saves[0], "restart")
    stage.run(2)
    stage.sink.deaf = {robots[-1]: f"nobody listens on /{robots[-1]}/cmd_vel"}
    for turn in range(60):
        stage.run(0.02)
        if asked == "save":
            stage.save(saves[turn % 2], "now")
        else:
            stage.ask("seek", beat=float(turn))
    assert (stage.transport["state"], stage.transport.get("waits_for")) == ("paused", [robots[-1]])


def test_reports_are_not_repeated_at_every_save() -> None:
    stage = Continuing()
    stage.sink.deaf = {"bert": "nothing is listening on /bert/cmd_vel"}
    stage.save(ANNA + BERT, "restart")
    stage.run(6)
    told = list(stage.lines)
    for turn in range(10):
        stage.save(ANNA + (BERT, EDITED)[turn % 2], "now")
        stage.run(1)
    assert stage.lines == told == ["nothing is listening on /bert/cmd_vel"]
    stage.save(ANNA + BERT, "restart")
    stage.run(6)
    assert stage.lines == 2 * told


@pytest.mark.parametrize(("deaf", "state"), [(["anna", "bert"], "stopped"), (["bert"], "ended"), ([], "ended")])
def test_a_dance_that_no_robot_has_heard_is_stopped_and_one_that_some_have_heard_ends(
    deaf: list[str], state: State
) -> None:
    stage = Continuing()
    stage.sink.real = True
    stage.sink.deaf = {robot: f"nothing is listening on /{robot}/cmd_vel" for robot in deaf}
    stage.save("beat 60\nanna bert $ forward\n", "restart")
    stage.run(10)
    assert stage.transport["state"] == state
    assert ([each["message"] for each in stage.told if each["type"] == "error"] == [UNHEARD]) == (state == "stopped")
    stage.sink.deaf = {}
    stage.save("beat 60\nanna bert $ forward\n", "restart")
    stage.run(10)
    assert stage.transport["state"] == "ended"
