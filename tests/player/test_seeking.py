"""Seeks: playback continues as if it had played to that beat, whatever the program is, and nothing takes long."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.outputs.simulator.collisions import NoCollisions
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.player import Player
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.output import Edge
from improv_core.score.movement import ENDLESS
from improv_core.score.replay import Replay
from improv_core.score.score import Score
from improv_core.score.senses import Key
from tests.player.test_continuing import Continuing
from tests.random_programs import programs, score_of_text

NEVER_TRUE = st.sampled_from(["near", "hold"])
"""Conditions that don't hold while no sense is true: then none decides anything."""
AT_ONCE = 0.2
"""Seconds for which a seek may hold up a stage."""
BUSY = 5
"""The slowdown of a busy machine."""


class Simulated(Continuing):
    """A stage whose robots are simulated, and pass through each other. Nothing is near, and no key is held."""

    def __init__(self, score: Score) -> None:
        super().__init__()
        self.simulator = Simulator(None, NoCollisions)
        self.player = Player(self.simulator, self._hear, lambda: 0.0)
        self.save(score, "restart")
        for robot, part in self.player.run.score.parts.items():
            for sense in part.senses:
                self.ask("force", robot=robot, sense=sense, value=False)
        self.run(0)

    def stands(self) -> Mapping[str, Sequence[float]]:
        self.player.advance(self.now)
        snapshot = self.simulator.snapshot()
        joints = {robot: list(each.values()) for robot, each in snapshot.joints.items()}
        return {robot: [*astuple(pose), *joints.get(robot, ())] for robot, pose in snapshot.poses.items()}


def check(text: str, beat: float) -> None:
    played, sought = Simulated(score_of_text(text)), Simulated(score_of_text(text))
    plays = sought.player.run.mode == "playing"  # otherwise it has ended, and the seek pauses it
    played.run(beat)
    sought.ask("seek", beat=beat)
    for seconds in (0.0, 0.37, 0.5, 1.3, 2.0):
        for stage in (played, sought):
            stage.run(seconds)
        expected = played.stands()
        for robot, found in sought.stands().items():
            assert found == pytest.approx(expected[robot], abs=1e-4), (robot, beat, seconds)
    assert not plays or sought.player.run.mode == played.player.run.mode


BEATS = st.integers(0, 1_200).map(lambda hundredths: hundredths / 100)
"""Exact ones: if something changes at thirds, a beat is rounded to before or after that."""


@given(programs(NEVER_TRUE, 3), BEATS)
def test_a_seek_leads_to_what_playing_leads_to(text: str, beat: float) -> None:
    check(text, beat)


@pytest.mark.parametrize(
    ("text", "beat"),
    [
        pytest.param("a $ forward forward left\nb $ until near forward left", 2.5, id="an until that is over"),
        pytest.param("a $ head ease shuffle (left right)\nb $ repeat 60 forward", 5, id="an ease that is over"),
        pytest.param("a $ if near (forward) else (left)\nb $ repeat 4 forward", 3, id="an if that is over"),
        pytest.param("a $ pause near (forward || left)\nb $ repeat 4 forward", 3, id="a pause that is over"),
        pytest.param("a $ repeat (if near (forward) else ())", 2.5, id="a round that takes no time"),
        pytest.param("a $ slow 3/2 (until near (repeat 3 (left || up)))", 2.5, id="within another rate"),
        pytest.param("a $ repeat (choose (left right) until near (forward))", 7.5, id="dice of the right turn"),
        pytest.param("a $ repeat (until near (head to aside) head (left down))", 5.25, id="within a pose"),
        pytest.param("a $ down down up", 2.5, id="on the ground"),
        pytest.param("a $ repeat (up scale 2 down fast 3/2 up)", 7.5, id="on the ground again and again"),
        pytest.param("a $ down\n---\na $ up left", 1.5, id="on the ground in the scene before"),
        pytest.param("a $ forward left", 0.9996, id="just before a change"),
        pytest.param("a $ until near (forward left)", 0.9996, id="just before a change that is performed"),
        pytest.param("a $ head left head down", 0.9996, id="just before a change of a body part"),
    ],
)
def test_a_seek_that_once_failed_leads_to_what_playing_leads_to(text: str, beat: float) -> None:
    check(text, beat)


@pytest.mark.parametrize("beat", [0, 2, 2.5, 3, 4, 10, 1e15])
@pytest.mark.parametrize("text", ["a $ pause not near (forward)\nb $ forward", "a $ until not hold (repeat forward)"])
def test_a_stage_lives_where_a_sense_decides_at_once(text: str, beat: float) -> None:
    stage = Simulated(score_of_text(text))
    stage.ask("seek", beat=beat)
    stage.run(3)
    assert stage.lines == []


