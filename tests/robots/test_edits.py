"""Edits of improv.toml that place or calibrate robots: the text before, and after."""

from __future__ import annotations

import math

import pytest

from improv_core.robots.config import read_robots
from improv_core.robots.edits import Start, calibrate, place

ANNA = (1.5004, -0.0001, 90.0)
AT = "start = { x = 1.5, y = 0, heading = 90 }"
"""In its usual form."""


def check(before: str, after: str | None, **starts: Start) -> None:
    made = place(before, starts, ("anna", "bert"))
    assert made == after
    for name, (x, y, heading) in starts.items() if made else ():
        start = read_robots(made or "").robots[name].start
        assert start is not None
        assert (start.x, start.y, math.degrees(start.heading)) == pytest.approx((x, y, heading), abs=0.0005)
        assert read_robots(made or "").ok


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", f"[robots.anna]\n{AT}\n\n[robots.bert]\n"),
        ("# ours\n[robots.carl]\n", f"# ours\n[robots.carl]\n\n[robots.anna]\n{AT}\n"),
        # It is listed without a start.
        (
            '[robots.anna] # she\nprofile = "turtlesim"\n',
            f'[robots.anna] # she\n{AT}\nprofile = "turtlesim"\n',
        ),
        ("[robots.anna]", f"[robots.anna]\n{AT}\n"),
        # It has a start.
        (
            '[robots.anna]\nstart = { x = 3 } # left\nprofile = "turtlesim"\n',
            f'[robots.anna]\n{AT} # left\nprofile = "turtlesim"\n',
        ),
        (
            "[robots.anna]\nstart = { x = 1, y = 2, heading = 3 }\n\n[robots.bert]\n",
            f"[robots.anna]\n{AT}\n\n[robots.bert]\n",
        ),
        # Lines end as the others do.
        ("[robots.anna]\r\n[robots.bert]\r\n", f"[robots.anna]\r\n{AT}\r\n[robots.bert]\r\n"),
        ("[robots.bert]\r\n", f"[robots.bert]\r\n\r\n[robots.anna]\r\n{AT}\r\n"),
        ("# ours\r\n[robots.anna]", f"# ours\r\n[robots.anna]\r\n{AT}\r\n"),
    ],
)
def test_a_robot_gets_its_start_and_the_rest_stays(before: str, after: str) -> None:
    check(before, after, anna=ANNA)


def test_several_robots_are_placed_at_once() -> None:
    check(
        "[robots.bert]\nstart = { x = 3 }\n[robots.carl]",
        "[robots.bert]\nstart = { x = 1, y = 2, heading = 3 }\n[robots.carl]\nstart = { x = 4, y = 5, heading = 6 }\n"
        f"\n[robots.anna]\n{AT}\n",
        anna=ANNA,
        carl=(4, 5, 6),
        bert=(1, 2, 3),
    )


@pytest.mark.parametrize(
    "text",
    [
        "[robots.anna.start]\nx = 1\n",
        "[robots.anna]\nstart.x = 1\n",
        "robots.anna = { }\n",
        '[robots]\nanna.profile = "turtlesim"\n',
        "robots = { bert = {} }\n",
        "robots = { anna = {} }\n",
        "robots = 3\n",
        "[[robots]]\n",
        "[robots\n",
    ],
)
def test_unusual_files_are_left_alone(text: str) -> None:
    check(text, None, anna=ANNA)


def test_an_impossible_name_is_not_written() -> None:
    check("", None, **{"anna]\n[ros": (1, 2, 3)})


CALIBRATED = {"commanded_step": 0.2105, "commanded_quarter_turn": 94.7, "left_right": 1.02}
LINES = "commanded_step = 0.2105\ncommanded_quarter_turn = 94.7\nleft_right = 1.02\n"


def check_calibrated(before: str, after: str | None) -> None:
    made = calibrate(before, "anna", CALIBRATED)
    assert made == after
    if made:
        robots = read_robots(made)
        assert robots.ok
        profile = robots.robots["anna"].profile
        found = profile.step * profile.linear_scale, profile.quarter_turn * profile.angular_scale, profile.left_right
        assert found == pytest.approx((0.2105, math.radians(94.7), 1.02))


def test_a_robot_with_a_built_in_profile_gets_one_of_its_own() -> None:
    check_calibrated(
        '# ours\n[robots.anna]\nprofile = "turtlebot4" # tall\nstart = { x = 1 }',
        '# ours\n[robots.anna]\nprofile = "anna" # tall\nstart = { x = 1 }\n\n'
        f'[profiles.anna]\nbase = "turtlebot4"\n{LINES}',
    )


def test_a_robot_without_a_profile_gets_one() -> None:
    made = calibrate("[robots.anna]\r\n", "anna", {"commanded_step": 2.1})
    added = "\r\n[profiles.anna]\r\nstep = 2\r\ncommanded_step = 2.1\r\n"
    assert made == f'[robots.anna]\r\nprofile = "anna"\r\n{added}'
    assert read_robots(made).ok


def test_a_profile_of_its_own_is_changed_where_it_is() -> None:
    check_calibrated(
        "[profiles.lab] # ours\nstep = 0.2\ncommanded_step = 0.21 # measured\nradius = 0.1\n\n"
        '[robots.anna]\nprofile = "lab"\n',
        "[profiles.lab] # ours\nstep = 0.2\ncommanded_step = 0.2105 # measured\nradius = 0.1\n"
        "commanded_quarter_turn = 94.7\nleft_right = 1.02\n\n"
        '[robots.anna]\nprofile = "lab"\n',
    )


@pytest.mark.parametrize("other", ['[robots.bert]\nprofile = "lab"\n', '[profiles.tall]\nbase = "lab"\n'])
def test_a_profile_that_others_use_stays_as_it_is(other: str) -> None:
    text = f'{other}[profiles.lab]\nstep = 0.2\n[robots.anna]\nprofile = "lab"\n'
    changed = text.replace('anna]\nprofile = "lab"', 'anna]\nprofile = "anna"')
    check_calibrated(text, f'{changed}\n[profiles.anna]\nbase = "lab"\n{LINES}')


def test_a_calibrated_profile_gets_a_name_that_is_free() -> None:
    text = '[profiles.anna]\nstep = 0.2\n[robots.bert]\nprofile = "anna"\n[robots.anna]\nprofile = "{}"\n'
    check_calibrated(
        text.format("anna"), text.format("anna_calibrated") + f'\n[profiles.anna_calibrated]\nbase = "anna"\n{LINES}'
    )


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[robots\n",
        "robots = 3\n",
        "[robots]\nanna = 3\n",
        "robots.anna = {}\n",
        'profiles = { lab = { step = 1 } }\n[robots.anna]\nprofile = "turtlebot4"\n',
        'profiles.lab = { step = 1 }\n[robots.anna]\nprofile = "lab"\n',
    ],
)
def test_calibration_leaves_unusual_files_alone(text: str) -> None:
    check_calibrated(text, None)
