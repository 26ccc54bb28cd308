"""What the page says of a program that can't play, and of one that is still to be saved."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect

from improv_core.stage.viewer.server import Viewer
from tests.ls.client import Client
from tests.stage.viewer.conftest import Show, link, wait, watch

URI = "file:///dances/solo.improv"


def test_a_wrong_save_shows_on_every_page_until_one_is_right(page: Page) -> None:
    with Client({"backend": "sim"}) as client:
        client.open(URI, "ada $ repeat forward\n")
        client.save(URI)
        (url,) = client.wait_for_page()
        page.goto(url)
        wait(page, "window.improv?.connected && improv.transport.state === 'playing'")
        problems = page.get_by_role("alert")
        expect(problems).to_be_hidden()
        client.change(URI, 2, {"text": "ada $ repeat forward\nbo $ forwrd left\n"})
        client.save(URI)
        expect(problems).to_contain_text("solo.improv can't play: fix an error and save it again")
        expect(problems.locator("li")).to_have_text("line 2forwrd`forwrd` is not defined: did you mean `forward`?")
        assert page.evaluate("improv.transport.state") == "playing"  # the previous dance
        page.reload()
        expect(problems.locator("code")).to_have_text("forwrd")
        client.change(URI, 3, {"text": "ada $ repeat forward\nbo $ forward left\n"})
        client.save(URI)
        expect(problems).to_be_hidden()


def test_before_anything_plays_the_page_names_the_file_and_shows_no_empty_panels(
    page: Page, viewer: Viewer, artifacts: Path
) -> None:
    viewer.publish({"type": "program", "name": "solo.improv", "folder": "/dances", "problems": []})
    page.goto(link(viewer))
    expect(page.locator("#hint")).to_contain_text("Save solo.improv to see it dance")
    expect(page.locator("#hint")).to_contain_text("It is in /dances")
    expect(page.locator("#timeline")).to_be_hidden()
    expect(page.locator("#score")).to_be_hidden()
    page.screenshot(path=artifacts / "page-waiting.png")


def test_a_program_without_robots_says_what_is_missing(page: Page, show: Show) -> None:
    show.play("ada $ rest\n")
    watch(page, show)
    expect(page.locator("#hint")).to_be_hidden()
    show.play("step = forward left\n")
    expect(page.locator("#hint")).to_contain_text("This program has no robots")
    expect(page.locator("#hint")).to_contain_text("Write the name of a robot, a dollar sign, and what it does.")
    show.play("ada $ rest\n")
    expect(page.locator("#hint")).to_be_hidden()


def test_escape_closes_help_without_a_stop(page: Page, show: Show) -> None:
    show.play("ada $ repeat forward\n")
    watch(page, show)
    page.keyboard.press("?")
    expect(page.locator("#help")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("#help")).to_be_hidden()
    assert page.evaluate("improv.transport.state") == "playing"
    page.keyboard.press("?")
    page.keyboard.press("Space")
    expect(page.locator("#state")).to_have_text("stopped")
