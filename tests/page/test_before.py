"""Lines of the page before a dance begins: the part that a program lacks, and robots that are not in their places."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect

from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.safety.preflight import Standing, message
from improv_core.score.motion import Pose
from tests.page.conftest import Commands, Keep, asked, link, transport

ADA = {"ada": Standing(Pose(), Pose(2.0))}
ADVICE = "move ada 2.00 m toward 180°"


def test_the_page_lists_misplaced_robots_and_their_places_and_each_button_asks_for_what_it_says(
    still: Callable[..., Page], viewer: PageServer, commands: Commands
) -> None:
    page = still("ada bo $ forward\n", "[robots.ada]\nstart = { x = 0 }\n[robots.bo]\nstart = { y = 2 }\n")
    viewer.publish(message(ADA, 1))
    panel = page.get_by_role("region", name="Robots that are not in their places")
    lines = panel.get_by_role("listitem")
    expect(panel.get_by_role("heading")).to_have_text("Not in place")
    expect(lines).to_have_text([ADVICE])
    expect(page.locator("#news")).to_have_text(f"Not in place: {ADVICE}")
    for button, wanted in (("Play", {}), ("Begin anyway", {"anyway": True})):
        panel.get_by_role("button", name=button).click()
        assert asked(commands) == {"type": "resume", **wanted}
    viewer.publish(message({"bo": Standing(Pose(0.0, 2.0), None)}, 1))
    expect(lines).to_have_text(["nobody knows where bo stands: its poses have to arrive"])  # a place, but no arrow
    viewer.publish(message({f"r{number}": Standing(Pose(), Pose(1.0)) for number in range(30)}, 1))
    expect(lines).to_have_text([*(f"move r{number} 1.00 m toward 180°" for number in range(4)), "… and 26 more"])
    viewer.publish(message(None, 1))  # nothing waits for robots
    expect(panel).to_be_hidden()


def test_before_anything_plays_the_page_names_the_file_and_the_missing_part(
    page: Page, viewer: PageServer, keep: Keep
) -> None:
    hint = page.locator("#hint")
    viewer.publish({"type": "program", "name": "solo.improv", "folder": "/dances", "problems": [], "count": 0})
    page.goto(link(viewer))
    expect(hint).to_contain_text("Save solo.improv to see it dance")
    expect(hint).to_contain_text("solo.improv is in /dances")
    expect(page.locator("#timeline")).to_be_hidden()
    expect(page.locator("#score")).to_be_hidden()
    keep(page, "page-page.png")

    viewer.show(score_of(analyze("ada $ rest\n")), 1)
    viewer.publish(transport(1, "playing", 1.0))
    expect(hint).to_be_hidden()
    viewer.show(score_of(analyze("step = forward left\n")), 2)
    viewer.publish(transport(2, "ended", 0.0))
    expect(hint).to_contain_text("solo.improv has no robots")
    expect(hint).to_contain_text("Write the name of a robot, a dollar sign, and what it does.")
    viewer.show(score_of(analyze("ada $ rest\n")), 3)
    viewer.publish(transport(3, "playing", 1.0))
    expect(hint).to_be_hidden()
