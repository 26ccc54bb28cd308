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


def test_lines() -> None:
    check("r $ forward left forward", (2, 0, 0), (2, 2, 0))


def test_repetitions_are_drawn_once() -> None:
    check("r $ repeat 40 (forward left)", (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 0))


def test_turning_while_going_is_an_arc() -> None:
    check("r $ forward || left", (1.2732395447, 1.2732395447, 1.2732395447))


def test_a_circle_is_three_arcs_and_leads_back() -> None:
    strokes = path("r $ fast 1 (repeat 4 forward) || repeat 4 left").strokes
    assert [stroke.radius for stroke in strokes] == [pytest.approx(1.2732395447)] * 3
    assert (strokes[-1].end.x, strokes[-1].end.y) == pytest.approx((0, 0), abs=1e-9)


def test_nothing_moves() -> None:
    check("r $ left rest right")
    ElementTree.fromstring(picture(score_of(analyze("r $ left"))))


def test_endless_paths_are_cut_off_and_dashed_unless_they_close() -> None:
    away, around = path("r $ repeat (forward left forward right)"), path("r $ repeat (forward halfleft)")
    assert (len(away.strokes), away.whole) == (32, False)
    assert (len(around.strokes), around.whole) == (8, True)


@given(finite_movements)
def test_a_path_ends_where_the_robot_does(movement: Movement) -> None:
    drawn = paths(score_with(movement))[0]
    expected = pose_at(part_of(movement), 10**6)
    assert expected is not None
    if drawn.whole:
        assert (drawn.end.x, drawn.end.y) == pytest.approx((expected.x, expected.y), abs=1e-6)


@given(movements)
def test_pictures_are_small_and_well_formed(movement: Movement) -> None:
    small = picture(score_with(movement))
    assert len(small.encode()) < LARGEST
    ElementTree.fromstring(small)


def test_a_plot_has_names_scale_and_timeline_and_escapes_words() -> None:
    drawn = plot(score_of(analyze("anna bert $ forward [left right]")), timeline=True)
    ElementTree.fromstring(drawn)
    assert re.findall(r"<text[^>]*>([^<]*)</text>", drawn) == ["anna", "bert", "0.5 m", "anna", "bert"]
    assert re.findall(r"<title>([^<]*)</title>", drawn)[1:4] == ["forward", "left", "right"]


@pytest.mark.parametrize(
    ("program", "wide", "high"),
    [
        ("r $ slow 4 forward || repeat 4 left", 2, 2),  # three arcs, whose ends are not where it is widest
        ("r $ slow 4 forward || repeat 9 left", 2, 2),
        ("r $ halfleft (slow 2 forward || left left)", 1 + 0.5**0.5, 1 + 0.5**0.5),
        ("r $ slow 2 forward || right right", 1, 2),
    ],
)
def test_an_arc_fills_its_picture_and_does_not_leave_it(program: str, wide: float, high: float) -> None:
    """The size of the path in radii of the arc."""
    drawn = plot(score_of(analyze(program)))
    radius = (720 - 52) / max(wide, high)
    assert f"A{place(radius, radius)} 0 0" in drawn
    sizes = (float(value) for value in re.findall(r'(?:width|height)="([^"]*)"', drawn)[:2])
    assert tuple(sizes) == pytest.approx((52 + wide * radius, 52 + high * radius + 28), abs=0.1)


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
    "program",
    [
        "anna $ forward left forward left forward left forward\n",
        "ada $ repeat 4 (backward halfleft)\n",
        "a_robot_with_a_long_name $ forward\n",
        "anna $ forward left forward\nbert $ right forward\ncarla $ backward\ndora $ left forward\n",
    ],
)
def test_names_are_inside_a_plot_and_off_the_paths_and_each_other(program: str) -> None:
    drawn = ElementTree.fromstring(plot(score_of(analyze(program))))
    wide = float(drawn.attrib["width"])
    names = [each for each in drawn.iter(f"{SVG}text") if each.text in program.split()]
    boxes = [
        (float(name.attrib["x"]), float(name.attrib["y"]) - 9, float(name.attrib["x"]) + 6 * len(name.text or ""))
        for name in names
    ]
    assert all(left >= 0 and top >= 0 and right <= wide for left, top, right in boxes)
    ends = [tuple(map(float, end.split())) for end in re.findall(r"[ML]([\d.]+ [\d.]+)", lines(drawn))]
    for left, top, right in boxes:
        assert not [(x, y) for x, y in ends if left < x < right and top < y < top + 9]
    for place, (left, top, right) in enumerate(boxes):
        for other_left, other_top, other_right in boxes[:place]:
            assert right <= other_left or other_right <= left or abs(top - other_top) >= 9


def lines(drawn: ElementTree.Element) -> str:
    """The data of all paths but the ground and the scale."""
    return "".join(each.attrib["d"] for group in drawn.iter(f"{SVG}g") for each in group.iter(f"{SVG}path"))


def test_a_plot_has_a_ground_and_a_start_that_shows_under_an_end() -> None:
    drawn = ElementTree.fromstring(plot(score_of(analyze("r $ repeat 4 (forward left)"))))
    _, ground, *_ = drawn
    assert ground.attrib == {"d": f"M0 0H{drawn.attrib['width']}V{drawn.attrib['height']}H0Z", "fill": "#ffffff"}
    (ring,) = drawn.iter(f"{SVG}circle")
    assert float(ring.attrib["r"]) > 5
