"""A robot is dragged on the page: what improv.toml says before, and after the edit."""

from __future__ import annotations

import math

import pytest

from improv_core.placing import place
from improv_core.robots import read_robots


def check(before: str, after: str | None, cast: tuple[str, ...] = ("anna", "bert")) -> None:
    edit = place(before, "anna", 1.504, -0.001, 90, cast)
    made = edit and before[: edit.span.start] + edit.text + before[edit.span.end :]
    assert made == after
    if made:
        start = read_robots(made).robots["anna"].start
        assert start is not None
        assert (start.x, start.y, start.heading) == pytest.approx((1.5, 0, math.pi / 2))
        assert read_robots(made).ok


def test_no_file_yet() -> None:
    check("", "[robots.anna]\nstart = { x = 1.5, y = 0, heading = 90 }\n\n[robots.bert]\n")


def test_other_robots_are_listed() -> None:
    check(
        "# ours\n[robots.carl]\n",
        "# ours\n[robots.carl]\n\n[robots.anna]\nstart = { x = 1.5, y = 0, heading = 90 }\n",
    )


def test_listed_without_a_start() -> None:
    check(
        '[robots.anna] # she\nprofile = "turtlesim"\n',
        '[robots.anna] # she\nstart = { x = 1.5, y = 0, heading = 90 }\nprofile = "turtlesim"\n',
    )
    check("[robots.anna]", "[robots.anna]\nstart = { x = 1.5, y = 0, heading = 90 }\n")


def test_with_a_start() -> None:
    check(
        '[robots.anna]\nstart = { x = 3 } # left\nprofile = "turtlesim"\n',
        '[robots.anna]\nstart = { x = 1.5, y = 0, heading = 90 } # left\nprofile = "turtlesim"\n',
    )


@pytest.mark.parametrize("text", ["[robots.anna.start]\nx = 1\n", "robots.anna = { }\n", "[robots\n"])
def test_what_is_left_to_its_author(text: str) -> None:
    check(text, None)
