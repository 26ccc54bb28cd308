"""Predictions of what robots sense, compared with the simulator itself."""

from __future__ import annotations

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.movement import near
from improv_core.score.path import pose_at
from improv_core.score.prediction import Prediction
from improv_core.score.score import Score
from improv_core.score.walk import walk
from improv_core.slices import unless
from improv_core.stage import dry_run
from improv_core.stage.dry_run import perform, predict

SENSES = """
[senses]
wall = { topic = "scan", message = "sensor_msgs/LaserScan", below = 0.7 }
quick = { topic = "odom", message = "nav_msgs/Odometry", above = 0.5 }
asked = { key = "a" }
"""


def scored(program: str) -> Score:
    analysis = analyze(program, read_robots(SENSES if "wall" in program or "asked" in program else ""))
    assert analysis.ok, analysis.diagnostics
    return score_of(analysis)


def prediction(program: str) -> Prediction:
    found = predict(scored(program))
    assert found
    return found


@pytest.mark.parametrize(
    "program",
    [
        "room 6 4\nada $ repeat (until near (repeat forward) left)",
        "beat 90\nroom 6 4\nada $ repeat (until not near (repeat fast 3 left) scale 1/3 forward)",
        "room 6 4\nada $ if near left else forward if near left else repeat if near left else scale 1/4 forward",
        "ada at 0 0\nbo at 5 0\nada $ until near (repeat scale 1/2 forward) left forward\nbo $ repeat 5 left",
        "ada at 0 0\nbo at 5 0 facing 180\nada bo $ until near (repeat scale 1/2 forward)\n---\nada bo $ backward",
        "room 8 8\nada $ repeat (until near seed 3 (repeat (choose (left right) scale 1/3 forward)) backward)",
        "room 6 4\nada $ until wall (repeat scale 1/4 forward) backward until quick ease forward",
        "room 6 4\nada $ pause near (repeat 3 forward)",
    ],
)
def test_robots_are_where_the_simulator_has_them(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    *_, longest = moments = (0.7, 3.1, 15)
    monkeypatch.setattr(dry_run, "LONGEST", longest)
    score = scored(program)
    found = predict(score)
    assert found
    simulator = Simulator(period=None)
    for seconds in moments:
        perform(score, simulator, seconds)
        passed = near(min(seconds * float(score.tempo) / 60, float(found.score.beats)))
        for robot, pose in simulator.poses().items():
            ideal = pose_at(found.score.parts[robot], passed)
            assert ideal
            assert ideal.apart(pose)[0] < 1e-3, f"{robot} after {seconds} s"


def test_a_bump_is_felt_where_the_simulator_feels_it_and_pushes_nobody() -> None:
    found = prediction("room 6 4\nada $ until bump (repeat scale 1/8 forward) left forward")
    at = pose_at(found.score.parts["ada"], near(float(found.score.beats) - 2))
    assert at
    assert at.x == pytest.approx(3 - 0.3, abs=2 * 0.25 / 240 + 1e-3)  # two steps, and the overlap of those who touch
    through = prediction(
        "room 6 4\nada $ until near (repeat rest) || repeat 40 scale 1/8 forward\nbo $ until bump rest"
    )
    assert through.score.beats >= 1


@pytest.mark.parametrize(
    ("program", "cut"),
    [
        ("room 6 4\nada $ repeat (until near (repeat forward) left)", 12),
        ("beat 6000\nroom 6 4\nada $ repeat until near (repeat left)", 1000),
        ("room 6 4\nada bo cy $ repeat until near (repeat left)", 5_000 / 240 / 3),
        ("room 20 20\nada $ until near (repeat left) forward", 12),
        ("room 6 4\nada $ repeat 9 until near forward", None),
    ],
)
def test_it_ends_after_enough_seconds_1000_beats_or_enough_steps(
    program: str, cut: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dry_run, "LONGEST", 12.0)
    monkeypatch.setattr(dry_run, "MAX_STEPS", 5_000)
    assert prediction(program).cut == (cut and pytest.approx(cut, abs=1e-6))


def test_senses_that_nobody_can_compute_never_hold() -> None:
    program = (
        "room 6 4\nada $ until asked (if wall left else scale 1/2 forward) until cue rest\nbo $ until wall forward"
    )
    found = prediction(program)
    assert found.assuming == {"ada"}
    assert not found.score.open
    for unknown in ("ada $ repeat until cue forward", "ada $ until asked (repeat forward)", "ada $ forward"):
        assert predict(scored(unknown)) is None


def test_the_words_that_move_a_robot_stay_known() -> None:
    """So a hit is reported at the word."""
    program = "walk = scale 1/2 forward\nroom 6 4\nada $ until near (repeat walk) left"
    score = scored(program)
    found = predict(score)
    assert found
    first = next(walk(found.score.parts["ada"].movement))
    words = [score.text[score.offsets[each.statement] :][slice(*each.span)] for each in first.sources]
    assert words == ["walk", "forward"]


def test_a_prediction_that_nobody_waits_for_any_more_is_dropped() -> None:
    score, asked = scored("room 6 4\nada $ repeat (until near (repeat forward) left)"), []

    def is_over() -> bool:
        asked.append(True)
        return len(asked) > 10

    assert unless(is_over, lambda: predict(score)) is None
    assert len(asked) == 11
