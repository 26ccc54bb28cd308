"""The floor of the page: walls, obstacles, and meetings, whose marks modules/meetings.test.js tests; and its motion."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from tests.page.conftest import Keep, Show, at, begin_paused, box, play_anew, wait
from tests.page.looks import PIXEL

PROGRAM = "ada $ rest\n"
WALL, GROUND, MARK = "107,114,128", "251,250,247", "201,42,42"
MOTORS = "[profiles.real]\nbase = 'turtlebot4'\ndynamics = 'motors'\n[robots]\nada.profile = 'real'\n"


def check(page: Page, **colors: tuple[float, float]) -> None:
    """Compare the color of the stage at each place, once it is painted."""
    for name, (x, y) in colors.items():
        wait(page, f"({PIXEL})({x}, {y}) === '{WALL if name.startswith('wall') else GROUND}'")


def test_walls_and_obstacles_are_drawn_in_place_and_in_view(shared: tuple[Show, Page]) -> None:
    show, page = shared
    world = """[world]
size = [10, 8]
walls = [[-4, -3, -2, -1]]
circles = [{ x = 2, y = -2, radius = 0.5 }]
boxes = [{ x = -3, y = 2, width = 2, height = 0.5, heading = 90 }]
"""
    play_anew(page, show, PROGRAM, world)
    check(page, wall_rim=(-5, 1), wall_line=(-3.02, -2.02), wall_circle=(2.4, -2), ground_beside=(2.6, -2.6))
    check(page, wall_box=(-3, 2.9), ground_box=(-2.3, 2.3))
    stage = box(page, "#stage")
    for x in (-5, 5):
        for y in (-4, 4):
            inside = f"x > 0 && y > 0 && x < {stage['width']} && y < {stage['height']}"
            wait(page, f"(({{ x, y }}) => {inside})(improv.toScreen({x}, {y}))")


def test_the_page_says_how_ideal_its_motion_is(shared: tuple[Show, Page]) -> None:
    show, page = shared
    both, one = f"{MOTORS}bo.profile = 'real'\n", f"{MOTORS}bo = {{}}\n"
    for robots, motion in (("", "ideal motion"), (both, "with motors"), (one, "some with motors")):
        play_anew(page, show, "ada bo $ rest", robots)
        expect(page.locator("#dynamics")).to_have_text(motion)


def test_a_click_on_a_mark_seeks_there(shared: tuple[Show, Page], keep: Keep) -> None:
    show, page = shared
    begin_paused(page, show, "ada at -4 0\nbo at 4 0 facing 180\nada bo $ repeat 4 forward\n")
    button = page.get_by_role("button", name="1 meeting ahead")
    wait(page, f"({PIXEL})(0.03, 0) === '{MARK}'")  # beside its exclamation point
    mark = at(page, 0, 0)
    page.mouse.move(*mark)
    keep(page, "page-meetings.png")
    page.mouse.click(*mark)
    wait(page, "improv.transport.beat > 1.5 && improv.transport.beat < 2")
    beat = page.evaluate("improv.transport.beat")
    page.keyboard.press("Home")
    wait(page, "improv.transport.beat === 0")
    page.mouse.down()
    page.mouse.move(mark[0] + 60, mark[1], steps=3)
    page.mouse.up()  # the view was moved: no click
    page.keyboard.press("ArrowRight")
    wait(page, "improv.transport.beat === 1")
    button.click()
    wait(page, f"improv.transport.beat === {beat}")
