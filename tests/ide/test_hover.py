"""Hovers: the marked text, and the description."""

from __future__ import annotations

from base64 import b64decode
from xml.etree import ElementTree

import pytest

from improv_core.ide.hover import hover
from improv_core.robots.config import read_robots
from tests.ide.cursor import at_cursor


def check(program: str, marked: str, *said: str, robots: str = "") -> None:
    """Check that hovering at the cursor marks a text and shows each of these."""
    analysis, offset = at_cursor(program)
    analysis = analysis.with_robots(read_robots(robots)).settled()
    found = hover(analysis, offset)
    assert found
    assert analysis.text[found.span.start : found.span.end] == marked
    for part in said:
        assert part in found.markdown


def check_nothing(program: str) -> None:
    assert hover(*at_cursor(program)) is None


def test_hovers_describe_words() -> None:
    check("r $ for|>ward", "forward", "**forward**: One step forward.", "1 beat, 1.0 s at beat 60 · 2.0 m, no turn")
    check("beat 30\nr $ |>halfright", "halfright", "1 beat, 2.0 s at beat 30 · 0.0 m, turns 45° right")
    check("b|>eat 92.5", "beat", "**beat 92.5**")


def test_the_hover_of_a_transformer_describes_its_term() -> None:
    check("r $ re|>peat 4 (forward left)", "repeat 4 (forward left)", "**repeat 4**", "8 beats", "turns 360° left")
    check("r $ fast |>3/2 left right", "fast 3/2 left", "2/3 beats, 0.67 s")
    check("r $ reflect Y|>Z left", "reflect YZ left", "Swaps left and right", "turns 90° right")
    check("r $ repeat le|>ft", "left", "1 beat")
    check("r $ rep|>eat left", "repeat left", "∞, endless at beat 60 · continues forever")


def test_hovers_describe_measures() -> None:
    check("r $ for|>ward 3/2m", "forward 3/2m", ": 1.5 m forward in 1 beat", "60 · 1.5 m, no turn")
    circle = "left 360/5deg radius 60cm"
    check(
        f"r $ {circle[:-1]}|>m", circle, ": 72° left in 1 beat, along a circle with a radius of 60 cm", "turns 72° left"
    )
    check("p n = strafeleft n*|>1m", "strafeleft n*1m", ": n*1 m to the left in 1 beat")


def test_hovers_describe_brackets() -> None:
    check("r $ |>[forward left] right", "[forward left]", "squeezed: 2 items, 2 times as fast", "1 beat, 1.0 s")
    check(
        "r $ [forward left || left|>]",
        "[forward left || left]",
        "2 items, 2 times as fast and 1 item, at its normal speed",
    )
    check("r $ |>(forward left)", "(forward left)", "2 beats")


def test_hovers_of_names_show_their_definitions() -> None:
    program = "x = forward\nx = x left\nr $ |>x"
    check(program, "x", "(name, line 2)", "x = x left", "2 beats")
    check("x = forward\nx = |>x left", "x", "(name, line 1)", "1 beat")


def test_hovers_of_robots_and_signs_describe_everything_played() -> None:
    check("|>r $ forward\nr $ left", "r", "robot, profile turtlesim", "2 beats")
    check("r1 r2 |>$ forward", "$", "r1, r2 play what follows", "1 beat")
    check("x |>= forward", "=", "`x` is the name for what follows")
    check("r $ forward |>|| left", "forward || left", "play at the same time", "2.0 m, turns 90° left")


def test_nothing_to_show() -> None:
    check_nothing("r $ left # |> comment")
    check_nothing("r $ |>nobody")
    check_nothing("r $ left\n\n|>")


def test_huge_durations_are_shown_at_once() -> None:
    huge = "repeat 1000000000 (repeat 1000000000 (forward left))"
    check(f"r $ |>{huge}", huge, "2000000000000000000 beats", "2,000,000,000,000,000,000.0 m")


def test_hovers_describe_the_end_of_a_movement() -> None:
    check("r $ |>(forward left forward)", "(forward left forward)", "4.0 m", "ends 2.0 m ahead, 2.0 m left, facing 90°")
    check("r $ |>repeat 4 (forward left)", "repeat 4 (forward left)", "ends where it began")


def test_hovers_show_the_rate_in_brackets() -> None:
    check("x = forward\nr $ [|>x left]", "x", "1 beat", "twice as fast in this bracket: 0.5 beats, 0.50 s")
    check("r $ [forward [left ri|>ght] left]", "right", "6 times as fast here: 1/6 beats, 0.17 s")
    check("r $ [forward left || le|>ft]", "left", "1 beat")
    check("r $ slow 2 (le|>ft)", "left", "half as fast here: 2 beats")
    check("r $ fast 2 [|>(left) right up]", "(left)", "6 times as fast here")
    assert "as fast" not in said("r $ [le|>ft || up] right")


