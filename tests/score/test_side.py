"""The view from the side: only for a robot that climbs, with every turn of a helix, and small enough for a hover."""

from __future__ import annotations

import pytest
from hypothesis import given

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.movement import Movement
from improv_core.score.path import pose_at
from improv_core.score.side import Side, sides
from improv_core.score.strokes import paths
from improv_core.score.svg import picture, plot
from tests.score.test_movement import finite_movements, part_of
from tests.score.test_movement import score_of as score_with

HELIX = "repeat 8 (forward || left || scale 1/4 up)"


def seen(program: str, most_pieces: int = 10_000) -> list[Side]:
    return sides(paths(score_of(analyze(program))), most_pieces)


def extent(side: Side) -> tuple[float, float, float, float]:
    """The leftmost, rightmost, lowest, and highest point."""
    across, high = zip(*(point for piece in side.pieces for point in piece[:2]), strict=True)
    return min(across), max(across), min(high), max(high)


def test_a_helix_shows_every_turn_and_its_height() -> None:
    (side,) = seen(f"r $ {HELIX}")
    radius = 4 / 3.14159265
    assert extent(side) == pytest.approx((-radius, radius, 0, 4), abs=1e-3)
    crossings = [piece for piece in side.pieces if piece.start[0] < 1e-6 < piece.end[0]]
    assert len(crossings) == 2
    assert side.end == pytest.approx((0, 4), abs=1e-6)


@pytest.mark.parametrize("program", ["r $ forward left forward", "r $ left", "", "r $ forward\nq $ backward"])
def test_a_flat_dance_has_no_side(program: str) -> None:
    assert seen(program) == []
    assert "from the side" not in plot(score_of(analyze(program))) + picture(score_of(analyze(program)))


def test_a_robot_on_the_floor_is_seen_beside_one_that_climbs() -> None:
    climbs, stays = seen("r $ up\nq $ forward")
    assert (climbs.end, stays.end) == ((0, 2), (2, 0))


@pytest.mark.parametrize(
    ("program", "whole"),
    [("r $ repeat (up forward)", False), (f"r $ repeat ({HELIX})", False), ("r $ repeat (up down)", True)],
)
def test_an_endless_climb_is_dashed(program: str, whole: bool) -> None:
    (side,) = seen(program)
    assert side.whole is whole


def test_strokes_that_senses_decide_are_not_certain() -> None:
    (side,) = seen("r $ up until near (repeat up) down")
    assert [(piece.end, piece.certain) for piece in side.pieces] == [((0, 2), True), ((0, 10), True), ((0, 8), False)]


def test_an_incomplete_path_is_dashed() -> None:
    (side,) = seen(f"r $ {HELIX}", most_pieces=10)
    assert (len(side.pieces), side.whole) == (10, False)


@given(finite_movements)
def test_the_side_ends_where_the_robot_does(movement: Movement) -> None:
    drawn = paths(score_with(movement))
    expected = pose_at(part_of(movement), 10**6)
    assert expected is not None
    for side in sides(drawn, 10_000) if drawn[0].whole else []:
        assert side.end == pytest.approx((expected.x, expected.z), abs=1e-6)


@pytest.mark.slow("draws a long climb")
def test_a_small_picture_of_a_long_climb_stays_small() -> None:
    wild = "r $ repeat 10000 (forward fast 1.01 (left forward || up) fast 7/5 (halfright || scale 1/7 down))"
    for program in (wild, f"r $ repeat 500 ({HELIX})", "r $ slow 9999 up || repeat 9999 (forward || left)"):
        assert len(picture(score_of(analyze(program))).encode()) < 20_000
