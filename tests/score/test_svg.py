"""Pictures of dances: the paths of their lines, and their sizes."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from hypothesis import given

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.movement import Movement
from improv_core.score.path import pose_at
from improv_core.score.strokes import Path, paths
from improv_core.score.svg import picture, plot
from improv_core.score.world import Box, Circle, Wall, World
from improv_core.stage.dry_run import predict
from tests.score.test_movement import finite_movements, movements, part_of
from tests.score.test_movement import score_of as score_with

LARGEST = 20_000
SVG = "{http://www.w3.org/2000/svg}"


def path(program: str) -> Path:
    (drawn,) = paths(score_of(analyze(program)))
    return drawn


def check(program: str, *strokes: tuple[float, float, float]) -> None:
    """Check the end of each stroke, and its radius."""
    assert [(stroke.end.x, stroke.end.y, stroke.radius) for stroke in path(program).strokes] == [
        pytest.approx(stroke, abs=1e-9) for stroke in strokes
    ]


def test_repetitions_are_drawn_once() -> None:
    check("r $ repeat 40 (forward left)", (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 0))


def test_a_ramp_is_drawn_like_what_it_plays() -> None:
    check("r $ ease forward ramp 1 2 (left forward) reverse ease ramp 1/2 1 backward", (2, 0, 0), (2, 2, 0), (2, 0, 0))
    assert len(path("r $ (ease forward) || left").strokes) > 1


def test_a_circle_is_three_arcs_and_leads_back() -> None:
    strokes = path("r $ fast 1 (repeat 4 forward) || repeat 4 left").strokes
    assert [stroke.radius for stroke in strokes] == [pytest.approx(1.2732395447)] * 3
    assert (strokes[-1].end.x, strokes[-1].end.y) == pytest.approx((0, 0), abs=1e-9)


def test_a_robot_that_only_turns_is_drawn() -> None:
    check("r $ left rest right")
    ElementTree.fromstring(picture(score_of(analyze("r $ left"))))


def test_endless_paths_are_cut_off_and_dashed_unless_they_close() -> None:
    away, around = path("r $ repeat (forward left forward right)"), path("r $ repeat (forward halfleft)")
    assert (len(away.strokes), away.whole) == (32, False)
    assert (len(around.strokes), around.whole) == (8, True)


@given(finite_movements)
def test_a_path_ends_where_the_robot_does(movement: Movement) -> None:
    drawn = paths(score_with(movement), most_strokes=10_000)[0]
    expected = pose_at(part_of(movement), 10**6)
    assert expected is not None
    if drawn.whole:
        ends = [(pose.x, pose.y, pose.z) for pose in (drawn.end, expected)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-6)


HELIX = "repeat 8 (forward || left || scale 1/4 up)"


def test_a_helix_shows_every_turn_and_its_height() -> None:
    helix = path(f"r $ {HELIX}")
    across, high = zip(
        *((each.x, each.z) for stroke in helix.strokes for each in (stroke.start, stroke.end)), strict=True
    )
    radius = 4 / math.pi
    assert (min(across), max(across), min(high), max(high)) == pytest.approx((-radius, radius, 0, 4), abs=1e-3)
    assert len([stroke for stroke in helix.strokes if stroke.start.x < 1e-6 < stroke.end.x]) == 2


@pytest.mark.parametrize(
    ("program", "views"),
    [("r $ forward left forward", 1), ("", 1), ("r $ up\nq $ forward", 2), ("r $ up down", 2)],
)
def test_only_a_dance_with_a_robot_that_climbs_is_seen_from_the_side(program: str, views: int) -> None:
    score = score_of(analyze(program))
    for drawn in (plot(score), picture(score)):
        assert drawn.count("from the side") == views - 1
        assert drawn.count('stroke-linejoin="round"') == views * len(score.parts)


def test_what_coincides_from_above_is_drawn_there_once() -> None:
    above, side = re.findall(r'<path d="(M[^"]*)"/>', picture(score_of(analyze(f"r $ {HELIX}"))))
    assert (above.count("A"), side.count("L")) == (40, 80)


@pytest.mark.parametrize(
    ("program", "whole"),
    [("r $ repeat (up forward)", False), (f"r $ repeat ({HELIX})", False), ("r $ repeat (up down)", True)],
)
def test_an_endless_climb_is_dashed(program: str, whole: bool) -> None:
    assert path(program).whole is whole


@pytest.mark.slow("draws a long climb")
def test_a_small_picture_of_a_long_climb_stays_small() -> None:
    wild = "r $ repeat 10000 (forward fast 1.01 (left forward || up) fast 7/5 (halfright || scale 1/7 down))"
    for program in (wild, f"r $ repeat 500 ({HELIX})", "r $ slow 9999 up || repeat 9999 (forward || left)"):
        assert len(picture(score_of(analyze(program))).encode()) < LARGEST


@given(movements)
def test_pictures_are_small_and_well_formed(movement: Movement) -> None:
    small = picture(score_with(movement))
    assert len(small.encode()) < LARGEST
    ElementTree.fromstring(small)


def test_a_plot_has_room_for_what_stands_around() -> None:
    world = World((8, 4), (Wall(0, 1, 1, 1),), (Circle(-2, 0, 0.5),), (Box(2, -1, 2, 1, math.pi / 2),))
    drawn = ElementTree.fromstring(plot(replace(score_of(analyze("r $ forward")), world=world)))
    wide, high = (float(drawn.attrib[name]) for name in ("width", "height"))
    _, _, walls, circle, box, *_ = drawn
    # The floor's 8 m are as wide as there is room: 720 less two margins of 26.
    assert (wide, high) == (720, 52 + 668 / 2 + 28)
    metre = 668 / 8
    places = [place(26 + (x + 4) * metre, 26 + (2 - y) * metre) for x, y in ((0, 1), (1, 1), (-4, -2), (4, -2))]
    assert walls.attrib["d"].startswith("M{}L{}M{}L{}".format(*places))
    assert (circle.tag, circle.attrib["r"]) == (f"{SVG}circle", f"{metre / 2:.1f}")
    assert box.attrib["d"].split("L")[0] == f"M{place(26 + 6.5 * metre, 26 + 4 * metre)}"


def place(x: float, y: float) -> str:
    return " ".join(f"{value:.1f}".removesuffix(".0") for value in (x, y))


def dashed(program: str) -> tuple[int, int]:
    """The numbers of solid strokes and of dashed ones, which senses decide."""
    drawn = path(program)
    return drawn.certain, len(drawn.strokes) - drawn.certain


def test_strokes_after_an_until_are_guesses() -> None:
    """An endless movement is over after 4 beats, as far as pictures know."""
    check("r $ (until near repeat forward) left forward", (8, 0, 0), (8, 2, 0))
    assert dashed("r $ (until near repeat forward) left forward") == (1, 1)
    assert dashed("r $ (until near repeat forward) left forward\n---\nr $ left forward") == (1, 2)
    assert dashed("r $ (until near repeat slow 3 forward) left forward") == (1, 1)
    assert dashed("r $ (until near (forward left)) pause near (forward left) if near left else forward") == (3, 0)
    assert dashed("r $ up until near (repeat up) down") == (2, 1)
    assert dashed("r $ until cue repeat left\n---\nr $ forward left forward") == (0, 2)
    drawn = plot(score_of(analyze("r $ (until near repeat forward) left forward")), timeline=True)
    assert len(re.findall(r'<path d="[^"]*" stroke-dasharray="6 3"/>', drawn)) == 1
    assert [float(faint) for faint in re.findall(r'fill-opacity="([0-9.]+)"', drawn)] == [0.8] * 4 + [0.4] * 2


def test_pictures_end_where_a_robot_waits_forever() -> None:
    check("r $ forward pause not near (left forward) forward", (2, 0, 0))


def test_dice_fall_in_pictures_as_they_do_if_nothing_is_sensed() -> None:
    program = "r $ if near left else choose (forward left backward) shuffle (forward left backward right)"
    assert dashed(program) == (len(path(program).strokes), 0)
    for reaction in ("until near repeat", "if near left else repeat 3"):
        assert dashed(f"r $ {reaction} choose (forward left right)")[1] == 0


@pytest.mark.parametrize(
    ("program", "extent"),
    [
        ("r $ repeat 9 (forward left)", []),
        ("r $ repeat (forward left)", []),
        ("r $ repeat (forward left forward right)", ["the first 64 beats"]),
        ("r $ repeat 9000 (forward left forward right)", ["only the beginning"]),
        ("room 9 9\nr $ repeat (until near (repeat forward) left)", ["the first 120 beats"]),
    ],
)
def test_a_plot_of_a_part_of_the_paths_says_how_much_it_shows(program: str, extent: list[str]) -> None:
    score = score_of(analyze(program))
    drawn = plot(score, most_moments=1_000, prediction=predict(score) if score.open else None)
    assert re.findall(r'text-anchor="end"[^>]*>([^<]*)<', drawn) == extent


def test_a_timeline_has_scenes_by_their_names_and_numbers_of_beats_between_them() -> None:
    text = "r $ repeat 8 forward\n--- verse\nr $ repeat 30 left\n---\nr $ repeat 8 left"
    drawn = plot(score_of(analyze(text)), timeline=True)
    labels = re.findall(r'font-size="10">([^<]*)<', drawn)
    assert labels[:3] == ["scene 1", "verse", "scene 3"]
    assert labels[3:] == ["5", "7", *map(str, range(13, 39, 2)), "43", "45"]


def test_a_timeline_has_lines_at_bars_and_leaves_out_names_of_scenes_that_are_too_short() -> None:
    text = "bar 4\n--- introduction\nr $ left\n--- b\nr $ repeat 15 left"
    drawn = plot(score_of(analyze(text)), timeline=True)
    assert re.findall(r'font-size="10">([a-z]+)<', drawn) == ["b"]
    assert len(re.findall(r'stroke-opacity="0.8"', drawn)) == 4