def test_the_top_speed_against_the_robots_limit() -> None:
    robots = '[robots.r]\nprofile = "turtlebot3_burger"\n[robots.s]\nprofile = "turtlebot3_waffle"\n'
    one = "top speed 0.4 of 0.22 m/s, 1.57 of 2.84 rad/s"
    assert one in said("beat 120\nr |>$ forward slow 2 left", robots)
    assert one in said("beat 120\n|>r s $ forward slow 2 left", robots)
    both = said("r s |>$ repeat (forward || left)", robots)
    assert "r: top speed 0.2 of 0.22 m/s, 1.57 of 2.84 rad/s" in both
    assert "s: top speed 0.2 of 0.26 m/s, 1.57 of 1.82 rad/s" in both
    assert "top speed 6 m/s, 4.71 rad/s" in said(
        "r |>$ [forward left forward] reverse fast 2 scale 1/2 forward || rest"
    )
    assert "stands still" in said("r |>$ rest")


def said(program: str, robots: str = "") -> str:
    analysis, offset = at_cursor(program)
    found = hover(analysis.with_robots(read_robots(robots)).settled(), offset)
    assert found
    return found.plain


def test_plain_text_has_no_marks() -> None:
    assert said("x = [left up]\nr $ |>x") == (
        "x (name, line 1)\nx = [left up]\n1 beat, 1.0 s at beat 60 · 2.0 m, turns 90° left\n"
        "ends 2.0 m up, facing 90° left"
    )
    assert said("x |>= left").startswith("=: x is the name for what follows\n")


@pytest.mark.parametrize(
    "program",
    [
        "r $ forw|>ard",
        "|>r $ left forward",
        "r |>$ repeat (forward halfleft)",
        "r $ |>repeat 1000000000 (forward || repeat 7 halfleft)",
        "x = (forward || left) (forward || right)\nr $ repeat 1000 [|>x scale 3 x]",
        "x = repeat 900 (fast 3 forward halfleft scale 1/7 (forward || right))\nr $ |>x",
        f"{'x' * 90_000} = up forward\nr $ |>{'x' * 90_000}",
    ],
)
def test_the_picture_is_small(program: str) -> None:
    found = hover(*at_cursor(program), pictures=True)
    assert found
    ElementTree.fromstring(found.picture)
    assert len(found.picture) < 20_000
    assert len(found.markdown) < 90_000
    image, _, size = found.markdown.rpartition("](data:image/svg+xml;base64,")[2].partition("|")
    assert b64decode(image).decode() == found.picture
    assert size.startswith("width=")
    assert "data:" not in found.plain


def test_standing_still_has_no_picture() -> None:
    for program in ("r $ le|>ft", "r |>$ rest up", "be|>at 60", "r $ [|>]"):
        found = hover(*at_cursor(program), pictures=True)
        assert found is None or not found.picture


POLY = "x = up\n# A polygon with\n#  n sides.\npoly n = repeat n (forward scale 4/n left)\n"
ANSWER = "answer (m) = m reflect sagittal m\n"


def test_a_phrase_shows_its_head_its_comment_and_this_use() -> None:
    program = f"{POLY}r $ |>poly 5 left"
    source = "# A polygon with\n# n sides.\npoly n = repeat n (forward scale 4/n left)"
    check(program, "poly 5", "**poly 5** (phrase, line 4)", source, "10 beats", "10.0 m, turns 360° left")
    check(f"{POLY}r $ [poly |>5 left]", "poly 5", "**poly 5**", "twice as fast in this bracket: 5 beats")
    check(f"{ANSWER}r $ an|>swer forward", "answer forward", "**answer** (phrase, line 1)", "2 beats", "4.0 m")
    check(f"{ANSWER}r $ answer for|>ward", "forward", "1 beat")
    assert hover(*at_cursor(program), pictures=True) != hover(*at_cursor(program))
    assert said(POLY.replace("poly n", "|>poly n")) == "poly n (phrase)"


def test_parameters_and_nodes_that_depend_on_them() -> None:
    check(POLY.replace("repeat n", "repeat |>n"), "n", "**n** (parameter of `poly n`): a number")
    check(POLY.replace("poly n", "poly |>n"), "n", "**n** (parameter of `poly n`): a number")
    check(ANSWER.replace("= m", "= |>m"), "m", "**m** (parameter of `answer (m)`): a movement")
    assert said(POLY.replace("repeat", "re|>peat")).startswith("repeat n: Repeats this many times")
    assert "beat," not in said(POLY.replace("repeat", "re|>peat"))
    check(POLY.replace("forward", "for|>ward"), "forward", "1 beat")


