"""Paths → programs: before, a program whose path is taken; after, the program that comes back."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from fractions import Fraction
from textwrap import dedent

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.path import pose_at
from improv_core.score.score import Score
from improv_core.transcription.track import TimedPlace
from improv_core.transcription.transcribe import Tolerance, Transcription, transcribe

CLEAN = Tolerance(0.001, math.radians(0.3), 0.01)
RATE = 20


def score_for(text: str) -> Score:
    analysis = analyze(dedent(text).strip() + "\n")
    assert analysis.ok, (text, analysis.diagnostics)
    return score_of(analysis)


def path_of(text: str, noise: tuple[float, float] = (0.0, 0.0), rate: int = RATE) -> Mapping[str, list[TimedPlace]]:
    """Return a program's ideal path, at `rate` places per second, with noise in meters and radians."""
    score, dice = score_for(text), random.Random(1)
    found: dict[str, list[TimedPlace]] = {}
    for robot, part in score.parts.items():
        seconds = Fraction(part.begins + part.movement.duration) * 60 / score.tempo
        found[robot] = []
        for number in range(int(seconds * rate) + 2):
            time = Fraction(number, rate)
            pose = pose_at(part, min(time, seconds) * score.tempo / 60)
            assert pose
            x, y, heading = (
                value + dice.gauss(0, deviation) if deviation else value
                for value, deviation in zip((pose.x, pose.y, pose.heading), (noise[0], *noise), strict=True)
            )
            found[robot].append(TimedPlace(float(time), x, y, pose.z, heading))
    return found


def farthest(path: Mapping[str, list[TimedPlace]], made: Transcription) -> float:
    """Return how far the program that was made is from a path at most, in meters."""
    score = score_for(made.text)

    def off(robot: str, place: TimedPlace) -> float:
        pose = pose_at(score.parts[robot], Fraction(place.time).limit_denominator(1000) * score.tempo / 60)
        assert pose
        return math.dist((place.x, place.y, place.z), (pose.x, pose.y, pose.z))

    return max(off(robot, place) for robot, places in path.items() for place in places)


def check(before: str, after: str | None = None, noise: tuple[float, float] = (0.0, 0.0)) -> Transcription:
    """Check that a program's path becomes `after` (itself, by default), near the path."""
    path = path_of(before, noise)
    made = transcribe(path, tolerance=Tolerance() if any(noise) else CLEAN)
    assert made.text == dedent(before if after is None else after).strip() + "\n"
    assert farthest(path_of(before), made) < (0.03 if any(noise) else 0.001)
    return made


@pytest.mark.parametrize(
    "program",
    [
        "a $ repeat 4 (forward left)",
        "a $ forward 1.5m left 60deg forward 40cm",
        "beat 100\n\na $ repeat 3 (forward (forward || halfright))",
        "a $ repeat 4 halfleft radius 60cm",
        "a $ repeat 2 [forward left] backward strafeleft rest up",
        "beat 90\n\na $ ease slow 2 forward ease repeat 4 (forward || left)",
        "a $ ramp 1/2 3/2 repeat 4 forward",
        "beat 100\n\na b c d $ canon 2 repeat 3 (forward halfleft)",
        "a b c at circle 2\n\na b c $ repeat 3 (forward right)",
        "a b c at line 1\n\na b c $ repeat 3 (forward right)",
        "a $ left radius 40cm forward left radius 40cm backward",
        "a $ repeat 3 (repeat 4 (forward || halfright) left strafeleft)",
    ],
)
def test_a_program_comes_back_from_its_path(program: str) -> None:
    check(program)


def test_a_mirror_image_gets_the_phrase_by_its_name() -> None:
    check(
        """
        steps = forward left 60deg forward 1m right forward (forward || halfleft)

        a $ steps
        b $ reflect sagittal steps
        """,
        """
        phrase = forward left 60deg forward 1m right forward (forward || halfleft)

        a $ phrase
        b $ reflect sagittal phrase
        """,
    )


