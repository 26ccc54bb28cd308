"""The world of the simulator on the page: walls and obstacles, and the line about ideal motion."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import box, wait
from tests.page.looks import PIXEL

WALL, GROUND, BUMP = "107,114,128", "251,250,247", [201, 42, 42]
FACING = "[robots.ada]\nstart = {x=0,y=0}\n[robots.bo]\nstart = {x=3,y=0,heading=180}\n"
MOTORS = "[profiles.real]\nbase = 'turtlebot4'\ndynamics = 'motors'\n[robots]\nada.profile = 'real'\n"


def check(page: Page, **colors: tuple[float, float]) -> None:
    """Compare the color of the stage at each place, once it is painted."""
    for name, (x, y) in colors.items():
        wait(page, f"({PIXEL})({x}, {y}) === '{WALL if name.startswith('wall') else GROUND}'")


def test_walls_and_obstacles_are_drawn_in_place_and_in_view(still: Callable[..., Page]) -> None:
    world = """[world]
size = [10, 8]
walls = [[-4, -3, -2, -1]]
circles = [{ x = 2, y = -2, radius = 0.5 }]
boxes = [{ x = -3, y = 2, width = 2, height = 0.5, heading = 90 }]
"""
    page = still("ada $ rest", world)
    check(page, wall_rim=(-5, 1), wall_line=(-3.02, -2.02), wall_circle=(2.4, -2), ground_beside=(2.6, -2.6))
    check(page, wall_box=(-3, 2.9), ground_box=(-2.3, 2.3))
    for x in (-5, 5):
        for y in (-4, 4):
            place = page.evaluate(f"improv.toScreen({x}, {y})")
            stage = box(page, "#stage")
            assert 0 < place["x"] < stage["width"]
            assert 0 < place["y"] < stage["height"]


@pytest.mark.parametrize(
    ("program", "robots", "said"),
    [
        ("ada $ forward", "", "ideal motion"),
        ("ada $ forward", MOTORS, "with motors"),
        ("ada bo $ forward", f"{MOTORS}bo = {{}}\n", "some with motors"),
    ],
)
def test_the_page_says_how_ideal_its_motion_is(
    still: Callable[..., Page], program: str, robots: str, said: str
) -> None:
    expect(still(program, robots).locator("#dynamics")).to_have_text(said)
