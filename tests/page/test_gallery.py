"""The tutorial, the dances to begin with, and links, on a page that a server shows."""

from __future__ import annotations

import http.client
import json
import re
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import expect

from improv_core.page.gallery import guide_files
from improv_core.page.server import PageServer
from tests.page.conftest import LIMIT
from tests.page.editing import Edit

PROGRAM = "ada $ forward\n"
WINDOWS = ((1280, 800), (1024, 683), (683, 384), (390, 844), (844, 390))


def ask(viewer: PageServer, path: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(viewer.address).port or 0, timeout=LIMIT)
    connection.request("GET", path)
    return connection.getresponse()


def test_a_server_has_the_tutorial_its_pictures_and_dances_without_robots_of_their_own(viewer: PageServer) -> None:
    examples = json.loads(ask(viewer, "/examples.json").read())
    assert {"square", "puppets"} <= {example["name"] for example in examples}
    assert [example for example in examples if example["toml"] or not example["picture"].startswith("<svg")] == []
    assert {each["name"]: len(each["bodies"]) for each in examples}["puppets"] == 2
    for name, content in guide_files().items():
        answer = ask(viewer, f"/{name}")
        assert (answer.status, answer.read()) == (200, content), name
    assert ask(viewer, "/guide.json").headers["Content-Type"] == "application/json"
    assert [ask(viewer, path).status for path in ("/images/none.svg", "/images/../../README.md")] == [404, 404]


@pytest.mark.slow("edits on a page")
def test_a_dance_is_taken_from_the_tutorial_and_the_gallery_and_passed_on(
    tmp_path: Path, edit: Callable[[str], Edit]
) -> None:
    (tmp_path / "improv.toml").write_text("[robots.ada]\n", encoding="utf-8")
    page = edit(PROGRAM).page()
    page.get_by_role("button", name="Tutorial").click()
    page.get_by_role("button", name="Take this").first.click()
    expect(page.locator("#text")).not_to_have_value(PROGRAM)
    page.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Examples").click()
    page.get_by_role("button", name="Stop").click(trial=True)  # nothing lies over it
    expect(page.locator("#examples").get_by_role("button", name="Close")).to_be_in_viewport(ratio=1)
    page.locator("#examples").get_by_role("button", name="puppets", exact=True).click()
    expect(page.locator("#highlight div").first).to_be_in_viewport()  # it says what the example shows
    expect(page.locator("#file-state")).to_have_text("not saved yet")
    assert page.evaluate("improv.transport.generation") == 0  # real robots might dance: that takes another press
    page.get_by_role("button", name="Share").click()
    expect(page.locator("#link")).to_be_hidden()
    page.get_by_label("Website").fill("https://example.org/improv/")
    expect(page.locator("#link")).to_have_value(re.compile("^https://example.org/improv/#dance="))


@pytest.mark.slow("shows the tutorial in five windows")
def test_a_program_of_the_tutorial_can_be_taken_without_scrolling(edit: Callable[[str], Edit]) -> None:
    page = edit(PROGRAM).page()
    page.get_by_role("button", name="Tutorial").click()
    card = page.get_by_role("dialog", name="Tutorial")
    for step in ("1. Play", "2. Change it", "3. Draw a curve"):
        for width, height in WINDOWS:
            page.set_viewport_size({"width": width, "height": height})
            page.get_by_label("Page", exact=True).select_option(step)
            expect(card.get_by_role("button", name="Take this").first).to_be_in_viewport(ratio=1)
            program = card.locator("pre.program").first
            program.scroll_into_view_if_needed()
            # Browsers clip a fraction of a pixel at its edges.
            expect(program).to_be_in_viewport(ratio=0.99)
