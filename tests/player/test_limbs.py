"""The commands to body parts and their times, on a clock that the tests advance."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.events import Message
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import When
from improv_core.robots.config import read_robots
from improv_core.score.joints import joint_moments, limbs_of
from improv_core.score.score import Score
from tests.player.test_continuing import Continuing
from tests.player.test_player import Stage

SUITE: dict[str, Any] = json.loads((Path(__file__).parent.parent / "bodies.json").read_text())
TOML = """
[profiles.nod]
base = "turtlesim"
[profiles.nod.body.head]
left = { joint = "yaw", degrees = 30 }
up = { joint = "pitch", degrees = 20 }
[profiles.nod.body.head.poses]
aside = { left = 60 }
[profiles.nod.joints.yaw]
min = -90
max = 90
[profiles.nod.joints.pitch]
[robots.a]
profile = "nod"
[robots.b]
profile = "nod"
"""
Turn = tuple[float, float, float]


def analyzed(program: str, toml: str = TOML) -> Analysis:
    analysis = analyze("beat 60\n" + program, read_robots(toml))
    assert analysis.ok, (analysis.diagnostics, analysis.config.diagnostics)
    return analysis


class Bodies(Continuing):
    def __init__(self, program: str, toml: str = TOML) -> None:
        super().__init__()
        self.save(score_of(analyzed(program, toml)), "restart")

    def turns(self, robot: str = "a", joint: str = "yaw") -> list[Turn]:
        """The times at which a joint's velocity changed, its position then, and its new velocity, in degrees."""
        turns: list[Turn] = []
        for name, at, joints in self.sink.joints:
            if name == robot and joint in joints:
                position, velocity = (round(each * 180 / 3.141592653589793, 6) for each in joints[joint])
                if not turns or turns[-1][2] != velocity:
                    turns.append((round(at, 9), position + 0.0, velocity + 0.0))
        return turns


@pytest.mark.parametrize(
    ("program", "turns"),
    [
        ("a $ head (left right)", [(0, 0, 30), (1, 30, -30), (2, 0, 0)]),
        ("a $ head left forward", [(0, 0, 30), (1, 30, 0)]),
        ("a $ forward || head fast 2 left", [(0, 0, 60), (0.5, 30, 0)]),
        ("a $ rest head slow 2 left", [(0, 0, 0), (1, 0, 15), (3, 30, 0)]),
        ("a $ head (left to start)", [(0, 0, 30), (1, 30, -30), (2, 0, 0)]),
        ("a $ head (repeat 4 left to aside)", [(0, 0, 30), (3, 90, 0), (4, 90, -30), (5, 60, 0)]),
        ("a $ head left\n---\na $ head left", [(0, 0, 30), (2, 60, 0)]),
        ("a $ head left\n---\na $ rest", [(0, 0, 30), (1, 30, 0)]),
    ],
)
def test_joints_get_every_change_at_its_time(program: str, turns: list[Turn]) -> None:
    stage = Bodies(program)
    stage.run(10)
    assert stage.turns() == turns
    assert stage.states[-1] == "ended"


def test_a_joint_gets_its_position_again_and_again() -> None:
    stage = Bodies("a $ head left")
    stage.run(0.51)
    told = [(at, joints["yaw"].position) for _, at, joints in stage.sink.joints]
    assert [at for at, _ in told] == pytest.approx([0.05 * count for count in range(11)])
    assert [position for _, position in told] == pytest.approx([0.5235987755982988 * at for at, _ in told])


@pytest.mark.parametrize(
    ("program", "changes"),
    [
        ("a $ head (left right)", [1, 2]),
        ("a $ head slow 2 left || forward", [1]),
        ("a $ head (repeat 9 left)", [3, 9]),  # it reaches its limit
    ],
)
def test_each_command_to_a_joint_says_how_long_the_program_has_it_move_like_that(
    program: str, changes: list[float]
) -> None:
    """Otherwise it would be sent on beyond a place where it turns around."""
    stage = Bodies(program)
    stage.run(changes[-1])
    sent = [(at, until) for at, until in stage.sink.untils if at < changes[-1]]
    assert len(sent) >= 20
    assert all(at < until <= min(each for each in changes if each > at) for at, until in sent)


@pytest.mark.parametrize(
    ("kind", "more"), [("stop", {}), ("pause", {}), ("silence", {"muted": ["a", "b"], "soloed": []})]
)
def test_a_stop_a_pause_and_a_mute_have_all_joints_brake_at_once(kind: str, more: dict[str, list[str]]) -> None:
    """A command that lasts no time says so: zeros that the program asks for are no reason to brake."""
    stage = Bodies("a b $ head (left rest right)")
    stage.run(1.5)
    assert all(at < until for at, until in stage.sink.untils)
    stage.run(1.0)
    count = len(stage.sink.untils)
    stage.ask(kind, **more)
    assert stage.sink.untils[count:] == [(2.5, 2.5)] * 2
    stage.run(1.0)
    assert more or all(at < until for at, until in stage.sink.untils[count + 2 :])
    assert all(motion.velocity == 0 for _, _, joints in stage.sink.joints[count:] for motion in joints.values())


