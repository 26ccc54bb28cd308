"""Open parts in the player: its commands and reports when senses change, on a clock that the tests advance."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import product

import pytest

from improv_core.player.sensing import foreseen
from improv_core.protocol.messages import When
from improv_core.protocol.output import Edge
from improv_core.score.algebra import hold, parallel, repeat, series
from improv_core.score.motion import Pose
from improv_core.score.movement import Movement, Velocity
from improv_core.score.reactions import Condition, if_else, pause, until
from improv_core.score.score import Part, Score
from improv_core.score.senses import BUILT_IN, Key, OscName, RobotSense, Source, Topic
from improv_core.text import Span
from tests.player.test_player import QUARTER, Stage, score

FORWARD, LEFT = hold(Velocity(1), 1, Span(0, 7)), hold(Velocity(yaw=1), 1, Span(8, 12))
NEAR, NOT_NEAR, CUE = Condition("near", True), Condition("near", False), Condition("cue", True)
HERE = Span(20, 25)
PROFILE = score("anna $ forward").parts["anna"].profile
ROAMER = repeat(series([until(repeat(FORWARD), NEAR, HERE), LEFT]))
LIDAR = Topic("/anna/scan", "sensor_msgs/LaserScan", below=0.5)
SENSES: Mapping[str, Source] = {**BUILT_IN, "near": LIDAR}
GOES, TURNS, STANDS = (2, 0), (0, QUARTER), (0, 0)

Moves = list[tuple[float, tuple[float, float]]]
Scenes = Movement | tuple[Movement, ...]


def open_score(tempo: int = 60, senses: Mapping[str, Source] = SENSES, **parts: Scenes) -> Score:
    made = {}
    for robot, given in parts.items():
        scenes = given if isinstance(given, tuple) else (given,)
        editions = tuple(hash((robot, id(each))) for each in scenes)
        made[robot] = Part(robot, scenes, PROFILE, Pose(), f"/{robot}/cmd_vel", senses=senses, editions=editions)
    return Score(Fraction(tempo), made)


class Reacting(Stage):
    """A stage whose robots sense what the tests choose."""

    def __init__(self, start: float = 1000.0) -> None:
        super().__init__(start)
        self.generation = 0

    def begin(self, score: Score, when: When = "restart", **values: bool | None) -> None:
        """Play a score. Until they sense something else, its robots sense these values, or nothing at all."""
        for robot in score.parts:
            for sense in score.parts[robot].senses.keys() - {"cue"}:
                self.feel(robot, sense, values.get(sense, False))
        self.generation += 1
        self.perform(score, self.generation, when)

    def feel(self, robot: str, sense: str, value: bool | None, ago: float = 0.0) -> None:
        self.player.sense(Edge(RobotSense(robot, sense), value, self.now - ago), self.now)

    def act(self, *story: float | str) -> None:
        """Let seconds pass, give the cue, or have anna sense that something is near or far, or sense nothing."""
        for each in story:
            if not isinstance(each, str):
                self.run(each)
            elif each == "cue":
                self.ask("cue")
            else:
                self.feel("anna", "near", {"near": True, "far": False, "silence": None}[each])

    def moves(self, robot: str = "anna") -> Moves:
        return [(at, (x, yaw)) for at, x, yaw in self.sink.changes(robot)]

    @property
    def decisions(self) -> list[tuple[str, float, bool]]:
        return [(each["robot"], each["beat"], each["held"]) for each in self.told if each["type"] == "decided"]

    @property
    def edges(self) -> list[tuple[str, str, float, bool | None]]:
        found = [each for each in self.told if each["type"] == "sensed"]
        return [(each["robot"], each["sense"], each["beat"], each["value"]) for each in found]


def playing(
    near: bool | None = False, tempo: int = 60, senses: Mapping[str, Source] = SENSES, **parts: Scenes
) -> Reacting:
    """A stage that plays these parts, whose robots sense that something is near, or not, or nothing at all."""
    stage = Reacting()
    stage.begin(open_score(tempo, senses, **parts), near=near)
    return stage


def test_an_edge_changes_the_velocity_at_its_time_and_later_changes_are_on_the_beat() -> None:
    stage = playing(anna=ROAMER)
    stage.act(2.25, "near", 0.25, "far", 3)
    assert stage.moves() == [(0, GOES), (2.25, STANDS), (3, TURNS), (4, GOES)]
    assert stage.decisions == [("anna", 2.25, True)]
    (decided,) = [each for each in stage.told if each["type"] == "decided"]
    assert (decided["sources"], decided["performed"], decided["generation"]) == ([[-1, *HERE]], 2.25, 1)


def test_an_edge_counts_from_its_own_time_though_it_arrives_later() -> None:
    stage = playing(anna=ROAMER)
    stage.run(1.999)
    stage.now += 0.003  # beat 2 is due, and the edge came before it
    stage.feel("anna", "near", True, ago=0.004)
    stage.run(0.5)
    assert stage.decisions == [("anna", 1.998, True)]
    assert stage.moves() == [(0, GOES), (1.998, STANDS), (2, TURNS)]


def test_a_cue_holds_for_an_instant_and_for_everybody() -> None:
    stage = Reacting()
    anna, bert = until(repeat(FORWARD), CUE), until(repeat(LEFT), CUE)
    stage.begin(open_score(anna=anna, bert=bert))
    stage.act(2.5, "cue", 5)
    assert stage.moves("anna") == [(0, GOES), (2.5, STANDS)]
    assert stage.moves("bert") == [(0, TURNS), (2.5, STANDS)]
    assert stage.states == ["playing", "ended"]
    assert stage.transports[-1]["beat"] == 3


def test_an_osc_message_is_a_sense_until_another_one_comes() -> None:
    stage = playing(senses={"drop": OscName("kick")}, anna=pause(repeat(FORWARD), Condition("drop", True)))
    stage.run(1.5)
    for name, robot in (("kick", "anna"), ("snare", "anna"), ("kick", "bert")):
        stage.ask("osc_sense", name=name, robot=robot, value=True)
    stage.run(1.2)
    stage.ask("osc_sense", name="kick", robot="anna", value=False)
    stage.run(2)
    assert stage.moves() == [(0, GOES), (1.5, STANDS), (3.5, GOES)]


def test_the_senses_of_simulated_robots_can_be_forced_and_those_of_real_ones_not() -> None:
    simulated, real = Reacting(), Reacting()
    real.sink.real = True
    for stage in (simulated, real):
        stage.begin(open_score(anna=until(repeat(FORWARD), NEAR)))
        stage.run(1.5)
        stage.ask("force", robot="anna", sense="near", value=True)
        stage.run(0.5)
    assert simulated.moves() == [(0, GOES), (1.5, STANDS)]
    assert real.moves() == [(0, GOES)]
    assert real.lines == ["anna is a real robot: its senses can't be forced"]


@pytest.mark.parametrize("follows", [False, True], ids=["it is forced", "another stage leads"])
def test_a_key_and_osc_change_no_sense_that_is_forced_or_announced(follows: bool) -> None:
    stage, now = Reacting(), {"beat": 0.0, "monotonic": 1000.0}
    senses: Mapping[str, Source] = {"near": Key("d"), "drop": OscName("kick")}
    anna, bert = until(repeat(FORWARD), NEAR), until(repeat(FORWARD), Condition("drop", True))
    stage.perform(open_score(senses=senses, anna=anna, bert=bert), entry=now if follows else None)
    for robot, sense in product(("anna", "bert"), () if follows else senses):
        stage.ask("force", robot=robot, sense=sense, value=False)
    stage.run(1.5)
    known, moves = list(stage.told), (stage.moves("anna"), stage.moves("bert"))
    stage.player.sense(Edge(Key("d"), True, stage.now), stage.now)
    stage.ask("osc_sense", name="kick", robot="bert", value=True)
    stage.run(1)
    assert (stage.told, stage.moves("anna"), stage.moves("bert")) == (known, *moves)


def test_a_robot_stands_while_a_sense_that_it_reads_is_silent_and_its_beats_continue() -> None:
    stage = playing(anna=series([until(series([FORWARD, LEFT] * 3), NEAR), LEFT]), near=None)
    stage.act(1.5, "far", 1, "silence", 2.25, "far", 5)
    assert stage.moves() == [(0, STANDS), (1.5, TURNS), (2, GOES), (2.5, STANDS), (4.75, GOES), (5, TURNS), (7, STANDS)]


def test_pausing_and_resuming_keeps_earlier_decisions() -> None:
    stage = playing(anna=series([until(repeat(FORWARD), NEAR), repeat(LEFT, 4)]))
    stage.act(1.5, "near", 1.75)
    stage.ask("pause")
    stage.run(10)
    stage.ask("resume")
    stage.run(10)
    assert stage.moves() == [(0, GOES), (1.5, STANDS), (2, TURNS), (3.25, STANDS), (13.25, TURNS), (16, STANDS)]


def test_a_save_leaves_an_open_part_that_is_the_same_alone() -> None:
    alone, edited = Reacting(), Reacting()
    first = open_score(anna=ROAMER, bert=repeat(LEFT))
    for stage in (alone, edited):
        stage.begin(first)
        stage.act(1.5, "near", 0.25, "far", 0.75)
    edited.perform(open_score(anna=ROAMER, bert=repeat(FORWARD)), 2, "beat")
    for stage in (alone, edited):
        stage.act(3.25, "near", 3)
    sent = [[each for each in stage.sink.sent if each[0] == "anna"] for stage in (alone, edited)]
    assert sent[0] == sent[1]
    assert edited.moves("bert") == [(0, TURNS), (3, GOES)]


def test_a_stop_is_obeyed_whatever_robots_sense() -> None:
    stage = playing(anna=ROAMER)
    stage.run(1.5)
    stage.ask("stop")
    stage.act("near", 1, "far", "cue", 5)
    assert stage.moves() == [(0, GOES), (1.5, STANDS)]
    assert stage.states == ["playing", "stopped"]


def test_a_part_that_never_stops_changing_is_stopped_and_the_others_play_on() -> None:
    stage = Reacting()
    hurried = until(repeat(hold(Velocity(1), Fraction(1, 10**9))), NEAR)
    stage.begin(open_score(anna=hurried, bert=repeat(LEFT, 3)))
    stage.run(5)
    assert stage.lines == ["anna stops: its part changes more often than it can be performed"]
    assert stage.moves("bert") == [(0, TURNS), (3, STANDS)]
    assert stage.sink.changes("anna")[-1][1:] == STANDS


def test_another_stage_performs_the_same_from_the_reported_edges() -> None:
    leads, follows = Reacting(), Reacting()
    voices = parallel([until(repeat(FORWARD), NEAR), pause(repeat(LEFT), NOT_NEAR)])
    dance = open_score(tempo=97, anna=repeat(series([voices, if_else(LEFT, FORWARD, NEAR)])), bert=ROAMER)
    leads.begin(dance)
    for turn in range(40):
        leads.run(0.037 * (turn % 13) + 0.011)
        leads.feel(("anna", "bert")[turn % 2], "near", turn % 3 != 0)
    follows.generation = 1
    follows.perform(dance, entry={"beat": 0, "monotonic": follows.now + 0.1})
    told = [each for each in leads.told if each["type"] == "sensed"]
    for each in told:
        follows.player.foresee(foreseen(each), follows.now)
    follows.run(leads.now - 1000 + 0.1)
    assert follows.decisions == leads.decisions
    for robot in ("anna", "bert"):
        moves = leads.moves(robot)
        assert [move for _, move in follows.moves(robot)][: len(moves)] == [move for _, move in moves]
        assert [at for at, _ in follows.moves(robot)] == pytest.approx([at for at, _ in moves], abs=1e-3)


def test_sensed_changes_are_reported_with_beat_and_time() -> None:
    stage = playing(tempo=120, anna=ROAMER)
    assert sorted(stage.edges) == [("anna", "bump", 0, False), ("anna", "near", 0, False)]
    stage.act(0.75, "near")
    stage.feel("bert", "near", True)  # no part reads it
    assert stage.edges[2:] == [("anna", "near", 1.5, True)]