def asked(kind: str, **given: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.fixed_dictionaries({"kind": st.just(kind), **given})


class Story(Simulated):
    def happen(self, what: Any) -> None:
        match what:
            case str(text), ("now" | "beat" | "bar" | "end" | "restart") as when:
                self.save(score_of_text(text), when)
            case bool(held):
                self.player.sense(Edge(Key("h"), held, self.now), self.now)
            case _:
                self.ask(**what)


PROGRAMS = programs(most_scenes=3)
ANYWHERE = st.floats(0, 14) | st.integers(0, 14).map(float) | st.sampled_from([1e3, 1e6, 1e15])
HAPPENS = st.one_of(
    asked("seek", beat=ANYWHERE),
    st.sampled_from(["pause", "resume", "cue", "stop"]).flatmap(asked),
    asked("speed", factor=st.sampled_from([0.1, 1.0, 4.0])),
    asked("force", robot=st.sampled_from("ab"), sense=st.just("near"), value=st.sampled_from([True, False, None])),
    st.tuples(PROGRAMS, st.sampled_from(["now", "beat", "bar", "end", "restart"])),
    st.booleans(),  # a key is held, or let go
)
PASSES = st.sampled_from([0.0, 0.0, 0.01, 0.3, 1.0, 2.7])
STORIES = st.lists(st.tuples(HAPPENS, PASSES), min_size=1, max_size=10)


@given(PROGRAMS, STORIES)
def test_a_stage_lives_whatever_happens(text: str, story: Sequence[tuple[Any, float]]) -> None:
    stage = Story(score_of_text(text))
    for what, seconds in story:
        stage.happen(what)
        stage.run(seconds)
    stage.run(5)
    assert not [message for message in stage.told if message["type"] == "error"]


# Durations

FAR = [
    pytest.param(
        "a $ repeat (until hold (repeat forward) left)\nb $ repeat (until cue (repeat right) left)", id="waits"
    ),
    pytest.param("a $ repeat (until near (forward) left) || repeat 7 (slow 2 (left right))", id="voices"),
    pytest.param("a $ repeat (forward || head (left right to aside))", id="body parts"),
    pytest.param("a $ repeat (if near (forward) else ())", id="turns that take no time"),
    pytest.param("a $ pause not near (forward)", id="a pause for good"),
]


@pytest.mark.parametrize("beat", [20_000.0, 1e15])
@pytest.mark.parametrize("text", FAR)
def test_a_far_seek_takes_no_longer_than_a_near_one(text: str, beat: float) -> None:
    stage = Simulated(score_of_text(text))
    stage.run(0.5)
    begin = time.process_time()
    stage.ask("seek", beat=beat)
    stage.player.advance(stage.now)
    Replay(stage.player.run.score, stage.player.run.transport.origin)
    assert time.process_time() - begin < AT_ONCE * BUSY
    assert stage.lines == []
    assert stage.transport["beat"] == min(beat, stage.player.run.begun.beats)


REFUSED = [
    pytest.param("a $ repeat (until not near (repeat forward) left)", id="what has to be performed"),
    pytest.param("a $ repeat choose (forward left)", id="dice"),
    pytest.param("a $ repeat (forward left) || (left repeat (up down))", id="voices that never meet again"),
]


@pytest.mark.parametrize("text", REFUSED)
def test_a_seek_that_takes_too_long_is_refused_and_the_dance_continues(text: str) -> None:
    stage = Simulated(score_of_text(text))
    stage.run(0.5)
    begin = time.process_time()
    stage.ask("seek", beat=1e6)
    assert time.process_time() - begin < AT_ONCE * BUSY
    assert stage.lines == [
        "can't jump to beat 1e+06: it takes too long to find out what a does there, so jump less far"
    ]
    stage.run(0.5)
    assert stage.player.run.mode == "playing"
    assert stage.player.run.beat(stage.now, ENDLESS) == 1


def test_many_robots_share_the_budget() -> None:
    """One robot alone may seek this far, a hundred may not."""
    names = " ".join(f"r{number}" for number in range(100))
    alone, all_of_them = (
        Simulated(score_of(analyze(f"beat 60\n{each} $ repeat choose (forward left)"))) for each in ("r", names)
    )
    for stage in (alone, all_of_them):
        stage.ask("seek", beat=2_000.0)
    assert alone.lines == []
    assert len(all_of_them.lines) == 1


def test_a_line_names_robots_whose_joints_take_too_long_to_place() -> None:
    """Two voices move its head, so this has to be performed."""
    stage = Simulated(score_of_text("a $ repeat head (to aside || left)\nb $ repeat head (left right)"))
    stage.ask("seek", beat=1e6)
    assert stage.lines == [
        "the joints of a don't stand as they do at this beat: it takes too long to compute that, so jump less far"
    ]
    assert stage.player.run.transport.origin == 1_000_000
