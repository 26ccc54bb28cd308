"""What the page shows of the simulator's world: walls and obstacles, bumps, and how ideal it all is."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.stage.viewer.conftest import Show, wait, watch
from tests.stage.viewer.looks import COUNT, PIXEL

WALL, GROUND, BUMP = "107,114,128", "251,250,247", [201, 42, 42]
FACING = "[robots.ada]\nstart = {x=0,y=0}\n[robots.bo]\nstart = {x=3,y=0,heading=180}\n"


def check(page: Page, **colors: tuple[float, float]) -> None:
    """The color of the stage at each place, once it is painted."""
    for name, (x, y) in colors.items():
        wait(page, f"({PIXEL})({x}, {y}) === '{WALL if name.startswith('wall') else GROUND}'")


def test_walls_and_obstacles_are_drawn_where_they_are_and_in_view(page: Page, show: Show) -> None:
    world = """[world]
size = [10, 8]
walls = [[-4, -3, -2, -1]]
circles = [{ x = 2, y = -2, radius = 0.5 }]
boxes = [{ x = -3, y = 2, width = 2, height = 0.5, heading = 90 }]
"""
    show.play("ada $ rest", world)
    watch(page, show)
    check(page, wall_rim=(-5, 1), wall_line=(-3.02, -2.02), wall_circle=(2.4, -2), ground_beside=(2.6, -2.6))
    check(page, wall_box=(-3, 2.9), ground_box=(-2.3, 2.3))
    for x in (-5, 5):
        for y in (-4, 4):
            place = page.evaluate(f"improv.toScreen({x}, {y})")
            box = page.locator("#stage").bounding_box()
            assert box
            assert 0 < place["x"] < box["width"]
            assert 0 < place["y"] < box["height"]


def test_two_robots_that_drive_into_each_other_bump(page: Page, show: Show) -> None:
    show.play("beat 60\nada bo $ repeat 6 rest forward forward\n", FACING)
    watch(page, show)
    count = page.locator("#bumps")
    expect(count).to_be_hidden()
    wait(page, f"({COUNT})({BUMP}) > 60")
    expect(count).to_have_text("1 bump")
    expect(page.get_by_role("status")).to_have_text("ada and bo bumped into each other")
    wait(page, f"({COUNT})({BUMP}) === 0")  # although nothing moves any more
    page.get_by_role("button", name="Restart").click()
    expect(count).to_be_hidden()
    wait(page, f"({COUNT})({BUMP}) > 60")
    expect(count).to_have_text("1 bump")


def test_a_robot_that_drives_into_a_wall_bumps(page: Page, show: Show) -> None:
    show.play("beat 60\nada $ rest forward\n", "[world]\nsize = [3, 3]\n")
    watch(page, show)
    wait(page, f"({COUNT})({BUMP}) > 60")
    expect(page.locator("#bumps")).to_have_text("1 bump")
    expect(page.get_by_role("status")).to_have_text("ada bumped into an obstacle")
    wait(page, "Math.abs(improv.robots.ada.x - 1.2) < 0.01")  # a radius from the wall


def test_bumps_of_before_the_page_was_opened_are_counted_but_no_news(page: Page, show: Show) -> None:
    show.play("beat 60\nada bo $ forward forward repeat 6 rest left right repeat rest\n", FACING)
    watch(page, show)
    wait(page, "improv.beat > 6")
    page.reload()
    wait(page, "window.improv?.connected && improv.robots.ada")
    expect(page.locator("#bumps")).to_have_text("1 bump")
    expect(page.get_by_role("status")).not_to_contain_text("bumped")


MOTORS = "[profiles.real]\nbase = 'turtlebot4'\ndynamics = 'motors'\n[robots]\nada.profile = 'real'\n"


@pytest.mark.parametrize(
    ("program", "robots", "said"),
    [
        ("ada $ forward", "", "ideal motion"),
        ("ada $ forward", MOTORS, "with motors"),
        ("ada bo $ forward", f"{MOTORS}bo = {{}}\n", "some with motors"),
    ],
)
def test_the_page_says_how_ideal_its_motion_is(page: Page, show: Show, program: str, robots: str, said: str) -> None:
    show.play(program, robots)
    watch(page, show)
    expect(page.locator("#dynamics")).to_have_text(said)