@pytest.mark.parametrize(
    ("change", "undo", "turns"),
    [
        ({"type": "pause"}, {"type": "resume"}, [(0.5, 15, 0), (1.5, 15, 30), (3, 60, -30), (4, 30, 0)]),
        (
            {"type": "silence", "muted": ["a"], "soloed": []},
            {"type": "silence", "muted": [], "soloed": []},
            [(0.5, 15, 0), (1.5, 15, 30), (2, 30, -30), (3, 0, 0)],
        ),
        (
            {"type": "speed", "factor": 2},
            {"type": "speed", "factor": 1},
            [(0.5, 15, 60), (1.25, 60, -60), (1.5, 45, -30), (2, 30, 0)],
        ),
    ],
    ids=["a pause", "a mute", "a speed"],
)
def test_joints_continue_from_where_they_are(change: Message, undo: Message, turns: list[Turn]) -> None:
    stage = Bodies("a $ head (left left right)")
    stage.run(0.5)
    for message, seconds in ((change, 1), (undo, 5)):
        stage.player.take(message, stage.now)
        stage.run(seconds)
    assert stage.turns() == [(0, 0, 30), *turns]


BESIDE = "\nb $ repeat head (left right)"
NARROWER = TOML.replace("min = -90\nmax = 90", "min = -40\nmax = 40").replace("left = 60", "left = 30")


@pytest.mark.parametrize(
    ("program", "seconds", "saved", "toml", "turns"),
    [
        (f"a $ head (left left left){BESIDE}", 0.5, f"a $ repeat head right{BESIDE}", TOML, [(0, 0, 30), (1, 30, -30)]),
        ("a $ repeat head left", 0.5, "a $ repeat forward", TOML, [(0, 0, 30), (1, 30, 0)]),
        ("a $ head (left left left)", 1.5, "a $ repeat head right", NARROWER, [(0, 0, 30), (2, 60, 0), (2, 40, -30)]),
    ],
    ids=["a changed part", "a body part that left", "another body"],
)
def test_after_a_save_joints_continue_from_where_they_are(
    program: str, seconds: float, saved: str, toml: str, turns: list[Turn]
) -> None:
    stage = Bodies(program)
    stage.run(seconds)
    stage.save(score_of(analyzed(saved, toml)))
    stage.run(1)
    assert stage.turns() == turns
    assert stage.turns("b") == ([(0, 0, 30), (1, 30, -30)] if BESIDE in program else [])


def test_a_robot_that_had_left_before_a_restart_keeps_its_joints_where_they_are() -> None:
    stage = Bodies("a $ head left\nb $ repeat head (left right)")
    stage.run(1.5)
    alone, together = score_of(analyzed("b $ repeat head (left right)")), score_of(analyzed("a b $ repeat head right"))
    saves: list[tuple[Score, When]] = [(alone, "now"), (alone, "restart"), (together, "now")]
    for score, when in saves:
        stage.save(score, when)
        stage.run(0.5)
    assert stage.turns()[-1][1:] == (30, -30)


@pytest.mark.parametrize(("beat", "position"), [(1.5, 45), (0.25, 7.5)])
def test_after_a_jump_joints_stand_where_they_ideally_are(beat: float, position: float) -> None:
    stage = Bodies("a $ head (left left to start right)")
    stage.run(0.5)
    stage.ask("seek", beat=beat)
    stage.run(0.1)
    assert stage.turns() == [(0, 0, 30), (0.5, position, 0), (0.5, position, 30)]


def suite() -> list[tuple[str, Score]]:
    groups = [SUITE, SUITE["poses"]]
    return [
        (case["program"], score_of(analyze(case["program"], read_robots(group["toml"]))))
        for group in groups
        for case in group["cases"]
    ]


def test_simulated_joints_are_where_the_score_says_at_any_time() -> None:
    for program, score in suite():
        simulator = Simulator(period=None)
        stage = Stage()
        stage.player = type(stage.player)(simulator, stage.told.append, lambda: 0.0)
        stage.perform(score)
        for number in range(12):
            stage.run(0.74)
            stage.player.advance(stage.now)
            found = simulator.snapshot().joints
            beat = 0.74 * (number + 1) * float(score.tempo) / 60
            for robot, part in score.parts.items():
                for limb in limbs_of(part, score.tempo):
                    ideal = dict(limb.positions)
                    for moment, velocities, begin in joint_moments(part.movement, limb):
                        if moment.start >= beat:
                            break
                        beats = min(float(moment.duration), beat - float(moment.start))
                        seconds = beats * 60 / float(score.tempo)
                        ideal = {
                            name: limb.body.joint[name].within(begin[name] + velocity * seconds)
                            for name, velocity in velocities.items()
                        }
                    assert {name: found[robot][name] for name in ideal} == pytest.approx(ideal, abs=1e-9), program
