"""The simulator's world on the page: walls and obstacles, bumps, and the line about ideal motion."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.score.motion import Twist
from tests.page.conftest import wait
from tests.page.looks import COUNT, PIXEL

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
            box = page.locator("#stage").bounding_box()
            assert box
            assert 0 < place["x"] < box["width"]
            assert 0 < place["y"] < box["height"]


@pytest.mark.slow("a browser on a busy machine")
def test_two_robots_that_drive_into_each_other_bump(still: Callable[..., Page], simulator: Simulator) -> None:
    page = still("beat 60\nada bo $ rest\n", FACING)  # no mark shows before that they will meet
    count = page.locator("#bumps")
    expect(count).to_be_hidden()
    simulator.send("ada", Twist(1.0), 0.0)
    simulator.advance(3.0)
    wait(page, f"({COUNT})({BUMP}) > 60")
    expect(count).to_have_text("1 bump")
    expect(page.get_by_role("status")).to_have_text("ada and bo bumped into each other")
    wait(page, f"({COUNT})({BUMP}) === 0")  # although nothing moves anymore
    page.reload()
    wait(page, "window.improv?.connected && improv.robots.ada")
    expect(count).to_have_text("1 bump")
    expect(page.get_by_role("status")).not_to_contain_text("bumped")  # that was before the page was opened


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
