"""Scenes in the player: barriers on whole beats, and saves that edit the scene that plays."""

from __future__ import annotations

import sys

from tests.player.test_continuing import Continuing, changes, played
from tests.player.test_player import QUARTER, Stage, score

LEFT, RIGHT = (0, QUARTER), (0, -QUARTER)
FORWARD, STANDS = (2, 0), (0, 0)

TWO = "anna $ repeat 4 forward\nbert $ repeat 4 left\n---\nanna $ repeat 4 right\nbert $ repeat 4 forward\n"


def check_moves(stage: Continuing, robot: str, moves: list[tuple[float, tuple[float, float]]]) -> None:
    assert changes(stage, robot) == [(beat, *move) for beat, move in moves]


def test_a_scene_begins_on_the_first_whole_beat_on_which_all_before_is_over() -> None:
    stage = played("anna $ forward\nbert $ slow 5/2 forward\n---\nanna bert $ left\n", 20)
    check_moves(stage, "anna", [(0, FORWARD), (1, STANDS), (3, LEFT), (4, STANDS)])
    check_moves(stage, "bert", [(0, (0.8, 0)), (2.5, STANDS), (3, LEFT), (4, STANDS)])
    assert (stage.states, stage.transport["beat"]) == (["playing", "ended"], 4)


def test_a_save_edits_the_scene_that_plays_and_the_next_one_shifts() -> None:
    stage = played(TWO, 1.5)
    stage.save(TWO.replace("bert $ repeat 4 left", "bert $ repeat 4 right"))
    stage.run(20)
    check_moves(stage, "anna", [(0, FORWARD), (4, STANDS), (6, RIGHT), (10, STANDS)])
    check_moves(stage, "bert", [(0, LEFT), (2, RIGHT), (6, FORWARD), (10, STANDS)])


def test_a_change_to_a_later_scene_affects_nobody_before_it() -> None:
    alone, edited = played(TWO, 1.5), played(TWO, 1.5)
    edited.save(TWO.replace("bert $ repeat 4 forward", "bert $ repeat 2 right"))
    for stage in (alone, edited):
        stage.run(2.49)
        assert "begins" not in stage.transport
    assert edited.sink.sent == alone.sink.sent
    edited.run(20)
    check_moves(edited, "anna", [(0, FORWARD), (4, RIGHT), (8, STANDS)])
    check_moves(edited, "bert", [(0, LEFT), (4, RIGHT), (6, STANDS)])


def test_a_changed_part_begins_at_its_own_beat_0_of_the_scene_that_plays() -> None:
    stage = played(TWO, 5.5)
    stage.save(TWO.replace("bert $ repeat 4 forward", "bert $ left repeat 2 right"))
    stage.run(20)
    check_moves(stage, "anna", [(0, FORWARD), (4, RIGHT), (8, STANDS)])
    check_moves(stage, "bert", [(0, LEFT), (4, FORWARD), (6, LEFT), (7, RIGHT), (9, STANDS)])
    assert stage.transports[1]["begins"] == {"anna": 4, "bert": 6}
    assert stage.transports[1]["scene"] == {"index": 1, "begins": 4}


def test_dice_of_a_scene_that_begin_at_another_throw_are_a_change() -> None:
    dance = "anna $ {}\n---\nanna $ repeat 4 choose (forward left right)\nbert $ repeat 9 left\n"
    stage = played(dance.format("forward"), 2.5)
    same = stage.save(dance.format("left"))
    stage.run(1)
    assert stage.transport["begins"] == {"anna": 1, "bert": 1}
    thrown = stage.save(dance.format("choose (forward left)"))
    stage.run(1)
    assert same.parts["anna"].editions[1] != thrown.parts["anna"].editions[1]
    assert stage.transport["begins"] == {"anna": 4, "bert": 1}


def test_a_scene_that_is_deleted_while_it_plays_gives_way_to_the_one_above() -> None:
    stage = played(TWO, 5.5)
    stage.save("anna $ repeat 4 forward\nbert $ repeat 4 left\n")
    stage.run(20)
    check_moves(stage, "anna", [(0, FORWARD), (4, RIGHT), (6, FORWARD), (10, STANDS)])


def test_a_simulator_that_is_late_catches_up_with_hundreds_of_scenes_on_the_small_stack_of_a_stage() -> None:
    stage, dance = Stage(), score("---\n".join(["r $ forward\n", "r $ left\n"] * 245))
    limit = sys.getrecursionlimit()  # higher than Python's own, because programs are parsed here
    sys.setrecursionlimit(1000)
    try:
        stage.perform(dance)
        stage.now += 500
        stage.player.advance(stage.now)
    finally:
        sys.setrecursionlimit(limit)
    turns = [(float(beat), *(LEFT if beat % 2 else FORWARD)) for beat in range(490)]
    assert stage.sink.changes("r") == [*turns, (490, 0, 0)]