@pytest.mark.parametrize("turned", ["retrograde", "reverse", "reverse retrograde", "reverse reflect sagittal"])
def test_a_phrase_that_comes_back_turned_gets_its_name(turned: str) -> None:
    before = f"phrase = forward left 60deg forward 1m right radius 40cm forward\n\na $ phrase rest {turned} phrase"
    check(before)


@pytest.mark.parametrize(
    "program",
    [
        "a $ slow 2 forward left slow 2 forward\nb $ slow 2 forward right slow 2 forward",
        "a $ forward left up forward rest forward left up backward forward left up",
    ],
)
def test_nothing_gets_a_name_that_would_hardly_make_it_shorter(program: str) -> None:
    assert " = " not in transcribe(path_of(program), tolerance=CLEAN).text


def test_starts_are_left_out_if_robots_start_there_anyway() -> None:
    lines = "b $ forward forward\na $ forward left\n"
    robots = read_robots("[robots.a]\nstart = { x = 1, y = -3 }")
    check(lines)
    check(f"a at 1 -3\nb at 0 0\n\n{lines}", f"b at 0 0\na at 1 -3\n\n{lines}")
    assert transcribe(path_of(f"a at 1 -3\n{lines}"), robots, CLEAN).text == lines


@pytest.mark.parametrize(
    "program",
    [
        "a $ repeat 4 (forward left)",
        "a $ repeat 2 (forward ease (left left))",
        "beat 80\n\na $ forward 80cm repeat 3 (ease (strafeleft right) forward)",
        "beat 80\n\na $ forward right repeat 3 (halfleft backward ease right radius 1m)",
        "beat 80\n\na $ left 60deg halfleft backward halfleft",
    ],
)
def test_noise_of_5_mm_and_1_degree_changes_nothing(program: str) -> None:
    made = transcribe(path_of(program, noise=(0.005, math.radians(1))))
    assert "a $ " + program.partition("$ ")[2] in made.text
    assert farthest(path_of(program), made) < 0.03


@pytest.mark.parametrize(
    "program",
    [
        "beat 90\na $ ramp 1/2 3/2 (retrograde (left 60deg ease (forward 1.5m forward left 60deg)) right forward 80cm)",
        "beat 100\na $ ease (fast 2 (ease (backward forward right 90deg radius 1m) forward 80cm) backward)",
    ],
)
def test_errors_of_velocities_that_change_all_the_time_do_not_add_up(program: str) -> None:
    path = path_of(program)
    assert farthest(path, transcribe(path, tolerance=CLEAN)) < 0.001


_INNER = "(forward || halfright) left 60deg ease (forward 80cm forward (forward || halfright) right)"
_BRISK = "forward 80cm right [strafeleft backward left (forward || halfright)]"
_ROUND = "ease (right 90deg radius 1m forward retrograde (left 180deg radius 50cm) rest) forward"


@pytest.mark.slow("a search takes seconds")
@pytest.mark.parametrize(
    "program",
    [
        "beat 120\na $ strafeleft ease (reflect sagittal (scale 1/2 (right 90deg radius 1m forward 1.5m)))"
        f" ease (halfleft left 60deg ramp 1/2 3/2 ({_INNER}))",
        f"a $ rest left strafeleft left 180deg radius 50cm fast 2 left ease (repeat 4 ({_BRISK}) strafeleft {_ROUND})",
    ],
)
def test_noise_hides_no_miss_that_is_outside_of_the_tolerance(program: str) -> None:
    made = transcribe(path_of(program, noise=(0.005, math.radians(1))))
    assert farthest(path_of(program), made) < 0.03


def test_robots_that_words_fit_keep_them_beside_one_that_they_do_not() -> None:
    path = dict(path_of("a $ repeat 4 (forward left)\nb $ repeat 4 forward", noise=(0.005, math.radians(1))))
    path["b"] = [
        place._replace(x=place.x + 0.3 * math.sin(2 * place.time**2), heading=math.sin(2 * place.time))
        for place in path["b"]
    ]
    made = transcribe(path, tempo=60)
    assert "a $ repeat 4 (forward left)\n" in made.text
    assert farthest({"b": path["b"]}, made) < 0.03