def test_the_hover_of_a_scene_has_its_first_beat_and_its_length() -> None:
    check("beat 30\nr $ slow 3/2 up\n--|>-\ns $ up", "---", "**---**: a new scene", "begins at beat 3, after 4.0 s")
    check("r $ up\n--|>-\ns $ up\nr $ up up", "---", "this scene: 2 beats, 2.0 s")
    check("--|>- intro\ns $ up", "--- intro", "this scene: 1 beat, 1.0 s")
    check("r $ repeat up\n|>---\ns $ up", "---", "never begins")
    check("|>---", "---", "never begins")


def test_hovers_show_the_lengths_of_words_of_senses() -> None:
    check(
        "r $ un|>til near (forward forward)",
        "until near (forward forward)",
        "**until near**",
        "at most 2 beats, at most 2.0 s",
    )
    check(
        "r $ pa|>use not near forward left",
        "pause not near forward",
        "**pause not near**",
        "1 beat or more, 1.0 s or more",
    )
    check(
        "r $ i|>f bump left else repeat 3 left",
        "if bump left else repeat 3 left",
        "1 to 3 beats, 1.0 to 3.0 s at beat 60",
    )
    check("r $ until cue re|>peat left", "repeat left", "∞, endless")
    check("x = until cue repeat left\nr $ |>x left", "x", "any number of beats  \n`until cue` decides")
    check(
        "|>r $ (until cue repeat left) pause bump if near left else up",
        "r",
        "`until cue` and `pause bump` and `if near` decide",
    )


def test_durations_add_up_over_scenes() -> None:
    check("r $ until cue repeat rest\n-|>--\nr $ left", "---", "begins at beat 1, after 0.0 s or later")
    check("|>r $ until cue repeat rest\n---\nr $ left", "r", "1 beat or more", "this line: any number of beats")
    check("|>r $ (until bump (left left)) left\n---\nr $ left", "r", "2 to 4 beats")
    check("r $ repeat (until cue repeat rest)\n-|>--\nr $ left", "---", "never begins")
    check_nothing("r $ left -|>--")


def test_hovers_describe_senses_and_their_sources() -> None:
    check("r $ until ne|>ar left", "near", "**near** (sense): Something is ahead of the robot", "in the simulator")
    check("r $ if not c|>ue left else right", "cue", "**cue** (sense): Somebody gives the cue")
    check("f near = until ne|>ar repeat scale near left", "near", "(sense)")
    check_nothing("r $ until fi|>re left")


BURGERS = """
[robots.anna]
profile = "turtlebot3_burger"
[robots.bob]
profile = "turtlesim"
"""


def test_distances_are_those_of_the_robots_that_play() -> None:
    check("|>x = forward\ny = x\nanna $ y", "x", "1 beat, 1.0 s at beat 60 · 0.2 m, no turn", robots=BURGERS)
    check("x = forward\n|>x = x left\nbob $ x", "x", "· 2.0 m, turns 90° left", robots=BURGERS)
    check("|>x = forward\nx = left\nanna $ x", "x", "anna: 0.2 m", "bob: 2.0 m", robots=BURGERS)  # nobody plays it
    check("x = for|>ward\nbob $ x\nanna $ x", "forward", "at beat 60  \n", "bob: 2.0 m", "anna: 0.2 m", robots=BURGERS)
    check("x = le|>ft\nbob anna $ x", "left", "· 0.0 m, turns 90° left", robots=BURGERS)
    check("|>x = forward", "x", "· 0.2 m", robots=BURGERS.split("[robots.bob]")[0])


def test_a_hover_says_that_a_word_is_missing() -> None:
    missing = "`lft` in line 1 is not defined"
    for program in ("|>r $ repeat 4 (up lft)", "r |>$ repeat 4 (up lft)", "r $ re|>peat 4 (up lft)"):
        check_missing(program, missing)
    for line in ("|>r $ side side", "r |>$ side side", "r $ (|>side) up", "r $ rep|>eat 4 side"):
        check_missing(f"side = up lft\n{line}", missing)
    check_missing("x = up\nx = x (\n|>r $ x", "line 2 has an error")
    check("r $ repeat 4 (u|>p lft)", "up", "1 beat")
    check("side = up lft\nr $ repeat 4 (u|>p) side", "up", "1 beat")


def check_missing(program: str, why: str) -> None:
    """Check that a hover says why nothing is known, and neither a length nor a path."""
    found = hover(*at_cursor(program), pictures=True)
    assert found
    assert (found.facts, found.picture) == ((why,), "")
