"""From a save in an editor to the page in a browser, and from the page's button back to the robots."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.ls.client import Client
from tests.page.conftest import Keep, wait

URI = "file:///dance.improv"
DANCE = "beat 120\nada $ repeat (forward || left)\nbo $ repeat (forward || right)\n"


@pytest.mark.slow("a language server and its stage play twice")
def test_save_moves_the_robot_a_wrong_one_does_not_and_stop_stops_it(page: Page, keep: Keep) -> None:
    with Client({"backend": "sim"}) as client:
        client.open(URI, DANCE)
        client.save(URI)
        client.wait_for_line("▶ ada ∞ · bo ∞, endless at beat 120, simulator")
        (url,) = client.wait_for_page()
        page.goto(url)
        wait(page, "window.improv?.robots.ada && improv.robots.ada.y > 1")
        expect(page.locator("#state")).to_have_text("playing")
        keep(page, "save-moves-the-page.png")

        problems = page.get_by_role("alert")
        expect(problems).to_be_hidden()
        client.change(URI, 2, {"text": f"{DANCE}cleo $ forwrd left\n"})
        client.save(URI)
        expect(problems).to_contain_text("dance.improv can't play: fix an error and save it again")
        expect(problems.locator("li")).to_have_text("line 4 `forwrd` is not defined: did you mean `forward`?forwrd")
        assert page.evaluate("improv.transport.state") == "playing"  # the previous dance
        page.reload()
        expect(problems.locator("code")).to_have_text("forwrd")
        client.change(URI, 3, {"text": DANCE})
        client.save(URI)
        expect(problems).to_be_hidden()

        page.get_by_role("button", name="Stop").click()
        client.wait("$/progress", lambda params: params["value"]["kind"] == "end")
        expect(page.locator("#state")).to_have_text("stopped")
        client.change(URI, 4, {"text": "beat 120\nada $ forward\n"})
        client.save(URI)
        expect(page.locator("#state")).to_have_text("ended")
        wait(page, "Math.abs(improv.robots.ada.x - 2) < 1e-3 && !improv.robots.bo")