@pytest.mark.slow("a search takes seconds")
def test_amounts_stay_round_with_too_many_robots_for_one_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("improv_core.transcription.rounding._MAX_UNKNOWNS", 30)
    lines = [
        f"{robot} $ " + " ".join(f"forward {length + at}cm left {length + 5 * at}deg" for length in range(40, 140, 10))
        for at, robot in enumerate("ab")
    ]
    before = "\n".join(lines)
    made = transcribe(path_of(before, noise=(0.005, math.radians(1))))
    assert farthest(path_of(before), made) < 0.03
    assert len(made.text) < 1.2 * len(before)


@pytest.mark.slow("a search takes seconds")
def test_more_motions_than_samples_tell_of_end_in_a_program() -> None:
    phrase = "ease (repeat 2 (strafeleft right right) left) right 90deg radius 1m repeat 3 halfleft"
    path = path_of(f"beat 80\na $ repeat 4 ({phrase} left 180deg radius 50cm)")
    assert farthest(path, transcribe(path, tolerance=CLEAN)) < 0.001


def test_headings_come_from_the_path_if_there_are_none() -> None:
    path = [place._replace(heading=None) for place in path_of("a $ forward slow 4 left 180deg radius 1m")["a"]]
    assert farthest({"a": path}, transcribe({"a": path})) < 0.03


def test_a_robot_that_goes_back_does_not_turn_around() -> None:
    path = [place._replace(heading=None) for place in path_of("a $ forward backward")["a"]]
    assert transcribe({"a": path}, tolerance=CLEAN).text == "a $ forward backward\n"


def test_waypoints_are_reached_on_straight_lines() -> None:
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    made = transcribe({"a": [TimedPlace(2.0 * number, x, y) for number, (x, y) in enumerate(corners)]})
    assert made.text == "a $ slow 2 forward 1m repeat 3 (fast 2 left slow 3/2 forward 1m)\n"


def test_a_larger_tolerance_makes_a_drawing_fewer_and_rounder_movements() -> None:
    curve = [TimedPlace(number / 20, number / 50, 0.5 * math.sin(number / 20)) for number in range(200)]
    words = []
    for meters in (0.03, 0.1, 0.2):
        made = transcribe({"a": curve}, tolerance=Tolerance(meters), drawn={"a"})
        assert all(far <= meters for far, _ in made.deviations.values())
        words.append(len(made.text))
    assert words[0] > 1.5 * words[1] > 1.5 * words[2]


def test_uneven_samples_and_a_gap_change_nothing() -> None:
    places = path_of("a $ repeat 4 (forward left) rest", rate=100)["a"]
    kept = [place for number, place in enumerate(places) if number % 7 in (0, 3) and not 210 < number < 250]
    assert transcribe({"a": kept}, tolerance=CLEAN).text == "a $ repeat 4 (forward left)\n"


def test_a_tempo_that_was_given_is_kept() -> None:
    made = transcribe(path_of("a $ forward left"), tolerance=CLEAN, tempo=30)
    assert made.text == "beat 30\n\na $ [forward left]\n"
    made = transcribe(path_of("a $ forward left"), tolerance=CLEAN, tempo=120)
    assert made.text == "beat 120\n\na $ slow 2 forward slow 2 left\n"


WORDS = st.sampled_from(
    ["forward", "left", "halfright", "backward 80cm", "rest", "right 60deg", "left 90deg radius 1m"]
)


@settings(max_examples=20)
@given(st.lists(st.lists(WORDS, min_size=1, max_size=3), min_size=1, max_size=3))
def test_paths_of_random_programs_stay_the_same(phrases: list[list[str]]) -> None:
    text = "a $ forward " + " ".join(f"repeat 2 ({' '.join(phrase)})" for phrase in phrases)
    path = path_of(text)
    assert farthest(path, transcribe(path, tolerance=CLEAN)) < 0.001
