"""Strokes and held keys → words. Strokes are points of a shape, moved about as by a hand."""

from __future__ import annotations

import cmath
import math
import random
import re
from collections.abc import Sequence
from itertools import pairwise

import pytest

from improv_core.score.motion import Twist
from improv_core.score.profiles import DEFAULT
from improv_core.transcription.gestures import DrawnPoint, PressedKeys, words_drawn, words_performed

SPACING = 0.03
"""Meters between two points that a browser reports."""
TIP = 3 * cmath.exp(1j * math.pi / 3)
SPEEDS = Twist(x=2.0, yaw=math.pi / 2)


def lines(*corners: complex) -> list[complex]:
    found = [corners[0]]
    for here, after in pairwise(corners):
        count = round(abs(after - here) / SPACING)
        found += [here + (after - here) * (number + 1) / count for number in range(count)]
    return found


def arc(start: complex, heading: float, radius: float, degrees: float) -> list[complex]:
    """Return points along a circle from a place on, to the left if `degrees` are positive."""
    left = math.copysign(1, degrees)
    center = start + radius * left * 1j * cmath.exp(1j * math.radians(heading))
    count = round(radius * math.radians(abs(degrees)) / SPACING)
    step = math.radians(degrees) / count
    return [center + (start - center) * cmath.exp(1j * step * number) for number in range(count + 1)]


def stroke(places: Sequence[complex], tremor: float = 0.0, beats: float = 8.0) -> list[DrawnPoint]:
    hand = random.Random(1)
    return [
        DrawnPoint(beats * index / len(places), place.real + hand.gauss(0, tremor), place.imag + hand.gauss(0, tremor))
        for index, place in enumerate(places)
    ]


def check(places: Sequence[complex], words: str, tremor: float = 0.006) -> None:
    """Check the words for a shape, drawn exactly and by a hand, with one beat for each line and arc."""
    for each in (0.0, tremor):
        assert words_drawn(stroke(places, each), None, DEFAULT, 0)[1] == words


@pytest.mark.parametrize(
    ("places", "words"),
    [
        pytest.param(lines(0, 1.5), "forward 1.5m", id="line"),
        pytest.param(lines(0, 2, 2 + 2j, 2j, 0), "repeat 3 (forward left) forward", id="square"),
        pytest.param(lines(0, 3, TIP, 0), "repeat 2 (forward 3m left 120deg) forward 3m", id="triangle"),
        pytest.param(arc(0, 0, 1, 360), "left 360deg radius 1m", id="circle"),
        pytest.param(
            [*arc(0, 0, 1, 360), *arc(0, 0, 1, -360)], "left 360deg radius 1m right 360deg radius 1m", id="figure eight"
        ),
        pytest.param(
            [*lines(0, 2), *arc(2, 0, 0.5, -180), *lines(2 - 1j, 0 - 1j)],
            "forward right 180deg radius 50cm forward",
            id="hairpin",
        ),
    ],
)
def test_a_drawing_becomes_lines_and_arcs(places: list[complex], words: str) -> None:
    check(places, words)


@pytest.mark.parametrize(
    ("there", "words"),
    [
        pytest.param(lines(0, 2), "forward turn forward", id="line"),
        pytest.param(arc(0, 0, 1, 180), "left 180deg radius 1m turn right 180deg radius 1m", id="arc"),
    ],
)
def test_a_stroke_back_along_itself_is_drawn_there_and_back(there: list[complex], words: str) -> None:
    for tremor in (0.0, 0.006):
        drawn = words_drawn(stroke([*there, *there[-2::-1]], tremor), None, DEFAULT, 0)[1]
        assert re.sub(" (left|right) 180deg (?!radius)", " turn ", drawn) == words


@pytest.mark.parametrize("spacing", [15, 12, 9, 7, 4.8, 3.6, 2, 1])
def test_a_zigzag_has_corners_however_often_the_mouse_is_sampled(spacing: float) -> None:
    """The mouse moves by whole pixels, of which 87 are a meter."""
    tips = [(440, 500), (480, 440), (520, 500), (560, 440), (600, 500), (640, 440)]
    seen = [*(place for one, other in pairwise(tips) for place in _pixels(one, other, spacing)), tips[-1]]
    drawn = [complex(x / 87, -y / 87) for x, y in seen]
    words = words_drawn(stroke(drawn), None, DEFAULT, 0)[1]
    assert "radius" not in words
    assert words.count("forward") == 5


def _pixels(one: tuple[int, int], other: tuple[int, int], spacing: float) -> list[tuple[int, int]]:
    count = round(math.dist(one, other) / spacing)
    return [
        (round(one[0] + (other[0] - one[0]) * at / count), round(one[1] + (other[1] - one[1]) * at / count))
        for at in range(count)
    ]


