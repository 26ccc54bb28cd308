"""The floor of the page: walls, obstacles, and meetings, whose marks modules/meetings.test.js tests; and its motion."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect

from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from tests.page.conftest import Commands, Keep, asked, at, box, transport, wait
from tests.page.looks import PIXEL

WALL, GROUND, MARK = "107,114,128", "251,250,247", "201,42,42"
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


def test_the_page_says_how_ideal_its_motion_is(still: Callable[..., Page], viewer: PageServer) -> None:
    motion = still("ada $ forward").locator("#dynamics")
    expect(motion).to_have_text("ideal motion")
    both, one = f"{MOTORS}bo.profile = 'real'\n", f"{MOTORS}bo = {{}}\n"
    for generation, robots, said in ((2, both, "with motors"), (3, one, "some with motors")):
        viewer.show(score_of(analyze("ada bo $ forward", read_robots(robots))), generation)
        viewer.publish(transport(generation, "paused"))
        expect(motion).to_have_text(said)


def test_a_click_on_a_mark_seeks_there(still: Callable[..., Page], commands: Commands, keep: Keep) -> None:
    page = still("ada at -4 0\nbo at 4 0 facing 180\nada bo $ repeat 4 forward\n")
    button = page.get_by_role("button", name="1 meeting ahead")
    expect(button).to_be_visible()  # as the server has found by now
    mark = at(page, 0, 0)
    page.reload()
    wait(page, f"({PIXEL})(0.03, 0) === '{MARK}'")  # beside its exclamation point
    page.mouse.move(*mark)
    keep(page, "page-meetings.png")
    page.mouse.click(*mark)
    seek = asked(commands)
    assert seek["type"] == "seek"
    assert 1.5 < seek["beat"] < 2
    page.mouse.down()
    page.mouse.move(mark[0] + 60, mark[1], steps=3)
    page.mouse.up()  # the view was moved: no click
    button.click()
    assert asked(commands) == seek
