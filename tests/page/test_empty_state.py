"""The page's lines about a program that can't play, and about one that has not been saved yet."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from tests.page.conftest import Keep, link, transport


def test_before_anything_plays_the_page_names_the_file_and_the_missing_part(
    page: Page, viewer: PageServer, keep: Keep
) -> None:
    hint = page.locator("#hint")
    viewer.publish({"type": "program", "name": "solo.improv", "folder": "/dances", "problems": [], "count": 0})
    page.goto(link(viewer))
    expect(hint).to_contain_text("Save solo.improv to see it dance")
    expect(hint).to_contain_text("It is in /dances")
    expect(page.locator("#timeline")).to_be_hidden()
    expect(page.locator("#score")).to_be_hidden()
    keep(page, "page-waiting.png")

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