def test_a_wave_becomes_arcs_rather_than_lines_with_corners() -> None:
    wave = [complex(number / 35, -0.57 * math.sin(number / 12)) for number in range(110)]
    words = (
        "forward 50cm left 135deg radius 30cm forward 90cm right 150deg radius 40cm forward 1m left 180deg radius 50cm"
    )
    assert words_drawn(stroke(wave, 0.006), None, DEFAULT, 0)[1] == words


def test_a_drawing_begins_where_the_hand_did_in_its_first_direction() -> None:
    start, words = words_drawn(stroke(lines(1.0437 + 1j, 1.0437 + 3j)), None, DEFAULT, 0)
    assert (round(start.x, 9), round(start.y, 9), start.heading, words) == (1, 1, math.pi / 2, "forward")


def test_a_drawing_begins_at_a_place_as_round_as_its_lengths_and_keeps_its_shape() -> None:
    drawn = lines(2.87 - 1.07j, 4.37 - 1.07j, 4.37 + 0.43j)
    start, words = words_drawn(stroke(drawn), None, DEFAULT, 0)
    assert (round(start.x, 9), round(start.y, 9), words) == (2.9, -1.1, "forward 1.5m left forward 1.5m")


def test_a_robot_first_turns_to_a_drawing() -> None:
    assert words_drawn(stroke(lines(0, 2j)), 0.0, DEFAULT, 0)[1] == "left forward"


def test_errors_of_a_hand_do_not_add_up() -> None:
    start, words = words_drawn(stroke(lines(0, 2.05, 2.05 + 2.04j, 4.1 + 2.04j, 4.1 + 4.1j), 0.01), None, DEFAULT, 0)
    assert words == "forward left forward right forward left forward"
    assert start.heading == 0


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (2, "slow 5/2 (forward 1m left 360deg radius 1m)"),
        (3, "slow 8/3 forward 1m slow 7/3 left 360deg radius 1m"),
    ],
)
def test_a_drawing_keeps_its_timing_on_a_grid(parts: int, words: str) -> None:
    slowly = [place for place in lines(0, 1) for _ in range(7)]
    drawn = stroke([*slowly, *arc(1, 0, 1, 360)], beats=5)
    assert words_drawn(drawn, None, DEFAULT, parts)[1] == words


@pytest.mark.parametrize("places", [[], [0j], [0j, 0.01 + 0j], [0j] * 50])
def test_a_tap_draws_nothing(places: list[complex]) -> None:
    assert words_drawn(stroke(places), None, DEFAULT, 0)[1] == ""


@pytest.mark.parametrize("seed", range(20))
def test_any_scribble_becomes_words_near_it(seed: int) -> None:
    hand = random.Random(seed)
    place, way, places = 0j, 1 + 0j, [0j]
    for _ in range(300):
        way *= cmath.exp(1j * hand.gauss(0, 0.25))
        place += way * SPACING
        places.append(place)
    _, words = words_drawn(stroke(places), None, DEFAULT, 0)
    assert 2 <= len(words.split()) < 100


def test_keys_become_words_on_the_grid() -> None:
    keys = [
        PressedKeys(0.05, 1, 0),
        PressedKeys(2.1, 1, 1),
        PressedKeys(3.9, 0, 0),
        PressedKeys(5.05, 0, -1),
        PressedKeys(6.02, 0, 0),
    ]
    words = words_performed(keys, 9.0, SPEEDS, DEFAULT, 2)
    assert words == "forward forward repeat 2 (forward || left) rest right"


def test_a_part_that_begins_later_begins_with_rests() -> None:
    assert words_performed([PressedKeys(4.0, -1, 0)], 5.1, SPEEDS, DEFAULT, 1) == "repeat 4 rest backward"


def test_a_slow_robot_moves_less_than_its_words() -> None:
    assert words_performed([PressedKeys(0, 1, 0)], 1, Twist(x=0.5, yaw=1), DEFAULT, 1) == "forward 50cm"


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ([(0, 1, 0), (0.1, 0, 0)], "fast 2 forward 1m"),
        (
            [(0, 1, 0), (0.1, 0, 0), (0.2, 1, 0), (0.24, 0, 0), (2, 0, 1), (2.1, 0, 0)],
            "fast 2 forward 1m slow 3/2 rest fast 2 halfleft",
        ),
        ([(1, 1, 0), (1.05, 1, 1), (2, 0, 1), (2.1, 0, 0)], "rest (forward || left)"),
        ([(0, 0, 0)], ""),
    ],
)
def test_a_key_that_is_only_tapped_is_held_for_one_part(keys: Sequence[tuple[float, int, int]], words: str) -> None:
    assert words_performed([PressedKeys(*each) for each in keys], 3, SPEEDS, DEFAULT, 2) == words
